"""Makes the network's probabilities mean what they say, on trees it was not trained on.

The temperature minimises the log loss of tree pixels (opaque ones of billboards, all of photographs)
over held-out real images, each image weighing the same. The confidence of a picture is then fitted
to its IoU, mean of crown and trunk: a logistic curve over the two features of the model card. The
error is measured leaving one fold of sources out at a time.
"""

import cv2
import numpy as np
import scipy.optimize
import torch

import judge
from trees import frame, network_input


def logits_of(net, tree, size):
    """Logits inside the frame, and the classes and weights of those pixels."""
    with torch.no_grad():
        out = net(torch.from_numpy(network_input(tree.rgba, tree.has_alpha, size))[None])[0].float().numpy()
    height, width = tree.labels.shape
    h, w, top, left = frame(height, width, size)
    logits = out[:, top : top + h, left : left + w]
    classes = cv2.resize(tree.labels, (w, h), interpolation=cv2.INTER_NEAREST)
    opaque = np.ones((h, w), bool)
    if tree.has_alpha:
        opaque = cv2.resize(tree.rgba[..., 3], (w, h), interpolation=cv2.INTER_AREA) >= 128
    return logits, classes, opaque


def softmax(logits, temperature):
    z = logits / temperature
    z = np.exp(z - z.max(0, keepdims=True))
    return z / z.sum(0, keepdims=True)


def log_loss(samples, temperature):
    losses = []
    for logits, classes, opaque in samples:
        p = softmax(logits, temperature)
        chosen = np.take_along_axis(p, classes[None].astype(int), 0)[0]
        losses.append(-np.log(np.maximum(chosen[opaque], 1e-7)).mean())
    return float(np.mean(losses))


def calibration_error(samples, temperature, bins=15):
    """Expected calibration error of the likeliest class, in bins of equal width."""
    sure, right = [], []
    for logits, classes, opaque in samples:
        p = softmax(logits, temperature)
        sure.append(p.max(0)[opaque])
        right.append((p.argmax(0) == classes)[opaque])
    sure, right = np.concatenate(sure), np.concatenate(right)
    index = np.minimum((sure * bins).astype(int), bins - 1)
    error = 0.0
    for b in range(bins):
        chosen = index == b
        if chosen.any():
            error += chosen.mean() * abs(sure[chosen].mean() - right[chosen].mean())
    return float(error)


def fitted(features, ious):
    """Coefficients of the logistic curve from features to IoU, slightly damped."""
    x = np.column_stack([np.ones(len(features)), features])
    curve = lambda c: 1 / (1 + np.exp(-x @ c))
    residual = lambda c: np.concatenate([curve(c) - ious, 0.02 * c[1:]])
    return scipy.optimize.least_squares(residual, [0.0, 1.0, 1.0]).x


def expected(features, coefficients):
    x = np.column_stack([np.ones(len(features)), features])
    return 1 / (1 + np.exp(-x @ np.asarray(coefficients)))


def temperature_of(samples):
    """The temperature that fits `samples` (of `logits_of`) best."""
    found = scipy.optimize.minimize_scalar(lambda t: log_loss(samples, np.exp(t)), bounds=(-1.5, 2), method="bounded")
    return float(np.exp(found.x))


def calibration_of(samples, temperature, scores, folds):
    """What stands in the sidecar, and what it is worth. `scores` are those at this temperature."""
    features = np.array([s.features for s in scores])
    ious = np.array([judge.mean(s.final) for s in scores])
    folds = np.array(folds)
    coefficients = fitted(features, ious)
    guesses = np.zeros(len(ious))
    for fold in np.unique(folds):
        rest = folds != fold
        guesses[~rest] = expected(features[~rest], fitted(features[rest], ious[rest]))
    low = ious < 0.7
    report = {
        "pictures": len(samples),
        "log_loss_before": log_loss(samples, 1.0),
        "log_loss_after": log_loss(samples, temperature),
        "pixel_error_before": calibration_error(samples, 1.0),
        "pixel_error_after": calibration_error(samples, temperature),
        "iou_error": float(np.abs(guesses - ious).mean()),
        "iou_bias": float((guesses - ious).mean()),
        "iou_error_of_constant": float(np.abs(ious.mean() - ious).mean()),
        "correlation": float(np.corrcoef(guesses, ious)[0, 1]),
        "mean_guess_below_0.7": float(guesses[low].mean()) if low.any() else None,
        "mean_guess_above_0.7": float(guesses[~low].mean()) if (~low).any() else None,
    }
    calibration = {
        "temperature": round(temperature, 4),
        "confidence": {
            "estimates": "iou",
            "features": ["certainty", "trunk_certainty"],
            "not_background": 0.9,
            "coefficients": [round(float(c), 4) for c in coefficients],
        },
    }
    return calibration, report
