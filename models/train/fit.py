"""Trains the segmenter, from what ImageNet taught or from earlier weights, and writes the averaged
weights.

Loss: cross-entropy with the trunk weighted up, plus soft IoU of trunk and crown. AdamW with a rate
that falls as a cosine; pretrained layers learn slowly or, the first ones, not at all. Weights are
averaged over the run (EMA). Runs on one thread by default, in bfloat16.
"""

import argparse
import pathlib
import time

import cv2
import numpy as np
import torch
from torch.utils.data import DataLoader, IterableDataset

from augment import Maker
from network import Segmenter, pretrained
from trees import grown_trees, real_trees

CLASS_WEIGHTS = (1.0, 3.0, 1.0)
REMEMBERED = 240
REPEATS = 2
# Pretrained layers learn at this part of the rate.
SLOW = 0.2


class Stream(IterableDataset):
    """Endless examples; each worker has its own generator.

    Every example comes again about `REPEATS` times, some hundreds later, mirrored, closer and in
    another light: making one costs as much as learning from it.
    """

    def __init__(self, maker, closer, o):
        self.maker, self.closer = maker, closer
        self.seed, self.billboards, self.close_ups = o.seed, o.billboards, o.close_ups

    def made(self, rng):
        """A new example."""
        if rng.random() < self.close_ups:
            return self.maker.close_up(rng, self.closer, self.billboards)
        return self.maker.example(rng, self.billboards)

    def __iter__(self):
        cv2.setNumThreads(1)
        info = torch.utils.data.get_worker_info()
        rng = np.random.default_rng((self.seed, info.id if info else 0))
        earlier = []
        while True:
            image, labels = self.made(rng)
            yield tensors(image, labels)
            if len(earlier) < REMEMBERED:
                earlier.append((image, labels))
                continue
            for _ in range(REPEATS):
                yield tensors(*changed(rng, *earlier[rng.integers(REMEMBERED)]))
            earlier[rng.integers(REMEMBERED)] = (image, labels)


def changed(rng, image, labels):
    """The example closer, perhaps mirrored, its colours scaled."""
    size = labels.shape[0]
    closer = rng.uniform(1.0, 1.2) if rng.random() < 0.5 else 1.0
    x, y = rng.uniform(0, size * (closer - 1), 2)
    mirror = rng.random() < 0.5
    matrix = np.float32([[-closer if mirror else closer, 0, size - 1 + x if mirror else -x], [0, closer, -y]])
    planes = np.ascontiguousarray(image.transpose(1, 2, 0))
    edges = dict(borderMode=cv2.BORDER_REPLICATE)
    image = cv2.warpAffine(planes, matrix, (size, size), flags=cv2.INTER_LINEAR, **edges).transpose(2, 0, 1)
    labels = cv2.warpAffine(labels, matrix, (size, size), flags=cv2.INTER_NEAREST, **edges)
    gain = np.exp(rng.normal(0, 0.1, 3) + rng.normal(0, 0.15)).astype(np.float32)
    image = np.ascontiguousarray(image)
    image[:3] = np.clip(image[:3] * gain[:, None, None], 0, 1)
    return image, labels


def tensors(image, labels):
    return torch.from_numpy(image), torch.from_numpy(labels.astype(np.int64))


def loss_of(logits, labels, image):
    """Cross-entropy plus soft IoU loss of the two tree classes.

    Clear pixels of billboards are background by rule, so they count a tenth there.
    """
    logits = logits.float()
    each = torch.nn.functional.cross_entropy(logits, labels, torch.tensor(CLASS_WEIGHTS), reduction="none")
    clear = (image[:, 4] > 0.5) & (image[:, 3] < 0.5)
    weight = torch.where(clear, 0.1, 1.0)
    entropy = (each * weight).sum() / weight.sum()
    p = logits.softmax(1)
    total = entropy
    for kind, share in ((1, 0.6), (2, 0.4)):
        truth = (labels == kind).float()
        both = (p[:, kind] * truth).sum((1, 2))
        either = (p[:, kind] + truth - p[:, kind] * truth).sum((1, 2))
        there = (truth.sum((1, 2)) > 8).float()
        iou = (both + 1) / (either + 1)
        total = total + share * ((1 - iou) * there).sum() / there.sum().clamp(min=1)
    return total


def average(net, shadow, keep):
    """Moves the averaged weights towards the current ones."""
    with torch.no_grad():
        for name, value in net.state_dict().items():
            if value.dtype.is_floating_point:
                shadow[name].lerp_(value, 1 - keep)
            else:
                shadow[name].copy_(value)


