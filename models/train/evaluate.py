"""Scores trained weights on the real images they were not trained on, and draws every result.

Each picture is scored by the first network in the list that has not seen it: `--net WEIGHTS:FOLD`
names weights and the folds held out from them, as in `0+1` (`none` for weights that saw no real
picture, `open` for weights that saw all permissive ones).
"""

import argparse
import csv
import dataclasses
import json
import pathlib

import cv2
import numpy as np
import torch

import calibrate
import judge
from network import Segmenter
from scenes import outdoors
from trees import real_trees


def pin_table(data):
    with open(pathlib.Path(data) / "pins.csv", newline="", encoding="utf-8") as file:
        return {row["name"]: {k: int(v) for k, v in row.items() if k != "name"} for row in csv.DictReader(file)}


def pasted(tree, seed):
    """A billboard in front of a painted backdrop, without alpha: the same for every model."""
    rng = np.random.default_rng(seed)
    height, width = tree.labels.shape
    margin = int(0.12 * max(height, width))
    tall, wide = height + margin * 2, width + margin * 2
    side = max(tall, wide)
    bottom = margin + np.flatnonzero(tree.labels.any(axis=1))[-1]
    back = outdoors(rng, side, bottom - int(rng.uniform(0, 0.15) * height))[:tall, :wide]
    rgba = np.zeros((tall, wide, 4), np.float32)
    rgba[..., :3] = back
    inner = (slice(margin, margin + height), slice(margin, margin + width))
    source = tree.rgba.astype(np.float32) / 255
    alpha = source[..., 3:]
    rgba[(*inner, slice(0, 3))] = rgba[(*inner, slice(0, 3))] * (1 - alpha) + source[..., :3] * alpha
    rgba[..., 3] = 1
    labels = np.zeros((tall, wide), np.uint8)
    labels[inner] = tree.labels
    picture = (np.clip(rgba, 0, 1) * 255).astype(np.uint8)
    return dataclasses.replace(tree, rgba=picture, labels=labels, has_alpha=False)


def unseen(nets, tree):
    """The first network that was not trained on this tree."""
    for net, fold in nets:
        if fold == "none" or str(tree.fold) in fold.split("+") or (fold == "open" and not tree.permissive):
            return net
    return None


def load(path):
    net = Segmenter()
    net.load_state_dict(torch.load(path, weights_only=True))
    return net.eval()


def drawing(tree, classes, title):
    """Picture, truth and answer side by side, 220 px high."""
    rgba = tree.rgba.astype(np.float32) / 255
    alpha = rgba[..., 3:] if tree.has_alpha else 1.0
    rgb = rgba[..., :3] * alpha + np.array([0.35, 0.38, 0.6]) * (1 - alpha)
    palette = np.array([[0.05, 0.05, 0.1], [1.0, 0.55, 0.1], [0.2, 0.75, 0.25]])
    wrong = np.where((classes != tree.labels)[..., None], np.array([1.0, 0.0, 0.6]), palette[classes] * 0.5)
    row = np.hstack([rgb, palette[classes], wrong]).astype(np.float32)
    scale = 220 / row.shape[0]
    row = cv2.resize(row, (int(row.shape[1] * scale), 220), interpolation=cv2.INTER_AREA)
    row = np.clip(row, 0, 1)
    cv2.putText(row, title, (2, 10), cv2.FONT_HERSHEY_SIMPLEX, 0.33, (1.0, 1.0, 0.3), 1, cv2.LINE_AA)
    return row


def sheet(drawings, path, columns):
    if not drawings:
        return
    wide = max(d.shape[1] for d in drawings)
    cells = [cv2.copyMakeBorder(d, 0, 4, 0, wide - d.shape[1] + 4, cv2.BORDER_CONSTANT) for d in drawings]
    while len(cells) % columns:
        cells.append(np.zeros_like(cells[0]))
    rows = [np.hstack(cells[i : i + columns]) for i in range(0, len(cells), columns)]
    cv2.imwrite(str(path), (np.vstack(rows)[..., ::-1] * 255).astype(np.uint8))


