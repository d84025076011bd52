"""Averages the weights of several stages of one training: steadier than any one of them."""

import argparse
import pathlib

import torch


def main():
    flags = argparse.ArgumentParser(description=__doc__)
    flags.add_argument("weights", type=pathlib.Path, nargs="+")
    flags.add_argument("--out", type=pathlib.Path, required=True)
    o = flags.parse_args()
    states = [torch.load(path, weights_only=True) for path in o.weights]
    mean = {}
    for name, first in states[0].items():
        mean[name] = sum(state[name] for state in states) / len(states) if first.is_floating_point() else first
    torch.save(mean, o.out)


if __name__ == "__main__":
    main()
