"""Labels a picture with the network as the program does, and scores the labels.

Scores are at the size of the picture. Crown and trunk each have an IoU per picture; a class that
both truth and answer lack is left out for that picture, a class that only one of them has counts 0.
The headline is the mean of the mean crown IoU and the mean trunk IoU.
"""

import dataclasses

import cv2
import numpy as np
import scipy.ndimage
import torch

from trees import BACKGROUND, CROWN, TRUNK, frame, network_input

# Smallest trunk, as a part of the tree's pixels.
LEAST_TRUNK = 0.002
# Likelihood of trunk and crown together from which on a photograph's pixel is tree.
TREE = 0.4
# Reach of the guided filter's window, pixels of the network, and the variance of colour that it ignores.
REACH, EPSILON = 2, 1e-3


def probabilities(net, tree, size, temperature=1.0, has_alpha=None):
    """Class probabilities inside the frame, [3, inner_h, inner_w], as the network gives them."""
    has_alpha = tree.has_alpha if has_alpha is None else has_alpha
    image = network_input(tree.rgba, has_alpha, size)
    with torch.no_grad():
        logits = net(torch.from_numpy(image)[None])[0].float() / temperature
    height, width = tree.labels.shape
    inner_h, inner_w, top, left = frame(height, width, size)
    p = logits.softmax(0).numpy()
    return p[:, top : top + inner_h, left : left + inner_w]


def enlarged(p, height, width):
    """Probabilities at the size of the picture."""
    return np.stack([cv2.resize(c, (width, height), interpolation=cv2.INTER_LINEAR) for c in p])


def guided(guide, planes, radius, epsilon):
    """He et al.'s guided filter with a guide of three colours."""
    window = (2 * radius + 1, 2 * radius + 1)
    mean = lambda image: cv2.blur(image, window, borderType=cv2.BORDER_REFLECT)
    colours = [np.ascontiguousarray(guide[..., i]) for i in range(3)]
    means = [mean(c) for c in colours]
    v = {(i, j): mean(colours[i] * colours[j]) - means[i] * means[j] for i in range(3) for j in range(i, 3)}
    rr, gg, bb = (v[i, i] + epsilon for i in range(3))
    rg, rb, gb = v[0, 1], v[0, 2], v[1, 2]
    # Cofactors of the symmetric matrix.
    c00, c01, c02 = gg * bb - gb * gb, rb * gb - rg * bb, rg * gb - rb * gg
    c11, c12, c22 = rr * bb - rb * rb, rb * rg - rr * gb, rr * gg - rg * rg
    determinant = rr * c00 + rg * c01 + rb * c02
    out = []
    for p in planes:
        mean_p = mean(p)
        x, y, z = (mean(c * p) - m * mean_p for c, m in zip(colours, means))
        slope = [(c00 * x + c01 * y + c02 * z), (c01 * x + c11 * y + c12 * z), (c02 * x + c12 * y + c22 * z)]
        slope = [s / determinant for s in slope]
        rest = mean_p - sum(s * m for s, m in zip(slope, means))
        out.append(sum(mean(s) * c for s, c in zip(slope, colours)) + mean(rest))
    return np.stack(out)


def sharpened(p, tree, size):
    """Probabilities at the size of the picture; without alpha brought to its edges."""
    height, width = tree.labels.shape
    p = enlarged(p, height, width)
    if tree.has_alpha:
        return p
    radius = max(1, round(REACH * max(height, width) / size))
    guide = tree.rgba[..., :3].astype(np.float32) / 255
    return guided(guide, p, radius, EPSILON)


def foot(p):
    """Where the network looks a second time: left, top, right, bottom as parts of the picture, or None.

    A square about the likeliest trunk, or the lowest tenth of the tree, twice as high as that and half
    the picture's longer side at least.
    """
    height, width = p.shape[1:]
    parts, count = scipy.ndimage.label(p[TRUNK] > 0.3, np.ones((3, 3)))
    if count:
        areas = np.bincount(parts.ravel())[1:]
        ys, xs = np.nonzero(parts == 1 + areas.argmax())
    else:
        ys, xs = np.nonzero(p[TRUNK] + p[CROWN] > TREE)
        if len(ys) == 0:
            return None
        low = ys >= ys.max() - (ys.max() - ys.min()) // 10
        ys, xs = ys[low], xs[low]
    top, bottom, longest = ys.min(), ys.max() + 1, max(height, width)
    side = max(2 * (bottom - top), longest / 2)
    if side > 0.8 * longest:
        return None
    x = (xs.min() + xs.max() + 1) / 2
    y1 = min(height, bottom + side / 4)
    edges = max(0, x - side / 2) / width, max(0, y1 - side) / height, min(width, x + side / 2) / width, y1 / height
    return edges


