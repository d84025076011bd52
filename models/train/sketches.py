"""Trees sketched by rule, thousands of shapes at a few milliseconds each, with exact labels.

They are cruder than the trees that `boscage samples` grows, but every one has another habit: broad,
columnar, weeping, coniferous, palm, bare, shrub. Foliage is stamped behind and in front of wood.
Labels follow those that people draw: stem and limbs below the foliage are trunk, limbs seen inside
the crown are crown; of a bare tree the stem below its first limb is trunk.
"""

import cv2
import numpy as np

from scenes import colour, smooth_noise
from trees import BACKGROUND, CROWN, TRUNK, Tree

TALL = 420
WIDE = 420
LEAF_COLOURS = [(0.25, 0.36, 0.12), (0.38, 0.48, 0.18), (0.16, 0.25, 0.12), (0.48, 0.52, 0.22), (0.66, 0.52, 0.14), (0.62, 0.28, 0.12), (0.38, 0.14, 0.16), (0.36, 0.42, 0.36), (0.22, 0.30, 0.24)]
BARK_COLOURS = [(0.34, 0.28, 0.22), (0.45, 0.42, 0.38), (0.24, 0.20, 0.17), (0.44, 0.32, 0.23), (0.76, 0.74, 0.70), (0.55, 0.46, 0.36), (0.38, 0.38, 0.34)]
HABITS = {"broad": 0.34, "column": 0.07, "weeping": 0.07, "conifer": 0.26, "palm": 0.08, "bare": 0.09, "bare_conifer": 0.04, "shrub": 0.05}


class Canvas:
    """Wood and foliage being painted; foliage behind the wood and before it."""

    def __init__(self, rng):
        self.rng = rng
        self.wood = np.zeros((TALL, WIDE), np.float32)
        self.trunk = np.zeros((TALL, WIDE), np.uint8)
        self.back = np.zeros((TALL, WIDE, 4), np.float32)
        self.front = np.zeros((TALL, WIDE, 4), np.float32)
        self.leaf = colour(rng, LEAF_COLOURS, 0.05)
        self.bark = colour(rng, BARK_COLOURS, 0.04)

    def limb(self, points, thick0, thick1, stem=False):
        """A tapering limb along a polyline; shading runs across it."""
        points = np.asarray(points, np.float32)
        for i in range(len(points) - 1):
            t = i / max(1, len(points) - 1)
            thick = max(1.0, thick0 + (thick1 - thick0) * t)
            a, b = points[i], points[i + 1]
            ends = [tuple(int(v * 8) for v in p) for p in (a, b)]
            cv2.line(self.wood, *ends, 0.75, max(1, round(thick)), cv2.LINE_AA, 3)
            if thick > 3:
                offset = np.array([thick * 0.2, 0])
                lit = [tuple(int(v * 8) for v in p - offset) for p in (a, b)]
                cv2.line(self.wood, *lit, 1.0, max(1, round(thick * 0.45)), cv2.LINE_AA, 3)
            if stem:
                cv2.line(self.trunk, *ends, 255, max(1, round(thick) + 2), cv2.LINE_8, 3)

    def leaves(self, xy, size, light, front=0.5, streak=(0.0, 0.0)):
        """Stamps of `size` pixels at xy [N, 2] with brightness `light` [N]."""
        rng = self.rng
        n = len(xy)
        tint = self.leaf * (1 + rng.normal(0, 0.12, (n, 3))) * light[:, None]
        before = rng.random(n) < front
        angle = rng.uniform(0, np.pi, n)
        for layer, mask in ((self.back, ~before), (self.front, before)):
            p, c, a = xy[mask], tint[mask], angle[mask]
            shade = 0.7 if layer is self.back else 1.0
            for k in np.linspace(-size / 2, size / 2, max(2, int(size * 1.2) + 1)):
                for w in range(1 if size < 3 else 2):
                    dx = np.cos(a) * k + streak[0] * k + w
                    dy = np.sin(a) * k * 0.7 + streak[1] * k
                    x, y = (p[:, 0] + dx).astype(int), (p[:, 1] + dy).astype(int)
                    ok = (x >= 0) & (x < WIDE) & (y >= 0) & (y < TALL)
                    layer[y[ok], x[ok], :3] = c[ok] * shade * (1 + 0.06 * k)
                    layer[y[ok], x[ok], 3] = 1

    def flattened(self, habit, bare_from=None):
        """The tree; `bare_from` is the row of the first limb of a bare tree."""
        rng = self.rng
        streaks = smooth_noise(rng, TALL, rng.integers(20, 60), 3, rng.uniform(0.15, 0.8))[:, :WIDE]
        tone = self.wood * (0.65 + 0.7 * streaks) * (1.1 - 0.3 * (np.arange(TALL) < TALL * 0.4)[:, None])
        wood_alpha = np.clip(self.wood * 1.6, 0, 1)
        rgb = self.back[..., :3].copy()
        alpha = self.back[..., 3].copy()
        rgb = rgb * (1 - wood_alpha[..., None]) + self.bark * tone[..., None] * wood_alpha[..., None]
        alpha = np.maximum(alpha, wood_alpha)
        front = self.front[..., 3] > 0
        rgb = np.where(front[..., None], self.front[..., :3], rgb)
        alpha = np.where(front, 1.0, alpha)
        leafy = front | ((self.back[..., 3] > 0) & (wood_alpha < 0.5))
        if bare_from is None:
            inside = crown_region(leafy, palm=habit == "palm")
            trunk = (wood_alpha > 0.3) & ~front & ~inside & (self.trunk > 0)
            trunk = standing(trunk)
        else:
            trunk = (self.trunk > 0) & ~front & (np.arange(TALL) > bare_from)[:, None]
        labels = np.where(alpha >= 0.5, np.where(trunk, TRUNK, CROWN), BACKGROUND).astype(np.uint8)
        soft = cv2.GaussianBlur(np.dstack([rgb * alpha[..., None], alpha]), (0, 0), rng.uniform(0.4, 0.8))
        out = np.zeros((TALL, WIDE, 4), np.float32)
        out[..., 3] = soft[..., 3]
        out[..., :3] = soft[..., :3] / np.maximum(soft[..., 3:], 1e-3)
        return (np.clip(out, 0, 1) * 255).astype(np.uint8), np.where(soft[..., 3] >= 0.5, labels, BACKGROUND).astype(np.uint8)


