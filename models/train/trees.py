"""Labelled trees: reading them, framing them for the network, and telling whose they are.

A tree is a picture with straight RGBA in uint8 and a label image (0 background, 1 trunk, 2 crown).
Pictures without alpha have `has_alpha` false and 255 in their alpha channel.
"""

import csv
import dataclasses
import pathlib

import cv2
import numpy as np
from PIL import Image

BACKGROUND, TRUNK, CROWN = 0, 1, 2

# Licences whose pictures may teach the model that is shipped: no share-alike, no copyleft.
PERMISSIVE = ("CC BY 2.0", "CC BY 2.5", "CC BY 3.0", "CC BY 4.0", "CC0", "Public domain", "MIT")

# Fold of each source, for cross-validation over all real images. Tracks that reuse one silhouette
# in other colours (allondaz, lombaro, pinabashi) count as one source.
SOURCE_FOLDS = {
    "extremetuxracer": 0,
    "espie": 1,
    "resa": 2,
    "allondaz": 3,
    "lombaro": 3,
    "pinabashi": 3,
    "peters": 3,
    "inuksuk": 4,
    "ole-road-1": 4,
}
# Every photograph has its own photographer and species; they are dealt out in order of name.
PHOTO_FOLDS = 5

GROUPS = {
    "snow": ("snow", "frost"),
    "bare": ("bare_",),
    "palm": ("palm",),
    "conifer": ("fir_", "spruce", "conifer", "larch", "juniper", "redwood", "ponderosa", "bald_cypress"),
}


@dataclasses.dataclass
class Tree:
    """One labelled picture."""

    name: str
    rgba: np.ndarray
    labels: np.ndarray
    has_alpha: bool
    permissive: bool = True
    fold: int = -1
    origin: str = "grown"
    licence: str = "own"

    @property
    def group(self):
        """Kind of tree for the tables: snow, bare, palm, conifer or broadleaf."""
        for group, words in GROUPS.items():
            if any(word in self.name for word in words):
                return group
        return "broadleaf"


def read_labels(path):
    """Class of each pixel from a label image of 0, 128 and 255."""
    grey = np.asarray(Image.open(path).convert("L"))
    return np.select([grey < 64, grey < 192], [BACKGROUND, TRUNK], CROWN).astype(np.uint8)


def read_rgba(path):
    """Straight RGBA, and whether the file's alpha says something."""
    picture = Image.open(path)
    has_alpha = picture.mode in ("RGBA", "LA", "P")
    rgba = np.array(picture.convert("RGBA"))
    return rgba, has_alpha and bool((rgba[..., 3] < 250).any())


def shrunk(tree, longest):
    """The tree with its longest side at most `longest`, area-averaged."""
    height, width = tree.labels.shape
    scale = longest / max(height, width)
    if scale >= 1.0:
        return tree
    size = (max(1, round(width * scale)), max(1, round(height * scale)))
    premultiplied = tree.rgba.astype(np.float32)
    premultiplied[..., :3] *= premultiplied[..., 3:] / 255.0
    small = cv2.resize(premultiplied, size, interpolation=cv2.INTER_AREA)
    small[..., :3] *= 255.0 / np.maximum(small[..., 3:], 1e-3)
    shares = [cv2.resize((tree.labels == c).astype(np.float32), size, interpolation=cv2.INTER_AREA) for c in range(3)]
    labels = np.argmax(np.stack(shares), axis=0).astype(np.uint8)
    rgba = np.clip(small + 0.5, 0, 255).astype(np.uint8)
    return dataclasses.replace(tree, rgba=rgba, labels=labels)


def real_trees(data):
    """The hand-labelled real images under `data` (index.csv, billboards, photos, labels)."""
    data = pathlib.Path(data)
    trees = []
    photos = 0
    with open(data / "index.csv", newline="", encoding="utf-8") as file:
        rows = sorted(csv.DictReader(file), key=lambda row: row["file"])
    for row in rows:
        name = pathlib.Path(row["file"]).stem
        labels = data / "labels" / f"{name}.labels.png"
        if row["kind"] not in ("billboard", "photo") or not labels.exists():
            continue
        rgba, has_alpha = read_rgba(data / row["file"])
        if row["kind"] == "photo":
            fold, photos = photos % PHOTO_FOLDS, photos + 1
        else:
            parts = row["path"].split("/") + row["repository"].split("/")
            fold = next(SOURCE_FOLDS[part] for part in parts if part in SOURCE_FOLDS)
        trees.append(
            Tree(
                name=name,
                rgba=rgba,
                labels=read_labels(labels),
                has_alpha=has_alpha,
                permissive=row["licence"].startswith(PERMISSIVE),
                fold=fold,
                origin=row["kind"],
                licence=row["licence"].split(" (")[0],
            )
        )
    return trees


def grown_trees(folder, longest=560):
    """Trees written by `boscage samples`: NAME.png beside labels/NAME.labels.png."""
    folder = pathlib.Path(folder)
    trees = []
    for labels in sorted(folder.glob("labels/*.labels.png")):
        name = labels.name.removesuffix(".labels.png")
        picture = folder / f"{name}.png"
        if not picture.exists():
            continue
        rgba, _ = read_rgba(picture)
        trees.append(shrunk(Tree(name, rgba, read_labels(labels), True), longest))
    return trees


def frame(height, width, size):
    """Scaled height and width, and top and left margin, of a picture fitted into a square."""
    scale = size / max(height, width)
    inner_h = min(size, max(1, round(height * scale)))
    inner_w = min(size, max(1, round(width * scale)))
    return inner_h, inner_w, (size - inner_h) // 2, (size - inner_w) // 2


def network_input(rgba, has_alpha, size):
    """What the network sees: float32 [5, size, size] of R, G, B, A, H in 0..1.

    The picture is fitted with its aspect kept, area-averaged when shrunk, bilinear when enlarged,
    with premultiplied colours, centred on zeros.
    """
    height, width = rgba.shape[:2]
    inner_h, inner_w, top, left = frame(height, width, size)
    work = rgba.astype(np.float32) / 255.0
    if not has_alpha:
        work[..., 3] = 1.0
    work[..., :3] *= work[..., 3:]
    shrinks = inner_h < height or inner_w < width
    mode = cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR
    work = cv2.resize(work, (inner_w, inner_h), interpolation=mode)
    alpha = work[..., 3:]
    colour = np.where(alpha > 0, work[..., :3] / np.maximum(alpha, 1e-6), 0.0)
    out = np.zeros((5, size, size), np.float32)
    window = (slice(top, top + inner_h), slice(left, left + inner_w))
    out[(slice(0, 3), *window)] = np.clip(colour, 0, 1).transpose(2, 0, 1)
    if has_alpha:
        out[(3, *window)] = alpha[..., 0]
        out[4] = 1.0
    return out
