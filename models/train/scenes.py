"""Backdrops painted by rule: sky, meadow, tree lines, hedges, houses, roads, water, plain colours.

Nothing of them is ever labelled; they teach the network what is not the tree. Colours are float32
sRGB in 0..1, images [S, S, 3]. Other trees (grown ones) may stand behind, smaller or out of focus.
"""

import cv2
import numpy as np


def smooth_noise(rng, size, cells, octaves=3, stretch=1.0):
    """Value noise in about 0..1 of `cells` cells a side, each octave half as strong."""
    total = np.zeros((size, size), np.float32)
    weight = 0.0
    for octave in range(octaves):
        n = max(2, int(cells * 2**octave))
        m = max(2, int(n * stretch))
        if n > size:
            break
        grid = rng.random((m, n), dtype=np.float32)
        total += 0.5**octave * cv2.resize(grid, (size, size), interpolation=cv2.INTER_CUBIC)
        weight += 0.5**octave
    return total / max(weight, 1e-6)


def colour(rng, choices, spread=0.08):
    """One of the colours, changed a little."""
    base = np.array(choices[rng.integers(len(choices))], np.float32)
    return np.clip(base + rng.normal(0, spread, 3).astype(np.float32), 0, 1)


def mix(a, b, t):
    """a where t is 0, b where it is 1."""
    return a * (1 - t) + b * t


SKIES = [(0.30, 0.50, 0.85), (0.55, 0.70, 0.92), (0.80, 0.86, 0.92), (0.72, 0.74, 0.76), (0.20, 0.35, 0.65), (0.45, 0.45, 0.52)]
HORIZONS = [(0.75, 0.84, 0.93), (0.92, 0.93, 0.94), (0.95, 0.75, 0.60), (0.80, 0.80, 0.78), (0.60, 0.72, 0.88)]
CLOUDS = [(1.0, 1.0, 1.0), (0.85, 0.86, 0.88), (0.55, 0.56, 0.60), (0.98, 0.80, 0.72)]
GRASS = [(0.36, 0.48, 0.16), (0.45, 0.55, 0.25), (0.25, 0.36, 0.12), (0.55, 0.52, 0.28), (0.62, 0.55, 0.36), (0.30, 0.42, 0.22)]
GROUNDS = [(0.50, 0.48, 0.46), (0.62, 0.60, 0.57), (0.45, 0.36, 0.27), (0.35, 0.35, 0.36), (0.92, 0.93, 0.95), (0.70, 0.62, 0.48)]
LEAVES = [(0.20, 0.30, 0.12), (0.30, 0.40, 0.15), (0.14, 0.22, 0.12), (0.45, 0.40, 0.14), (0.50, 0.28, 0.14), (0.30, 0.12, 0.15), (0.25, 0.35, 0.25), (0.42, 0.36, 0.30)]
WALLS = [(0.75, 0.72, 0.68), (0.60, 0.35, 0.27), (0.85, 0.83, 0.78), (0.50, 0.50, 0.52), (0.80, 0.72, 0.55)]


def sky(rng, size):
    """A gradient, often with clouds."""
    down = np.linspace(0, 1, size, dtype=np.float32)[:, None, None] ** rng.uniform(0.6, 1.8)
    picture = mix(colour(rng, SKIES), colour(rng, HORIZONS), down)
    picture = np.broadcast_to(picture, (size, size, 3)).copy()
    if rng.random() < 0.55:
        cover = smooth_noise(rng, size, rng.integers(2, 6), 4, rng.uniform(1, 2.5))
        edge = rng.uniform(0.35, 0.62)
        soft = rng.uniform(0.05, 0.25)
        cover = np.clip((cover - edge) / soft, 0, 1)[..., None] * rng.uniform(0.4, 1.0)
        picture = mix(picture, colour(rng, CLOUDS, 0.03), cover)
    return picture