def crown_region(leafy, palm):
    """Where limbs count as crown: among foliage, and in the gaps between its lobes."""
    cover = cv2.blur(leafy.astype(np.float32), (25, 17))
    if palm:
        return cover > 0.5
    dense = np.pad((cover > 0.2).astype(np.uint8), 80)
    closed = cv2.morphologyEx(dense, cv2.MORPH_CLOSE, cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (111, 71)))
    return closed[80:-80, 80:-80] > 0


def standing(trunk):
    """The part of a trunk that reaches the foot."""
    count, parts = cv2.connectedComponents(trunk.astype(np.uint8))
    rows = np.flatnonzero(trunk.any(axis=1))
    if count <= 1 or len(rows) == 0:
        return trunk
    low = np.unique(parts[rows[-1] - 12 : rows[-1] + 1])
    return np.isin(parts, low[low > 0])


def wander(rng, start, end, bend, steps=12):
    """A crooked path between two points."""
    t = np.linspace(0, 1, steps)[:, None]
    path = np.array(start) * (1 - t) + np.array(end) * t
    sway = np.cumsum(rng.normal(0, 1, (steps, 1)), axis=0)
    sway -= sway[0] + (sway[-1] - sway[0]) * t
    path[:, :1] += sway * bend
    return path


def stem(rng, canvas, foot, top, thick, bend, taper=0.6):
    """A stem with a flared foot."""
    path = wander(rng, foot, top, bend, 14)
    canvas.limb(path, thick, thick * taper, stem=True)
    if rng.random() < 0.7:
        flare = path[:3] if len(path) > 3 else path
        canvas.limb([flare[0], (flare[0] + flare[1]) / 2], thick * rng.uniform(1.15, 1.7), thick, stem=True)
    return path


def shading(rng, xy, low, high, centre):
    """Light from above and one side, darker inside, with patches."""
    side = rng.uniform(-0.5, 0.5)
    rise = (high - xy[:, 1]) / max(1, high - low)
    across = (xy[:, 0] - centre) / WIDE
    return np.clip(0.65 + 0.5 * rise + side * across + rng.normal(0, 0.2, len(xy)), 0.25, 1.7)