def ramp(count, rises, falls):
    """0 to 1 over the first seventh, 1 to 0 over the last, where wanted."""
    at = (np.arange(count) + 0.5) / count * 7
    up = np.minimum(at, 1) if rises else np.ones(count)
    return np.minimum(up, np.minimum(7 - at, 1) if falls else 1).astype(np.float32)


def looked(net, tree, size, temperature=1.0):
    """Probabilities inside the frame, as the network gives them, and at the size of the picture;
    without alpha after a second look at the foot of the tree."""
    p = probabilities(net, tree, size, temperature)
    fine = sharpened(p, tree, size)
    edges = None if tree.has_alpha else foot(p)
    if edges is None:
        return p, fine
    height, width = tree.labels.shape
    left, right = (int(round(x * width)) for x in edges[::2])
    top, bottom = (int(round(y * height)) for y in edges[1::2])
    window = (slice(top, bottom), slice(left, right))
    part = dataclasses.replace(tree, rgba=np.ascontiguousarray(tree.rgba[window]), labels=np.ascontiguousarray(tree.labels[window]))
    again = sharpened(probabilities(net, part, size, temperature), part, size)
    weight = ramp(bottom - top, top > 0, bottom < height)[:, None] * ramp(right - left, left > 0, right < width)
    fine[(slice(None), *window)] += weight * (again - fine[(slice(None), *window)])
    return p, fine


def raw_labels(p, tree):
    """Likeliest class; with alpha, clear pixels are background and the others are not."""
    height, width = tree.labels.shape
    p = enlarged(p, height, width)
    if tree.has_alpha:
        return of_cut_out(p, tree)
    return p.argmax(0).astype(np.uint8)


def of_cut_out(p, tree):
    """Trunk or crown where the picture is opaque."""
    kind = np.where(p[TRUNK] > p[CROWN], TRUNK, CROWN)
    return np.where(tree.rgba[..., 3] >= 128, kind, BACKGROUND).astype(np.uint8)


def labels(fine, tree):
    """Labels with all post-processing: snapped to the picture's edges, connected."""
    if tree.has_alpha:
        return connected(of_cut_out(fine, tree), fine, islands=True)
    kind = np.where(fine[TRUNK] > fine[CROWN], TRUNK, CROWN)
    return connected(np.where(fine[TRUNK] + fine[CROWN] > TREE, kind, BACKGROUND).astype(np.uint8), fine)


def replace(classes, where, p):
    """Makes trunk what is likeliest after trunk."""
    other = np.where(p[CROWN] >= p[BACKGROUND], CROWN, BACKGROUND)
    classes[where] = other[where]


def connected(classes, p, islands=False):
    """Drops specks: trunk parts much smaller than the largest, and, unless `islands` may stay, parts
    far smaller than the tree."""
    classes = classes.copy()
    parts, count = scipy.ndimage.label(classes == TRUNK, np.ones((3, 3)))
    if count > 1:
        areas = np.bincount(parts.ravel())[1:]
        small = 1 + np.flatnonzero(areas < 0.2 * areas.max())
        replace(classes, np.isin(parts, small), p)
    if (classes == TRUNK).sum() < LEAST_TRUNK * (classes > 0).sum():
        replace(classes, classes == TRUNK, p)
    parts, count = scipy.ndimage.label(classes > 0, np.ones((3, 3)))
    if count > 1 and not islands:
        areas = np.bincount(parts.ravel())[1:]
        small = 1 + np.flatnonzero(areas < 0.01 * areas.max())
        classes[np.isin(parts, small) & (p[BACKGROUND] > 0.1)] = BACKGROUND
    return classes