def textured(rng, size, base, contrast, cells, stretch=1.0):
    """A colour with grain."""
    grain = smooth_noise(rng, size, cells, 4, stretch)[..., None] - 0.5
    fine = rng.normal(0, 0.25, (size, size, 1)).astype(np.float32)
    hue = (smooth_noise(rng, size, max(2, cells // 3), 2)[..., None] - 0.5) * rng.normal(0, 0.12, 3).astype(np.float32)
    return base * (1 + contrast * (2 * grain + 0.5 * fine)) + hue * contrast


def ground(rng, picture, horizon):
    """Meadow, road, soil, snow or water below the horizon, perhaps in strips."""
    size = picture.shape[0]
    base = colour(rng, GRASS if rng.random() < 0.7 else GROUNDS)
    land = textured(rng, size, base, rng.uniform(0.1, 0.6), rng.integers(8, 40), rng.uniform(1.0, 3.0))
    picture[horizon:] = land[horizon:]
    for _ in range(rng.integers(0, 3)):
        top = rng.integers(horizon, size)
        thick = int(rng.uniform(0.01, 0.2) * size)
        strip = textured(rng, size, colour(rng, GRASS + GROUNDS), rng.uniform(0.05, 0.3), 20)
        shift = (np.arange(size) - size / 2) * rng.normal(0, 0.12)
        rows = np.arange(size)[:, None] - shift[None, :]
        inside = (rows >= top) & (rows < top + thick) & (np.arange(size)[:, None] >= horizon)
        picture[inside] = strip[inside]


def tree_line(rng, picture, horizon):
    """Foliage with a ragged top, as a hedge or a wood behind."""
    size = picture.shape[0]
    tall = rng.uniform(0.03, 0.45) * size
    wave = cv2.resize(rng.random((1, rng.integers(3, 14)), dtype=np.float32), (size, 1), interpolation=cv2.INTER_CUBIC)[0]
    ragged = cv2.resize(rng.random((1, size // 4), dtype=np.float32), (size, 1))[0]
    top = horizon - tall * (0.4 + 0.8 * wave + 0.15 * ragged)
    rows = np.arange(size, dtype=np.float32)[:, None]
    holes = smooth_noise(rng, size, 30, 2) * rng.uniform(0, 12)
    inside = (rows > top[None, :] + holes) & (rows < horizon + rng.uniform(0, 0.06) * size)
    if rng.random() < 0.35:
        left, right = np.sort(rng.integers(0, size, 2))
        inside[:, :left] = False
        inside[:, right:] = False
    leaves = textured(rng, size, colour(rng, LEAVES), rng.uniform(0.3, 1.1), rng.integers(12, 60))
    lit = np.clip(1.25 - (rows - top[None, :]) / max(tall, 1) * rng.uniform(0, 0.8), 0.4, 1.3)[..., None]
    haze = rng.uniform(0, 0.45) if rng.random() < 0.5 else 0.0
    leaves = mix(leaves * lit, colour(rng, HORIZONS), haze)
    picture[inside] = leaves[inside]


def house(rng, picture, horizon):
    """A wall with windows and a roof."""
    size = picture.shape[0]
    wide, tall = int(rng.uniform(0.1, 0.7) * size), int(rng.uniform(0.05, 0.7) * size)
    left = rng.integers(-wide // 2, size)
    top = max(0, horizon - tall)
    right = min(size, left + wide)
    left = max(0, left)
    if right - left < 8 or horizon - top < 8:
        return
    wall = textured(rng, size, colour(rng, WALLS), rng.uniform(0.02, 0.15), 10)
    picture[top:horizon, left:right] = wall[top:horizon, left:right]
    step_x, step_y = rng.integers(6, 30), rng.integers(6, 30)
    dark = colour(rng, [(0.15, 0.17, 0.20), (0.45, 0.52, 0.60), (0.85, 0.85, 0.85)])
    for y in range(top + step_y // 3, horizon - step_y // 2, step_y):
        for x in range(left + step_x // 3, right - step_x // 2, step_x):
            picture[y : y + step_y // 2, x : x + step_x // 2] = dark
    if rng.random() < 0.5:
        peak = max(0, top - int(rng.uniform(0.03, 0.2) * size))
        corners = np.array([[left - 3, top], [right + 3, top], [(left + right) // 2, peak]], np.int32)
        roof = [float(v) for v in colour(rng, [(0.45, 0.25, 0.2), (0.3, 0.3, 0.32), (0.5, 0.45, 0.4)])]
        cv2.fillPoly(picture, [corners], roof)


def poles(rng, picture, horizon):
    """Posts, fences, poles and bare stems: upright things that are no trunk of ours."""
    size = picture.shape[0]
    for _ in range(rng.integers(1, 5)):
        x, thick = rng.integers(0, size), int(rng.integers(1, max(2, size // 40)))
        top = int(horizon - rng.uniform(0.02, 0.6) * size)
        bottom = int(horizon + rng.uniform(0, 0.2) * size)
        shade = [float(v) for v in colour(rng, WALLS + GROUNDS + LEAVES)]
        cv2.line(picture, (int(x), top), (int(x + rng.normal(0, 4)), bottom), shade, thick, cv2.LINE_AA)
    if rng.random() < 0.3:
        y = int(horizon + rng.uniform(-0.05, 0.15) * size)
        cv2.line(picture, (0, y), (size, y + int(rng.normal(0, 5))), [float(v) for v in colour(rng, WALLS)], 2, cv2.LINE_AA)


def plain(rng, size):
    """A studio ground: one colour, a gradient, or noise, as in cut-outs on white."""
    kind = rng.random()
    if kind < 0.4:
        shade = np.full(3, rng.choice([0.0, 1.0, 0.5, 0.93]), np.float32)
    else:
        shade = rng.random(3).astype(np.float32)
    picture = np.broadcast_to(shade, (size, size, 3)).copy()
    if kind > 0.7:
        other = rng.random(3).astype(np.float32)
        picture = mix(picture, other, np.linspace(0, 1, size, dtype=np.float32)[:, None, None])
    if rng.random() < 0.3:
        picture = picture + (smooth_noise(rng, size, rng.integers(3, 60), 3)[..., None] - 0.5) * rng.uniform(0, 0.4)
    return picture


def outdoors(rng, size, horizon):
    """A landscape whose far edge lies at row `horizon`."""
    picture = sky(rng, size)
    horizon = int(np.clip(horizon, 4, size - 2))
    far = horizon
    for _ in range(rng.integers(0, 3)):
        if rng.random() < 0.3:
            house(rng, picture, far)
        else:
            tree_line(rng, picture, far)
    ground(rng, picture, horizon)
    if rng.random() < 0.3:
        house(rng, picture, horizon + int(rng.uniform(0, 0.05) * size))
    if rng.random() < 0.5:
        tree_line(rng, picture, horizon + int(rng.uniform(0, 0.08) * size))
    if rng.random() < 0.35:
        poles(rng, picture, horizon)
    return np.clip(picture, 0, 1).astype(np.float32)
