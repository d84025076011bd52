#!/usr/bin/env python3
"""How much trees repeat each other (`boscage score`), as rows of docs/repetition.md: individuals of each picture
of a folder, beside as many plain copies and as many scaled, recoloured ones.

usage: repetition.py BOSCAGE FOLDER [--count 20] [--size 384] [--seed 3]"""
import argparse, json, pathlib, statistics, subprocess, tempfile


def scored(options, picture):
    """The scores of copies of `picture`, of jittered copies, and of individuals of it: each in a row and in a forest."""
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "trees"
        made = [options.boscage, "vary", "--library", options.folder, "--target", picture, "--count", options.count]
        made += ["--size", options.size, "--seed", options.seed, "--out", out, "--cache", options.cache]
        subprocess.run([str(word) for word in made], check=True, capture_output=True)
        words = [options.boscage, "score", out, "--against", picture, "--seed", options.seed, "--json"]
        told = subprocess.run([str(word) for word in words], check=True, capture_output=True).stdout
    told = json.loads(told)
    return [told[kind][place] for kind in ("copies", "jittered") for place in ("row", "forest")] + [
        told["row"]["score"],
        told["forest"]["score"],
    ]


def row(name, scores):
    print(f"| {name} | " + " | ".join(f"{score:.2f}" for score in scores) + " |", flush=True)


def main():
    flags = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    flags.add_argument("boscage", type=pathlib.Path)
    flags.add_argument("folder", type=pathlib.Path)
    flags.add_argument("--count", type=int, default=20)
    flags.add_argument("--size", type=int, default=384)
    flags.add_argument("--seed", type=int, default=3)
    options = flags.parse_args()
    with tempfile.TemporaryDirectory() as options.cache:
        table(options)


def table(options):
    print("| Individuals of | copies: row | forest | jittered: row | forest | ours: row | forest |")
    print("|---|---|---|---|---|---|---|")
    pictures = sorted(options.folder.glob("*.png"))
    of_one = []
    for picture in pictures:
        of_one.append(scored(options, picture))
        row(picture.stem, of_one[-1])
    row(f"mean of {len(pictures)}", [statistics.mean(scores) for scores in zip(*of_one)])
    for place, at in (("row", 4), ("forest", 5)):
        half = sum(scores[at] <= 0.5 * scores[at - 2] for scores in of_one)
        print(f"\nAt most half of the jittered in the {place}: {half} of {len(pictures)}.")


if __name__ == "__main__":
    main()