def broad(rng, canvas, habit):
    """A crown of lobes upon limbs: broad, columnar, weeping, or a shrub without a stem."""
    foot = np.array([WIDE / 2 + rng.normal(0, 8), TALL - 2.0])
    bare = {"broad": rng.uniform(0.08, 0.42), "column": rng.uniform(0.04, 0.25), "weeping": rng.uniform(0.1, 0.3), "shrub": rng.uniform(0.0, 0.06)}[habit]
    radius = {"broad": rng.uniform(0.2, 0.47), "column": rng.uniform(0.1, 0.2), "weeping": rng.uniform(0.25, 0.42), "shrub": rng.uniform(0.3, 0.47)}[habit] * WIDE
    top = 8 + rng.uniform(0, 20)
    height = TALL - top
    if habit == "shrub":
        height *= rng.uniform(0.4, 0.9)
        top = TALL - height
    base = TALL - bare * height
    thick = rng.uniform(0.02, 0.075) * height * (0.6 if habit in ("column", "shrub") else 1)
    centre = np.array([foot[0] + rng.normal(0, 10), (top + base) / 2])
    half = (base - top) / 2
    stems = rng.choice([1, 1, 1, 2, 3]) if habit != "shrub" else rng.integers(3, 7)
    fork = base + rng.uniform(-0.3, 0.25) * half
    tops = []
    if stems == 1 or rng.random() < 0.5:
        tops = [stem(rng, canvas, foot, (centre[0] + rng.normal(0, 6), min(fork, TALL - 6)), thick, rng.uniform(0, 3))[-1]]
    else:
        for i in range(stems):
            spread = (i - (stems - 1) / 2) * thick * rng.uniform(0.6, 1.5)
            end = (centre[0] + spread * rng.uniform(2, 6), min(fork, TALL - 6))
            tops.append(stem(rng, canvas, foot + [spread, 0], end, thick / stems**0.6, rng.uniform(0, 3))[-1])
    for start in tops:
        for _ in range(rng.integers(3, 9)):
            angle = rng.uniform(-1.2, 1.2)
            reach = rng.uniform(0.4, 0.95)
            end = (centre[0] + np.sin(angle) * radius * reach, centre[1] - np.cos(angle) * half * reach * rng.uniform(0.1, 0.9))
            canvas.limb(wander(rng, start, end, rng.uniform(1, 4)), thick * rng.uniform(0.3, 0.6), 1, stem=True)
    foliage(rng, canvas, habit, centre, radius, half, top, base)


def foliage(rng, canvas, habit, centre, radius, half, top, base):
    """Lobes of leaves inside an egg; weeping trees hang strands from it."""
    lobes = int(rng.integers(20, 100))
    angle, dist = rng.uniform(0, 2 * np.pi, lobes), np.sqrt(rng.random(lobes)) * rng.uniform(0.75, 0.95)
    egg = 1 - rng.uniform(0, 0.5) * np.sin(-angle).clip(0) if rng.random() < 0.7 else np.ones(lobes)
    centres = np.stack([centre[0] + np.cos(angle) * dist * radius * egg, centre[1] + np.sin(angle) * dist * half], 1)
    flat = rng.uniform(0.35, 0.9)
    spread = radius * rng.uniform(0.1, 0.28)
    each = int(rng.uniform(100, 500))
    which = np.repeat(np.arange(lobes), each)
    offset = rng.normal(0, 1, (len(which), 2)) * [spread, spread * flat] * 0.6
    xy = centres[which] + offset
    lobe_light = 1 - 0.3 * offset[:, 1] / spread
    size = rng.uniform(1.5, 5)
    streak = (0.0, 0.0)
    if habit == "weeping":
        fall = rng.exponential(rng.uniform(15, 60), len(xy))
        xy[:, 1] += fall
        streak = (0.0, rng.uniform(1.0, 3.0))
        xy = xy[xy[:, 1] < TALL - rng.uniform(2, 40)]
        lobe_light = np.ones(len(xy))
    keep = xy[:, 1] < base + rng.uniform(0, 0.3) * half
    xy, lobe_light = xy[keep], lobe_light[keep]
    canvas.leaves(xy, size, shading(rng, xy, top, base, centre[0]) * lobe_light, rng.uniform(0.35, 0.85), streak)


