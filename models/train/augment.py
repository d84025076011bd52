"""Random training examples: a labelled tree, changed in every way trees and pictures differ.

An example is what the network gets (float32 [5, S, S]) and the class of each pixel (uint8 [S, S]).
Half are billboards (alpha kept), half are pictures without alpha: trees composited into painted
backdrops, and photographs. All work happens at the size of the network, so it is quick.
"""

import dataclasses

import cv2
import numpy as np

import scenes
from scenes import colour, mix, smooth_noise
from trees import BACKGROUND, CROWN, TRUNK, Tree, shrunk

CROWNS = [(0.28, 0.38, 0.14), (0.40, 0.48, 0.18), (0.18, 0.27, 0.13), (0.62, 0.52, 0.14), (0.62, 0.30, 0.12), (0.50, 0.16, 0.14), (0.30, 0.14, 0.18), (0.40, 0.46, 0.36), (0.52, 0.58, 0.24), (0.25, 0.34, 0.26), (0.85, 0.72, 0.76)]
BARKS = [(0.32, 0.26, 0.20), (0.45, 0.42, 0.38), (0.22, 0.19, 0.16), (0.42, 0.30, 0.22), (0.78, 0.76, 0.72), (0.55, 0.46, 0.36), (0.35, 0.36, 0.32), (0.60, 0.57, 0.54), (0.50, 0.32, 0.20)]
SNOW = (0.92, 0.94, 0.98)


@dataclasses.dataclass
class Layer:
    """A tree on the canvas: colours [S, S, 3] and alpha [S, S] in 0..1, classes [S, S]."""

    rgb: np.ndarray
    alpha: np.ndarray
    labels: np.ndarray


def luminance(rgb):
    return rgb @ np.array([0.30, 0.59, 0.11], np.float32)


def hue_rotation(angle, saturation):
    """3×3 matrix that turns hues by `angle` and scales saturation, keeping luminance."""
    to_yiq = np.array([[0.299, 0.587, 0.114], [0.596, -0.274, -0.322], [0.211, -0.523, 0.312]])
    c, s = np.cos(angle) * saturation, np.sin(angle) * saturation
    turn = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    return (np.linalg.inv(to_yiq) @ turn @ to_yiq).astype(np.float32)


def recoloured(rng, rgb, where, palette, share):
    """Luminance times a palette's colour, blended in by `share`, where the mask says."""
    light = luminance(rgb)
    mean = float(light[where].mean()) if where.any() else 0.0
    if mean < 0.01:
        return rgb
    target = colour(rng, palette)
    tinted = (light / mean)[..., None] * target
    return np.where(where[..., None], mix(rgb, tinted, share), rgb)


def stretched_trunk(rng, tree):
    """The tree with its trunk made longer, shorter, thicker or thinner."""
    rows = np.flatnonzero((tree.labels == TRUNK).any(axis=1))
    height, width = tree.labels.shape
    if len(rows) < 4:
        return tree
    crown_rows = np.flatnonzero((tree.labels == CROWN).any(axis=1))
    base = int(np.quantile(crown_rows, 0.97)) if len(crown_rows) else int(rows[0])
    base = int(np.clip(max(base, rows[0]), 0, height - 3))
    longer = float(np.exp(rng.uniform(np.log(0.35), np.log(2.2))))
    thicker = float(np.exp(rng.uniform(np.log(0.6), np.log(1.8))))
    below = max(2, round((height - base) * longer))
    source_y = np.concatenate([np.arange(base), base + np.arange(below) * (height - base) / below]).astype(np.float32)
    columns = np.flatnonzero((tree.labels[rows[0] :] == TRUNK).any(axis=0))
    axis = float(columns.mean())
    t = np.clip((source_y - base) / (0.06 * height), 0, 1)
    factor = 1 + (thicker - 1) * t
    x = np.arange(width, dtype=np.float32)[None, :]
    source_x = (axis + (x - axis) / factor[:, None]).astype(np.float32)
    source_y = np.repeat(source_y[:, None], width, axis=1)
    clear = (tree.rgba[..., 3] > 0)[..., None]
    rgba = cv2.remap(np.where(clear, tree.rgba, 0), source_x, source_y, cv2.INTER_LINEAR, borderValue=0)
    labels = cv2.remap(tree.labels, source_x, source_y, cv2.INTER_NEAREST, borderValue=0)
    return dataclasses.replace(tree, rgba=rgba, labels=labels)