def prepared(weights, frozen):
    """The network with earlier weights, or those of ImageNet, its first stages frozen."""
    net = Segmenter()
    if weights:
        net.load_state_dict(torch.load(weights, weights_only=True))
    else:
        pretrained(net)
    encoder = net.encoder
    encoder.frozen = frozen
    if frozen:
        for part in (encoder.stem, *encoder.stages[:frozen]):
            part.requires_grad_(False)
    return net.to(memory_format=torch.channels_last).train()


def optimised(net, rate):
    """AdamW over what is not frozen; `base` of a group is its rate."""
    slow = [p for p in net.encoder.parameters() if p.requires_grad]
    theirs = {id(p) for p in net.encoder.parameters()}
    fast = [p for p in net.parameters() if id(p) not in theirs]
    groups = [{"params": fast, "base": rate}, {"params": slow, "base": rate * SLOW}]
    return torch.optim.AdamW(groups, lr=rate, weight_decay=0.01)


def train(maker, closer, o, log=print):
    """Trains with so many examples; returns the network with averaged weights."""
    torch.manual_seed(o.seed)
    net = prepared(o.weights, o.frozen)
    shadow = {name: value.clone() for name, value in net.state_dict().items()}
    optimiser = optimised(net, o.rate)
    loader = iter(DataLoader(Stream(maker, closer, o), o.batch, num_workers=1, prefetch_factor=4))
    start, step, shown, seen = time.time(), 0, 0.0, 0
    while True:
        share = seen / o.examples
        if share >= 1:
            break
        warm = min(1.0, (step + 1) / 60)
        for group in optimiser.param_groups:
            group["lr"] = group["base"] * warm * (0.02 + 0.98 * 0.5 * (1 + np.cos(np.pi * share)))
        image, labels = next(loader)
        image = image.contiguous(memory_format=torch.channels_last)
        with torch.autocast("cpu", torch.bfloat16):
            logits = net(image)
        loss = loss_of(logits, labels, image)
        optimiser.zero_grad()
        loss.backward()
        torch.nn.utils.clip_grad_norm_(net.parameters(), 5.0)
        optimiser.step()
        average(net, shadow, min(0.99, (step + 1) / (step + 10)))
        shown = 0.97 * shown + 0.03 * loss.item() if step else loss.item()
        step, seen = step + 1, seen + o.batch
        if step % 25 == 0:
            log(f"{o.out.name} step {step} examples {seen} loss {shown:.4f} {time.time() - start:.0f} s")
            if step % 100 == 0:
                torch.save(shadow, o.out)
    net.load_state_dict(shadow)
    torch.save(shadow, o.out)
    log(f"{o.out.name}: {step} steps, {seen} examples, {time.time() - start:.0f} s, loss {shown:.4f}")
    return net.eval()


def chosen(data, real, folds):
    """Real trees to learn from: none, permissive or all; without those of the folds held out."""
    if real == "none":
        return []
    trees = real_trees(data)
    return [t for t in trees if (real == "all" or t.permissive) and t.fold not in folds]


def main():
    flags = argparse.ArgumentParser(description=__doc__)
    flags.add_argument("--grown", type=pathlib.Path, nargs="*", default=[], help="folders of labelled trees")
    flags.add_argument("--data", type=pathlib.Path, help="BOSCAGE_DATA")
    flags.add_argument("--real", choices=["none", "permissive", "all"], default="none")
    flags.add_argument("--real-share", type=float, default=0.5)
    flags.add_argument("--fold", type=int, nargs="*", default=[], help="folds of real trees to leave out")
    flags.add_argument("--weights", type=pathlib.Path, help="earlier weights; none: those of ImageNet")
    flags.add_argument("--frozen", type=int, default=3, help="pretrained stages that do not learn")
    flags.add_argument("--size", type=int, default=256)
    flags.add_argument("--batch", type=int, default=12)
    flags.add_argument("--rate", type=float, default=2e-3)
    flags.add_argument("--examples", type=int, default=6000, help="how many to learn from")
    flags.add_argument("--billboards", type=float, default=0.5)
    flags.add_argument("--close-ups", type=float, default=0.25, help="part of the examples that shows a tree's foot only")
    flags.add_argument("--seed", type=int, default=1)
    flags.add_argument("--threads", type=int, default=1)
    flags.add_argument("--out", type=pathlib.Path, required=True)
    o = flags.parse_args()
    torch.set_num_threads(o.threads)
    cv2.setNumThreads(1)
    grown = [grown_trees(folder) for folder in o.grown]
    real = chosen(o.data, o.real, o.fold)
    print(f"{[len(trees) for trees in grown]} grown trees, {len(real)} real ones: {' '.join(t.name for t in real)}", flush=True)
    maker = Maker(grown, real, o.size, o.real_share)
    closer = Maker(grown, real, o.size * 2, o.real_share) if o.close_ups else None
    train(maker, closer, o, lambda line: print(line, flush=True))


if __name__ == "__main__":
    main()