def conifer(rng, canvas, habit):
    """A straight stem with whorls of boughs that shorten upwards; bare ones have no needles."""
    bare = habit == "bare_conifer"
    top = 4.0
    foot = np.array([WIDE / 2 + rng.normal(0, 5), TALL - 2.0])
    clear = rng.uniform(0.01, 0.14) if rng.random() < 0.8 else rng.uniform(0.15, 0.55)
    base = TALL - clear * (TALL - top)
    thick = rng.uniform(0.012, 0.05) * TALL
    tip = (foot[0] + rng.normal(0, 5), top)
    path = stem(rng, canvas, foot, tip, thick, rng.uniform(0, 0.8), 0.12)
    widest = rng.uniform(0.1, 0.36) * WIDE
    power = rng.uniform(0.6, 1.4)
    droop = rng.uniform(-0.5, 0.7)
    levels = int(rng.integers(10, 46))
    density = rng.uniform(3.5, 12.0)
    size = rng.uniform(1.2, 4.5)
    hang = rng.uniform(1.0, 9.0)
    for level in np.linspace(0, 1, levels):
        y = base + (top - base) * level
        axis = np.interp(y, path[::-1, 1], path[::-1, 0])
        for side in (-1, 1, -1, 1):
            length = widest * (1 - level) ** power * rng.uniform(0.55, 1.1) + 3
            if rng.random() < 0.4:
                length *= rng.uniform(0.1, 0.7)
            t = np.linspace(0, 1, 9)
            x = axis + side * length * t
            bough = y + length * (droop * t - rng.uniform(0, 0.4) * droop * t**2) + rng.normal(0, 2)
            canvas.limb(np.stack([x, bough], 1), max(1, thick * 0.18 * (1 - level)), 1)
            if bare:
                for k in range(1, 8):
                    end = (x[k] + side * rng.uniform(2, 12), bough[k] + rng.normal(0, 6))
                    canvas.limb([(x[k], bough[k]), end], 1, 1)
                continue
            n = int(length * density)
            s = rng.random(n)
            xy = np.stack([np.interp(s, t, x), np.interp(s, t, bough)], 1)
            xy += np.stack([rng.normal(0, 2, n), rng.normal(hang * 0.3, hang * 0.7, n)], 1)
            xy = xy[xy[:, 1] < TALL - 1]
            light = np.clip(0.6 + 0.45 * np.abs(xy[:, 0] - axis) / (widest + 1) - 0.03 * (xy[:, 1] - np.interp(xy[:, 0] * side, x * side, bough)) + rng.normal(0, 0.2, len(xy)), 0.2, 1.6)
            canvas.leaves(xy, size, light, 0.6, (0.0, rng.uniform(0, 0.5)))
    return base + rng.uniform(0, 4)


def palm(rng, canvas, habit):
    """One or two curved stems, each with a head of fronds."""
    for _ in range(1 if rng.random() < 0.75 else 2):
        foot = np.array([WIDE / 2 + rng.normal(0, 12), TALL - 2.0])
        tall = rng.uniform(0.12, 0.85) * TALL
        reach = min(WIDE * 0.45, rng.uniform(0.15, 0.45) * WIDE)
        head = np.array([foot[0] + rng.normal(0, 0.12) * tall, max(TALL - tall, reach * 0.6 + 6)])
        thick = rng.uniform(0.025, 0.07) * TALL * (1.6 if tall < 0.3 * TALL else 1)
        stem(rng, canvas, foot, head, thick, rng.uniform(0, 2), rng.uniform(0.6, 1.1))
        for _ in range(rng.integers(14, 50)):
            angle = rng.uniform(-2.3, 2.3)
            length = reach * rng.uniform(0.6, 1.0)
            t = np.linspace(0, 1, 26)
            x = head[0] + np.sin(angle) * length * t
            y = head[1] - np.cos(angle) * length * 0.75 * t + rng.uniform(0.2, 0.7) * length * t**2
            light = rng.uniform(0.6, 1.3)
            long = rng.uniform(6, 20)
            n = rng.integers(80, 260)
            s = rng.random(n)
            drop = rng.random(n) * long * np.sin(np.pi * np.clip(s, 0.08, 1)) ** 0.5
            side = rng.choice([-0.5, 0.5], n)
            xy = np.stack([np.interp(s, t, x) + side * drop + np.sin(angle) * drop * 0.5, np.interp(s, t, y) + drop * rng.uniform(0.2, 0.9)], 1)
            canvas.leaves(xy, 2.5, np.full(n, light) * (1 + rng.normal(0, 0.15, n)), 0.7, (0.3, 0.6))