def skirted(rng, tree):
    """The tree with foliage of its own hung over the upper part of its trunk."""
    trunk = np.argwhere(tree.labels == TRUNK)
    crown = tree.labels == CROWN
    if len(trunk) < 20 or crown.sum() < 200:
        return tree
    top, bottom = trunk[:, 0].min(), trunk[:, 0].max()
    left, right = trunk[:, 1].min(), trunk[:, 1].max()
    height, width = tree.labels.shape
    rgba, labels = tree.rgba.copy(), tree.labels.copy()
    reach = top + (bottom - top) * rng.uniform(0.1, 1.2)
    for _ in range(rng.integers(3, 14)):
        w, h = int(rng.uniform(0.06, 0.25) * width) + 3, int(rng.uniform(0.03, 0.12) * height) + 3
        y0 = int(rng.uniform(0, max(1, top)))
        x0 = int(rng.uniform(0, max(1, width - w)))
        y1 = int(rng.uniform(top - h, reach - h))
        x1 = int(rng.uniform(left - w, right))
        if y1 < 0 or x1 < 0 or x1 + w > width or y1 + h > height or y0 + h > height:
            continue
        part, kind = tree.rgba[y0 : y0 + h, x0 : x0 + w], crown[y0 : y0 + h, x0 : x0 + w]
        yy, xx = np.mgrid[-1 : 1 : h * 1j, -1 : 1 : w * 1j]
        take = kind & (yy**2 + xx**2 < rng.uniform(0.6, 1.0)) & (part[..., 3] > 127)
        rgba[y1 : y1 + h, x1 : x1 + w][take] = part[take]
        labels[y1 : y1 + h, x1 : x1 + w][take] = CROWN
    return dataclasses.replace(tree, rgba=rgba, labels=labels)


def footless(tree):
    """The tree without its trunk, as when it is hidden or cut off."""
    rgba, labels = tree.rgba.copy(), tree.labels.copy()
    trunk = cv2.dilate((labels == TRUNK).astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    trunk &= labels != CROWN
    rgba[trunk], labels[trunk] = 0, BACKGROUND
    return dataclasses.replace(tree, rgba=rgba, labels=labels)


def cutout(tree):
    """A photograph's tree as a billboard: its labels become the alpha."""
    alpha = cv2.GaussianBlur((tree.labels > 0).astype(np.float32) * 255, (0, 0), 0.7)
    alpha = np.clip((alpha - 90) * 2.2, 0, 255)
    rgba = tree.rgba.copy()
    rgba[..., 3] = alpha.astype(np.uint8)
    return dataclasses.replace(tree, rgba=rgba, has_alpha=True)


def emptied(tree):
    """A photograph without its tree: what stood around it, spread over the gap."""
    hole = cv2.dilate((tree.labels > 0).astype(np.uint8), np.ones((9, 9), np.uint8))
    return cv2.inpaint(np.ascontiguousarray(tree.rgba[..., :3]), hole, 5, cv2.INPAINT_TELEA)


def warp(layer_rgba, labels, matrix, size):
    """Straight RGBA and labels through an affine map onto the canvas."""
    work = layer_rgba.astype(np.float32) / 255.0
    work[..., :3] *= work[..., 3:]
    work = cv2.warpAffine(work, matrix, (size, size), flags=cv2.INTER_LINEAR)
    alpha = np.clip(work[..., 3], 0, 1)
    rgb = np.where(alpha[..., None] > 1e-3, work[..., :3] / np.maximum(alpha[..., None], 1e-3), 0)
    classes = cv2.warpAffine(labels, matrix, (size, size), flags=cv2.INTER_NEAREST)
    return Layer(np.clip(rgb, 0, 1), alpha, np.where(alpha >= 0.5, classes, BACKGROUND).astype(np.uint8))


def placement(rng, box, target, bend=1.0):
    """Affine map that brings `box` (left, top, right, bottom) to height `target`, foot at (x, y) of
    `target`, with random mirror, shear, turn and aspect."""
    left, top, right, bottom = box
    foot_x, foot_y, tall, widest = target
    aspect = float(np.exp(rng.normal(0, 0.13 * bend)))
    turn, shear = rng.normal(0, 0.04 * bend), rng.normal(0, 0.05 * bend)
    mirror = -1.0 if rng.random() < 0.5 else 1.0
    scale = tall / max(1, bottom - top)
    if (right - left) * scale * aspect > widest:
        scale = widest / ((right - left) * aspect)
    linear = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]) @ np.array([[mirror * aspect, shear], [0, 1]]) * scale
    anchor = np.array([(left + right) / 2, bottom])
    shift = np.array([foot_x, foot_y]) - linear @ anchor
    return np.hstack([linear, shift[:, None]]).astype(np.float32)