def short(v):
    return "  – " if v is None else f"{v:.2f}"


def line(name, s):
    return (
        f"{name:22} {s['pictures']:3}  raw {s['raw']:.3f}  crown {s['crown']:.3f}  trunk {s['trunk']:.3f}  "
        f"mean {s['mean']:.3f}  per picture {s['per_picture']:.3f}  pins {s['pins']:.2f}  baseline {s['baseline']:.2f}"
    )


def tables(scores):
    """Means by mode and group."""
    found = {}
    for mode in ("alpha", "pasted", "photo"):
        some = [s for s in scores if s.mode == mode]
        if not some:
            continue
        found[mode] = judge.summary(some)
        for group in sorted({s.group for s in some}):
            found[f"{mode} {group}"] = judge.summary([s for s in some if s.group == group])
    return found


def main():
    flags = argparse.ArgumentParser(description=__doc__)
    flags.add_argument("--data", type=pathlib.Path, required=True)
    flags.add_argument("--net", action="append", required=True, metavar="WEIGHTS:FOLD")
    flags.add_argument("--size", type=int, default=256)
    flags.add_argument("--draw", type=pathlib.Path, help="folder for pictures of every answer")
    flags.add_argument("--json", type=pathlib.Path, help="file for all scores")
    flags.add_argument("--calibration", type=pathlib.Path, help="calibrate on these answers and write it here")
    flags.add_argument("--quick", action="store_true", help="leave out the billboards on painted backdrops")
    flags.add_argument("--quiet", action="store_true")
    o = flags.parse_args()
    torch.set_num_threads(1)
    nets = [(load(item.rsplit(":", 1)[0]), item.rsplit(":", 1)[1]) for item in o.net]
    truth = pin_table(o.data)
    shown = []
    for index, tree in enumerate(real_trees(o.data)):
        net = unseen(nets, tree)
        if net is None:
            continue
        shown.append((net, tree, truth.get(tree.name), None))
        if tree.has_alpha and not o.quick:
            shown.append((net, pasted(tree, (index, 0)), None, "pasted"))
    temperature = 1.0
    if o.calibration:
        samples = [calibrate.logits_of(net, picture, o.size) for net, picture, _, _ in shown]
        temperature = calibrate.temperature_of(samples)
    scores, drawings = [], {"alpha": [], "pasted": [], "photo": []}
    for net, picture, pin_truth, mode in shown:
        s = judge.score(net, picture, o.size, pin_truth, mode, temperature)
        scores.append(s)
        title = f"{s.name} {short(s.final[0])} {short(s.final[1])} pin {short(s.pin)}"
        drawings[s.mode].append(drawing(picture, s.classes, title))
        if not o.quiet and mode != "pasted":
            print(f"{s.name:36} {s.mode:6} raw {short(s.raw[0])} {short(s.raw[1])} final {short(s.final[0])} {short(s.final[1])} pin {short(s.pin)} base {short(s.baseline)} certainty {s.features[0]:.2f} {s.features[1]:.2f}", flush=True)
    if o.calibration:
        folds = [picture.fold for _, picture, _, _ in shown]
        calibration, report = calibrate.calibration_of(samples, temperature, scores, folds)
        o.calibration.write_text(json.dumps(calibration, indent=1) + "\n")
        print(json.dumps({**calibration, "report": report}, indent=1))
    found = tables(scores)
    for name, s in found.items():
        print(line(name, s))
    if o.json:
        plain = [{k: v for k, v in dataclasses.asdict(s).items() if k != "classes"} for s in scores]
        o.json.write_text(json.dumps({"tables": found, "scores": plain}, indent=1))
    if o.draw:
        o.draw.mkdir(parents=True, exist_ok=True)
        sheet(drawings["alpha"], o.draw / "alpha.png", 4)
        sheet(drawings["pasted"], o.draw / "pasted.png", 4)
        sheet(drawings["photo"], o.draw / "photo.png", 3)


if __name__ == "__main__":
    main()