def bare(rng, canvas, habit):
    """A leafless broadleaf by recursive forks."""
    foot = np.array([WIDE / 2 + rng.normal(0, 6), TALL - 2.0])
    clear = rng.uniform(0.05, 0.4)
    fork = TALL - clear * TALL
    thick = rng.uniform(0.025, 0.07) * TALL
    leader = rng.random() < 0.5
    top = (foot[0] + rng.normal(0, 8), 10.0 if leader else fork)
    stem(rng, canvas, foot, top, thick, rng.uniform(0, 2), 0.15 if leader else 0.75)
    spread = rng.uniform(0.35, 0.9)

    def branch(start, angle, length, width, depth):
        end = start + length * np.array([np.sin(angle), -np.cos(angle)])
        canvas.limb(wander(rng, start, end, length * 0.02, 6), width, width * 0.7)
        if depth == 0 or length < 5:
            return
        for _ in range(rng.integers(2, 4)):
            along = rng.uniform(0.35, 1.0)
            branch(start + (end - start) * along, angle + rng.normal(0, spread), length * rng.uniform(0.5, 0.8), max(1, width * 0.6), depth - 1)

    starts = np.linspace(fork, 30, rng.integers(6, 14)) if leader else [fork] * rng.integers(3, 7)
    for y in starts:
        side = rng.choice([-1, 1]) * rng.uniform(0.15, 1.3)
        left = (y - 10) if leader else TALL * (1 - clear)
        x = np.interp(y, [top[1], foot[1]], [top[0], foot[0]]) if leader else top[0]
        branch(np.array([x, y]), side, left * rng.uniform(0.25, 0.5), max(1.5, thick * 0.5 * (y / TALL)), 4)
    return fork + thick * 0.3


PAINTERS = {"broad": broad, "column": broad, "weeping": broad, "shrub": broad, "conifer": conifer, "bare_conifer": conifer, "palm": palm, "bare": bare}


def sketch(rng):
    """One random tree."""
    habit = rng.choice(list(HABITS), p=list(HABITS.values()))
    canvas = Canvas(rng)
    bare_from = PAINTERS[habit](rng, canvas, habit)
    rgba, labels = canvas.flattened(habit, bare_from)
    columns = np.flatnonzero(labels.any(axis=0))
    rows = np.flatnonzero(labels.any(axis=1))
    crop = (slice(max(0, rows[0] - 2), TALL), slice(max(0, columns[0] - 2), columns[-1] + 3))
    return Tree(f"sketch_{habit}", rgba[crop].copy(), labels[crop].copy(), True, origin="sketch")


def sketches(count, seed):
    """So many random trees, the same for the same seed."""
    return [sketch(np.random.default_rng((seed, i))) for i in range(count)]


def main():
    """Writes sketches as `boscage samples` writes trees, for all later steps to read."""
    import argparse
    import pathlib

    from PIL import Image

    flags = argparse.ArgumentParser(description=__doc__)
    flags.add_argument("--count", type=int, default=700)
    flags.add_argument("--seed", type=int, default=1)
    flags.add_argument("--out", type=pathlib.Path, required=True)
    o = flags.parse_args()
    cv2.setNumThreads(1)
    (o.out / "labels").mkdir(parents=True, exist_ok=True)
    for i in range(o.count):
        tree = sketch(np.random.default_rng((o.seed, i)))
        name = f"{tree.name}_{i:04}"
        Image.fromarray(tree.rgba).save(o.out / f"{name}.png", compress_level=1)
        grey = np.array([0, 128, 255], np.uint8)[tree.labels]
        Image.fromarray(grey).save(o.out / "labels" / f"{name}.labels.png", compress_level=1)


if __name__ == "__main__":
    main()