def bounds(labels):
    """Left, top, right, bottom of everything labelled."""
    ys, xs = np.flatnonzero(labels.any(axis=1)), np.flatnonzero(labels.any(axis=0))
    return xs[0], ys[0], xs[-1] + 1, ys[-1] + 1


def painted(rng, layer):
    """New colours: season, snow, light and shade, bark."""
    rgb, crown, trunk = layer.rgb, layer.labels == CROWN, layer.labels == TRUNK
    size = rgb.shape[0]
    body = layer.alpha > 0
    if rng.random() < 0.7:
        rgb = np.where(crown[..., None], rgb @ hue_rotation(rng.normal(0, 0.35), rng.uniform(0.5, 1.5)).T, rgb)
    if rng.random() < 0.35:
        rgb = recoloured(rng, rgb, body & ~trunk, CROWNS, rng.uniform(0.3, 1.0))
    if rng.random() < 0.45:
        rgb = recoloured(rng, rgb, trunk, BARKS, rng.uniform(0.3, 1.0))
    if rng.random() < 0.3:
        rgb = np.where(trunk[..., None], rgb * rng.uniform(0.4, 1.5), rgb)
    if rng.random() < 0.3:
        patches = smooth_noise(rng, size, rng.integers(4, 30), 3)[..., None]
        rgb = np.where(crown[..., None], rgb * (1 + (patches - 0.5) * rng.uniform(0.3, 2.0)), rgb)
    if rng.random() < 0.15:
        rgb = snowed(rng, layer, rgb)
    if rng.random() < 0.4 and body.any():
        rgb = rgb * shade(rng, layer)[..., None]
    if rng.random() < 0.7:
        rgb = lit(rng, rgb)
    if rng.random() < 0.12:
        rgb = rgb * rng.uniform(0.1, 0.5)
    return dataclasses.replace(layer, rgb=np.clip(rgb, 0, 1).astype(np.float32))


def shade(rng, layer):
    """The tree's shade on itself, in 0..1: foliage and stem darken downwards and away from the light."""
    size = layer.alpha.shape[0]
    left, top, right, bottom = bounds(layer.alpha > 0)
    y, x = np.mgrid[0:size, 0:size].astype(np.float32)
    down = np.clip((y - top) / max(1, bottom - top), 0, 1)
    aside = np.clip((x - left) / max(1, right - left), 0, 1)
    aside = aside if rng.random() < 0.5 else 1 - aside
    depth = down ** rng.uniform(0.7, 2.5) * rng.uniform(0.2, 0.75) + aside * rng.uniform(0, 0.4)
    patches = smooth_noise(rng, size, rng.integers(4, 16), 2)
    return np.clip(1 - depth * (0.6 + 0.8 * patches), 0.12, 1).astype(np.float32)


def snowed(rng, layer, rgb):
    """Snow on what faces up, or frost on everything."""
    size = rgb.shape[0]
    light = cv2.GaussianBlur(luminance(rgb), (0, 0), rng.uniform(0.5, 2.0))
    facing = np.roll(light, -1, 0) - np.roll(light, 1, 0)
    facing = -facing / (np.abs(facing).mean() + 1e-4)
    amount = smooth_noise(rng, size, rng.integers(6, 50), 3) * 2 - 1 + facing * rng.uniform(0.1, 0.6) + rng.uniform(-0.8, 0.6)
    amount = np.clip(amount * rng.uniform(1, 4), 0, 1) * rng.uniform(0.4, 1.0)
    amount = np.where(layer.labels == TRUNK, amount * rng.uniform(0, 0.6), amount)[..., None]
    shade = (0.75 + 0.35 * (light / (light.max() + 1e-3)))[..., None]
    return mix(rgb, np.array(SNOW, np.float32) * shade, amount)