def iou(truth, found, kind):
    """IoU of one class, or None when neither truth nor answer has any of it."""
    a, b = truth == kind, found == kind
    either = (a | b).sum()
    return float((a & b).sum() / either) if either else None


def pins(classes):
    """Baseline row (85th percentile of crown rows that touch trunk), trunk's left and right there,
    and the foot (x, y); None without a trunk."""
    trunk, crown = classes == TRUNK, classes == CROWN
    if trunk.sum() < 4:
        return None
    rows = np.argwhere(crown & (cv2.dilate(trunk.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0))[:, 0]
    if len(rows) == 0:
        return None
    bottom = int(np.flatnonzero(trunk.any(axis=1))[-1])
    base = float(np.percentile(rows, 85))
    row = int(min(max(base, np.flatnonzero(trunk.any(axis=1))[0]), bottom))
    across = np.flatnonzero(trunk[row])
    if len(across) == 0:
        across = np.flatnonzero(trunk.any(axis=0))
    foot = np.flatnonzero(trunk[bottom])
    return base, float(across[0]), float(across[-1]), float(foot.mean()), float(bottom)


def pin_error(classes, truth):
    """Largest distance of baseline, left, right and foot from the truth's, as a share of the tree's
    height; None when the truth has no trunk, 1 when only the truth has one."""
    if truth["baseline_y"] < 0:
        return None
    found = pins(classes)
    if found is None:
        return 1.0
    base, left, right, foot_x, foot_y = found
    wrong = [
        base - truth["baseline_y"],
        left - truth["trunk_left_x"],
        right - truth["trunk_right_x"],
        np.hypot(foot_x - truth["bottom_x"], foot_y - truth["bottom_y"]),
    ]
    return float(np.abs(wrong).max() / truth["height_px"])


@dataclasses.dataclass
class Score:
    """What one picture scored."""

    name: str
    group: str
    permissive: bool
    mode: str
    raw: tuple
    final: tuple
    pin: float | None
    baseline: float | None
    features: tuple
    classes: np.ndarray


def features(p):
    """Certainty of what may be tree, and of the trunk; see the model card."""
    tree = p[BACKGROUND] < 0.9
    best = p.max(0)
    trunk = p.argmax(0) == TRUNK
    return (
        float(best[tree].mean()) if tree.any() else 0.0,
        float(p[TRUNK][trunk].mean()) if trunk.any() else 0.5,
    )


def score(net, tree, size, pin_truth, mode=None, temperature=1.0):
    """Labels and scores one tree; `mode` names how it was shown."""
    p, fine = looked(net, tree, size, temperature)
    raw, final = raw_labels(p, tree), labels(fine, tree)
    found = pins(final)
    base = None
    if pin_truth and pin_truth["baseline_y"] >= 0:
        base = abs(found[0] - pin_truth["baseline_y"]) / pin_truth["height_px"] if found else 1.0
    return Score(
        tree.name,
        tree.group,
        tree.permissive,
        mode or ("alpha" if tree.has_alpha else "photo"),
        (iou(tree.labels, raw, CROWN), iou(tree.labels, raw, TRUNK)),
        (iou(tree.labels, final, CROWN), iou(tree.labels, final, TRUNK)),
        pin_error(final, pin_truth) if pin_truth else None,
        base,
        features(p),
        final,
    )


def mean(values):
    values = [v for v in values if v is not None]
    return float(np.mean(values)) if values else float("nan")


def summary(scores):
    """Counts and means over some scores, as a dictionary."""
    def pair(which):
        crown = mean([getattr(s, which)[0] for s in scores])
        trunk = mean([getattr(s, which)[1] for s in scores])
        return crown, trunk, (crown + trunk) / 2

    raw, final = pair("raw"), pair("final")
    known = [s.pin for s in scores if s.pin is not None]
    base = [s.baseline for s in scores if s.baseline is not None]
    return {
        "pictures": len(scores),
        "raw": raw[2],
        "crown": final[0],
        "trunk": final[1],
        "mean": final[2],
        "per_picture": mean([mean(s.final) for s in scores]),
        "pins": float(np.mean([p <= 0.03 for p in known])) if known else float("nan"),
        "baseline": float(np.mean([p <= 0.03 for p in base])) if base else float("nan"),
    }