def lit(rng, rgb):
    """A gradient of light and a colour cast."""
    size = rgb.shape[0]
    angle = rng.uniform(0, 2 * np.pi)
    y, x = np.mgrid[-0.5 : 0.5 : size * 1j, -0.5 : 0.5 : size * 1j].astype(np.float32)
    slope = (x * np.cos(angle) + y * np.sin(angle)) * rng.uniform(0, 1.0)
    rgb = rgb * (1 + slope)[..., None] * np.exp(rng.normal(0, 0.08, 3)).astype(np.float32)
    return np.clip(rgb, 0, 1) ** np.exp(rng.normal(0, 0.25)) * np.exp(rng.normal(0, 0.15))


def thinned(rng, layer):
    """Holes in the crown, ragged edges, or a denser crown."""
    size = layer.alpha.shape[0]
    alpha, labels, rgb = layer.alpha, layer.labels, layer.rgb
    kind = rng.random()
    if kind < 0.35:
        noise = smooth_noise(rng, size, rng.integers(10, 70), 3)
        hole = (noise < rng.uniform(0.2, 0.42)) & (labels != TRUNK)
        alpha = np.where(hole, 0, alpha)
    elif kind < 0.5:
        thin = cv2.erode(alpha, np.ones((3, 3), np.uint8))
        alpha = np.where(labels == TRUNK, alpha, thin)
    elif kind < 0.65:
        reach = int(rng.integers(1, 4))
        grown = cv2.dilate(labels, np.ones((2 * reach + 1, 2 * reach + 1), np.uint8))
        fill = (labels == BACKGROUND) & (grown == CROWN)
        colours = cv2.blur(rgb * alpha[..., None], (7, 7)) / np.maximum(cv2.blur(alpha, (7, 7)), 1e-3)[..., None]
        shade = rng.uniform(0.5, 1.0)
        rgb = np.where(fill[..., None], colours * shade, rgb)
        labels = np.where(fill, CROWN, labels).astype(np.uint8)
        alpha = np.where(fill, 1.0, alpha)
    labels = np.where(alpha >= 0.5, labels, BACKGROUND).astype(np.uint8)
    return Layer(rgb, alpha.astype(np.float32), labels)


def coarse(rng, picture, inner):
    """Lower resolution, blur, sharpening, noise, JPEG: what files go through."""
    size = picture.shape[0]
    if rng.random() < 0.3:
        small = int(size * rng.uniform(0.3, 0.9))
        down = cv2.resize(picture, (small, small), interpolation=cv2.INTER_AREA)
        picture = cv2.resize(down, (size, size), interpolation=rng.choice([cv2.INTER_LINEAR, cv2.INTER_CUBIC]))
    if rng.random() < 0.25:
        picture = cv2.GaussianBlur(picture, (0, 0), rng.uniform(0.3, 1.3))
    if rng.random() < 0.2:
        soft = cv2.GaussianBlur(picture, (0, 0), 1.0)
        picture = picture + (picture - soft) * rng.uniform(0.2, 1.2)
    if rng.random() < 0.35:
        picture = picture + rng.normal(0, rng.uniform(0.005, 0.06), picture.shape).astype(np.float32)
    picture = np.clip(picture, 0, 1)
    if rng.random() < 0.3:
        coded = cv2.imencode(".jpg", (picture * 255).astype(np.uint8), [cv2.IMWRITE_JPEG_QUALITY, int(rng.integers(20, 95))])[1]
        picture = cv2.imdecode(coded, cv2.IMREAD_COLOR).astype(np.float32) / 255.0
    return picture


def window(rng, size, low, high):
    """A random letterbox: the slice of the canvas that is picture."""
    aspect = float(np.exp(rng.uniform(np.log(low), np.log(high))))
    wide, tall = (size, int(size / aspect)) if aspect > 1 else (int(size * aspect), size)
    top, left = (size - tall) // 2, (size - wide) // 2
    return slice(top, top + tall), slice(left, left + wide)


class Maker:
    """Makes examples from grown trees (lists that are drawn from alike, whatever their lengths) and
    real ones."""

    def __init__(self, grown, real, size, real_share):
        self.size = size
        self.grown = [[self.ladder(tree) for tree in trees] for trees in grown if trees]
        billboards = [tree for tree in real if tree.has_alpha]
        photos = [tree for tree in real if not tree.has_alpha]
        self.boards = [self.ladder(tree) for tree in billboards]
        self.photos = [self.ladder(tree) for tree in photos]
        self.cutouts = [self.ladder(cutout(tree)) for tree in photos]
        small = [shrunk(tree, self.size) for tree in photos]
        self.backdrops = [(emptied(tree), bounds(tree.labels)) for tree in small]
        self.real_share = real_share if real else 0.0

    def ladder(self, tree):
        """The tree at several sizes, so that no warp shrinks by more than two."""
        longest = max(tree.labels.shape)
        sizes = [s for s in (self.size * 2, self.size, self.size // 2) if s <= longest] or [longest]
        return [shrunk(tree, s) for s in sizes]

    def pick(self, rng, pixels):
        """A tree to stand alone, at about the wanted size."""
        real = self.boards + self.cutouts
        if real and (not self.grown or rng.random() < self.real_share):
            pool = real
            if self.boards and self.cutouts:
                pool = self.boards if rng.random() < 0.65 else self.cutouts
        else:
            pool = self.grown[rng.integers(len(self.grown))]
        steps = pool[rng.integers(len(pool))]
        fitting = [s for s in steps if max(s.labels.shape) >= pixels * 0.8]
        return (fitting or steps)[-1] if fitting else steps[0]

    def tree(self, rng, target, changes=1.0, tree=None):
        """A changed tree as a layer: `target` is foot x, foot y, height, greatest width."""
        tree = tree or self.pick(rng, target[2])
        if rng.random() < 0.4 * changes:
            tree = stretched_trunk(rng, tree)
        if rng.random() < 0.2 * changes:
            tree = skirted(rng, tree)
        if rng.random() < 0.09 * changes and (tree.labels == CROWN).sum() > 200:
            tree = footless(tree)
        layer = warp(tree.rgba, tree.labels, placement(rng, bounds(tree.labels), target), self.size)
        if rng.random() < 0.5 * changes:
            layer = thinned(rng, layer)
        if rng.random() < 0.8 * changes:
            layer = painted(rng, layer)
        return layer

    def billboard(self, rng):
        """A tree with alpha."""
        size = self.size
        chosen = self.pick(rng, size)
        left, top, right, bottom = bounds(chosen.labels)
        shape = (right - left) / (bottom - top)
        loose = 1.15 if rng.random() < 0.8 else 2.2
        rows, columns = window(rng, size, shape / loose, shape * loose)
        tall, wide = rows.stop - rows.start, columns.stop - columns.start
        margin = rng.uniform(0, 0.04) if rng.random() < 0.8 else rng.uniform(0, 0.2)
        foot = rows.stop - tall * margin * rng.uniform(0, 1)
        if rng.random() < 0.1:
            foot += tall * rng.uniform(0, 0.08)
        height = (foot - rows.start) * (1 - margin * rng.uniform(0, 1))
        widest = wide * (1 - margin) * (1.15 if rng.random() < 0.1 else 1.0)
        centre = (columns.start + columns.stop) / 2 + rng.normal(0, 0.01) * wide
        layer = self.tree(rng, (centre, foot, height, widest), tree=chosen)
        if rng.random() < 0.05:
            other = self.tree(rng, (centre + rng.normal(0, 0.2) * wide, foot, height * rng.uniform(0.6, 1), widest))
            layer = over(other, layer)
        rgb, alpha, labels = layer.rgb, layer.alpha, layer.labels
        inside = np.zeros((size, size), bool)
        inside[rows, columns] = True
        premultiplied = coarse(rng, rgb * alpha[..., None], inside)
        rgb = premultiplied / np.maximum(alpha[..., None], 0.05)
        rgb, alpha = self.flawed_alpha(rng, rgb, alpha, labels)
        labels = np.where((alpha >= 0.5) & inside, labels, BACKGROUND)
        out = np.zeros((5, size, size), np.float32)
        alpha = np.where(inside, alpha, 0)
        out[:3] = np.where(alpha[..., None] > 0, np.clip(rgb, 0, 1), 0).transpose(2, 0, 1)
        out[3] = alpha
        out[4] = 1.0
        return out, labels.astype(np.uint8)

    def flawed_alpha(self, rng, rgb, alpha, labels):
        """Hard, soft or dirty alpha, fringes and ground shadows."""
        size = self.size
        if rng.random() < 0.25:
            alpha = (alpha > rng.uniform(0.2, 0.8)).astype(np.float32)
        elif rng.random() < 0.2:
            alpha = cv2.GaussianBlur(alpha, (0, 0), rng.uniform(0.4, 1.2))
        under = alpha
        if rng.random() < 0.15:
            centre = np.flatnonzero((labels > 0).any(axis=0))
            ys = np.flatnonzero((labels > 0).any(axis=1))
            if len(ys):
                y, x = np.mgrid[0:size, 0:size].astype(np.float32)
                rx, ry = rng.uniform(0.1, 0.6) * size, rng.uniform(0.01, 0.06) * size
                d = ((x - centre.mean()) / rx) ** 2 + ((y - ys[-1] + ry * 0.5) / ry) ** 2
                shadow = np.clip(1.3 - d, 0, 1) * rng.uniform(0.1, 0.48)
                rgb = np.where((under < 0.3)[..., None] & (shadow > 0)[..., None], rng.uniform(0, 0.3), rgb)
                alpha = np.maximum(alpha, shadow.astype(np.float32))
        if rng.random() < 0.15:
            dirt = rng.integers(1, 9) / 255.0
            rgb = np.where((alpha < dirt)[..., None], rng.random(3), rgb)
            alpha = np.maximum(alpha, dirt)
        if rng.random() < 0.15:
            edge = (alpha < 0.95) & (alpha > 0)
            rgb = np.where(edge[..., None], mix(rgb, np.full(3, rng.choice([0.0, 1.0])), rng.uniform(0.3, 1.0)), rgb)
        return rgb.astype(np.float32), alpha.astype(np.float32)

    def composite(self, rng):
        """A tree without alpha, in front of a painted backdrop."""
        size = self.size
        chosen = self.pick(rng, size)
        left, top, right, bottom = bounds(chosen.labels)
        shape = float(np.clip((right - left) / (bottom - top), 0.4, 1.5))
        rows, columns = window(rng, size, max(0.5, shape * 0.8), min(1.6, shape * 2.0))
        tall, wide = rows.stop - rows.start, columns.stop - columns.start
        close = rng.random() < 0.25
        height = tall * (rng.uniform(0.9, 1.1) if close else rng.uniform(0.6, 1.0))
        foot = rows.stop - tall * (rng.uniform(-0.05, 0.02) if close else rng.uniform(0.0, 0.3))
        height = min(height, foot - rows.start + tall * (0.05 if rng.random() < 0.2 else 0.0))
        centre = (columns.start + columns.stop) / 2 + rng.normal(0, 0.06) * wide
        main = self.tree(rng, (centre, foot, height, wide * rng.uniform(0.8, 1.1)), tree=chosen)
        if self.backdrops and rng.random() < 0.4:
            picture = self.backdrop(rng, centre, foot, height)
            if rng.random() < 0.5:
                picture = shadowed(rng, picture, centre, foot, height)
        elif rng.random() < 0.18:
            picture = scenes.plain(rng, size)
        else:
            horizon = foot - rng.uniform(-0.03, 0.25) * tall
            picture = scenes.outdoors(rng, size, horizon)
            if self.grown and rng.random() < 0.5:
                picture = self.neighbours(rng, picture, centre, horizon, tall, wide)
            if rng.random() < 0.5:
                picture = shadowed(rng, picture, centre, foot, height)
        if rng.random() < 0.35:
            picture = cv2.GaussianBlur(picture, (0, 0), rng.uniform(0.5, 2.5))
        picture = mix(picture, main.rgb, main.alpha[..., None])
        labels = main.labels
        if rng.random() < 0.4:
            picture, labels = undergrowth(rng, picture, labels, foot, height)
        if rng.random() < 0.6:
            picture = lit(rng, np.clip(picture, 0, 1))
        return self.framed(rng, picture, labels, rows, columns)

    def backdrop(self, rng, centre, foot, height):
        """A photograph's surroundings, so that the new tree stands where the old one stood."""
        size = self.size
        picture, (left, top, right, bottom) = self.backdrops[rng.integers(len(self.backdrops))]
        scale = height / (bottom - top) * np.exp(rng.normal(0, 0.2))
        scale = max(scale, 0.8 * size / max(picture.shape[:2]))
        mirror = -1.0 if rng.random() < 0.5 else 1.0
        linear = np.array([[mirror * scale, 0], [0, scale]])
        shift = np.array([centre, foot]) - linear @ np.array([(left + right) / 2, bottom])
        matrix = np.hstack([linear, shift[:, None]]).astype(np.float32)
        back = cv2.warpAffine(picture, matrix, (size, size), flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT)
        back = back.astype(np.float32) / 255
        if rng.random() < 0.6:
            back = np.clip(back @ hue_rotation(rng.normal(0, 0.4), rng.uniform(0.4, 1.5)).T, 0, 1)
        return lit(rng, back).astype(np.float32)

    def neighbours(self, rng, picture, centre, horizon, tall, wide):
        """Other trees behind, which are background."""
        for _ in range(rng.integers(1, 5)):
            x = centre + rng.choice([-1, 1]) * rng.uniform(0.15, 0.7) * wide
            height = rng.uniform(0.15, 0.7) * tall
            foot = horizon + rng.uniform(0, 0.08) * tall
            other = self.tree(rng, (x, foot, height, wide), 0.6)
            haze = rng.uniform(0, 0.5) if rng.random() < 0.5 else 0.0
            rgb = mix(other.rgb, np.float32(0.75), haze)
            picture = mix(picture, rgb, other.alpha[..., None])
        return picture

    def photograph(self, rng):
        """A real photograph, cropped and changed."""
        size = self.size
        steps = self.photos[rng.integers(len(self.photos))]
        tree = steps[min(1, len(steps) - 1)] if rng.random() < 0.7 else steps[0]
        height, width = tree.labels.shape
        left, top, right, bottom = bounds(tree.labels)
        grow = lambda edge, limit: edge + (limit - edge) * rng.uniform(0, 1) ** 1.5
        trim = 0.06 if rng.random() < 0.2 else 0.0
        x0, y0 = grow(left, 0) + trim * width, grow(top, 0)
        x1, y1 = grow(right, width) - trim * width, grow(bottom, height)
        if rng.random() < 0.35:
            x0, y0, x1, y1 = 0, 0, width, height
        aspect = float(np.exp(rng.normal(0, 0.1)))
        scale = size / max((x1 - x0) * aspect, y1 - y0)
        wide, tall = min(size, int((x1 - x0) * aspect * scale)), min(size, int((y1 - y0) * scale))
        mirror = rng.random() < 0.5
        turn, shear = rng.normal(0, 0.03), rng.normal(0, 0.03)
        linear = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]) @ np.array([[aspect * (-1 if mirror else 1), shear], [0, 1]]) * scale
        centre = np.array([(x0 + x1) / 2, (y0 + y1) / 2])
        shift = np.array([size / 2, size / 2]) - linear @ centre
        matrix = np.hstack([linear, shift[:, None]]).astype(np.float32)
        rgb = cv2.warpAffine(tree.rgba[..., :3].astype(np.float32) / 255, matrix, (size, size), flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT)
        labels = cv2.warpAffine(tree.labels, matrix, (size, size), flags=cv2.INTER_NEAREST, borderMode=cv2.BORDER_REFLECT)
        layer = Layer(rgb, (labels > 0).astype(np.float32), labels)
        if rng.random() < 0.5:
            soft = cv2.GaussianBlur(layer.alpha, (0, 0), 1.0)[..., None]
            rgb = mix(rgb, painted(rng, layer).rgb, soft)
        if rng.random() < 0.3:
            rgb = np.where((labels == 0)[..., None], rgb @ hue_rotation(rng.normal(0, 0.4), rng.uniform(0.5, 1.4)).T, rgb)
        if rng.random() < 0.6:
            rgb = lit(rng, np.clip(rgb, 0, 1))
        rows = slice((size - tall) // 2, (size - tall) // 2 + tall)
        columns = slice((size - wide) // 2, (size - wide) // 2 + wide)
        return self.framed(rng, rgb, labels, rows, columns)

    def framed(self, rng, picture, labels, rows, columns):
        """The network's view of a picture without alpha."""
        picture = coarse(rng, np.clip(picture, 0, 1).astype(np.float32), None)
        out = np.zeros((5, self.size, self.size), np.float32)
        out[(slice(0, 3), rows, columns)] = picture[rows, columns].transpose(2, 0, 1)
        seen = np.zeros_like(labels)
        seen[rows, columns] = labels[rows, columns]
        return out, seen.astype(np.uint8)

    def close_up(self, rng, closer, billboards):
        """The foot of a tree as the program looks at it again: `closer` makes larger examples."""
        image, labels = closer.example(rng, billboards)
        large = closer.size
        side = int(rng.uniform(0.35, 0.7) * large)
        trunk = labels == TRUNK
        seen = trunk if trunk.sum() > 12 else labels > 0
        if not seen.any():
            seen = np.ones_like(trunk)
        ys, xs = np.flatnonzero(seen.any(axis=1)), np.flatnonzero(seen.any(axis=0))
        x = (xs[0] + xs[-1]) / 2 + rng.normal(0, 0.1) * side
        bottom = ys[-1] + rng.uniform(0.05, 0.4) * side
        left = int(np.clip(x - side / 2, 0, large - side))
        top = int(np.clip(bottom - side, 0, large - side))
        part = (slice(top, top + side), slice(left, left + side))
        target = (self.size, self.size)
        mode = cv2.INTER_AREA if side > self.size else cv2.INTER_LINEAR
        planes = [cv2.resize(plane[part], target, interpolation=mode) for plane in image]
        return np.stack(planes), cv2.resize(labels[part], target, interpolation=cv2.INTER_NEAREST)

    def example(self, rng, billboards=0.5):
        """One example of a random kind."""
        kind = rng.random()
        if kind < billboards:
            return self.billboard(rng)
        if self.photos and rng.random() < self.real_share:
            return self.photograph(rng)
        return self.composite(rng)


def over(back, front):
    """One tree in front of another, both labelled."""
    alpha = front.alpha + back.alpha * (1 - front.alpha)
    rgb = (front.rgb * front.alpha[..., None] + back.rgb * (back.alpha * (1 - front.alpha))[..., None]) / np.maximum(alpha, 1e-3)[..., None]
    labels = np.where(front.alpha >= 0.5, front.labels, back.labels)
    return Layer(rgb.astype(np.float32), alpha, labels)


def shadowed(rng, picture, centre, foot, height):
    """The tree's shadow on the ground."""
    size = picture.shape[0]
    y, x = np.mgrid[0:size, 0:size].astype(np.float32)
    rx, ry = rng.uniform(0.15, 0.6) * height, rng.uniform(0.01, 0.08) * height
    d = ((x - centre - rng.normal(0, 0.2) * height) / rx) ** 2 + ((y - foot) / ry) ** 2
    return picture * (1 - np.clip(1.4 - d, 0, 1) * rng.uniform(0.2, 0.75))[..., None]


def undergrowth(rng, picture, labels, foot, height):
    """Grass or bushes in front of the foot, which are background."""
    size = picture.shape[0]
    tall = rng.uniform(0.01, 0.14) * height
    wave = cv2.resize(rng.random((1, rng.integers(4, 40)), dtype=np.float32), (size, 1), interpolation=cv2.INTER_CUBIC)[0]
    ragged = cv2.resize(rng.random((1, size // 2), dtype=np.float32), (size, 1))[0]
    top = foot - tall * (0.3 + 0.7 * wave + rng.uniform(0, 0.5) * ragged)
    rows = np.arange(size, dtype=np.float32)[:, None]
    inside = rows > top[None, :]
    leaves = scenes.textured(rng, size, colour(rng, scenes.GRASS + scenes.LEAVES), rng.uniform(0.2, 0.9), rng.integers(15, 60))
    keep = rng.random()
    if keep < 0.4:
        inside &= rows < foot + tall
    return np.where(inside[..., None], leaves, picture), np.where(inside, BACKGROUND, labels)
