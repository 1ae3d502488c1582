#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Reference values of the average precision, by NumPy after pycocotools' cocoeval.py, for tests/eval/test_ap.

    scripts/vectors/ap.py        writes tests/vectors/ap.npz

Thirty images of three classes with up to six objects each, crowds among them, boxes found near some, elsewhere and
twice, and scores that are often equal: found (n, 4) image, class, score, area; truth (m, 4) image, class, area, crowd;
the overlap of each pair of one image, row by row; average precisions (3, 10) of all areas, small ones and large ones.
"""
import os

import numpy as np

OUT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../tests/vectors/ap.npz")
IMAGES, CLASSES = 30, 3
THRESHOLDS, RECALLS = np.linspace(.5, .95, 10), np.linspace(0, 1, 101)
RANGES = {"all": (0, 1e10), "small": (0, 32 ** 2), "large": (96 ** 2, 1e10)}


def overlaps(a, b, crowd):
    """IoU of boxes x y w h; of a crowd, the share of a"""
    lo = np.maximum(a[:, None, :2], b[None, :, :2])
    hi = np.minimum((a[:, :2] + a[:, 2:])[:, None], (b[:, :2] + b[:, 2:])[None])
    both = np.clip(hi - lo, 0, None).prod(2)
    size = a[:, 2:].prod(1)[:, None]
    return both / np.where(crowd[None], size, size + b[:, 2:].prod(1)[None] - both)


def evaluate_image(found, truth, iou, lo, hi):
    """cocoeval's evaluateImg of one class: matches and ignored, (10, n), and how many objects count"""
    ignore = (truth[:, 1] > 0) | (truth[:, 0] < lo) | (truth[:, 0] > hi)
    order = np.argsort(ignore, kind="mergesort")
    truth, ignore, iou = truth[order], ignore[order], iou[:, order]
    best = np.argsort(-found[:, 0], kind="mergesort")[:100]
    found, iou = found[best], iou[best]
    match, skip = np.zeros((10, len(found)), bool), np.zeros((10, len(found)), bool)
    for t, threshold in enumerate(THRESHOLDS):
        taken = np.zeros(len(truth), bool)
        for d in range(len(found)):
            least, m = min(threshold, 1 - 1e-10), -1
            for g in range(len(truth)):
                if taken[g] and not truth[g, 1]:
                    continue
                if m > -1 and not ignore[m] and ignore[g]:
                    break
                if iou[d, g] < least:
                    continue
                least, m = iou[d, g], g
            if m >= 0:
                taken[m] = match[t, d] = True
                skip[t, d] = ignore[m]
    outside = (found[:, 1] < lo) | (found[:, 1] > hi)
    skip |= ~match & outside
    return found[:, 0], match, skip, (~ignore).sum()


def precision(scores, match, skip, objects):
    """cocoeval's accumulate"""
    order = np.argsort(-scores, kind="mergesort")
    match, skip = match[:, order], skip[:, order]
    out = np.zeros(10)
    for t in range(10):
        tp, fp = np.cumsum(match[t] & ~skip[t]), np.cumsum(~match[t] & ~skip[t])
        recall, value = tp / objects, tp / (tp + fp + np.spacing(1))
        for i in range(len(value) - 1, 0, -1):
            value[i - 1] = max(value[i - 1], value[i])
        at = np.searchsorted(recall, RECALLS, side="left")
        out[t] = sum(value[i] for i in at if i < len(value)) / 101
    return out


def main():
    rng = np.random.default_rng(53)
    found, truth, pairs = [], [], []
    for i in range(IMAGES):
        m = rng.integers(0, 7)
        side = np.exp(rng.uniform(np.log(8), np.log(250), (m, 1)))
        boxes = np.hstack([rng.uniform(0, 300, (m, 2)), side * rng.uniform(.7, 1.4, (m, 2))])
        crowd = rng.random(m) < .15
        cls = rng.integers(0, CLASSES, m)
        near = boxes[rng.random(m) < .8]
        seen = np.concatenate([near, near[:2], rng.uniform(5, 200, (rng.integers(0, 4), 4))])
        seen = seen + rng.normal(0, 1, seen.shape) * seen[:, 2:3] * .06
        seen[:, 2:] = np.maximum(seen[:, 2:], 2)
        n = len(seen)
        of = rng.integers(0, CLASSES, n)
        for k, b in enumerate(near):
            of[k] = cls[np.flatnonzero((boxes == b).all(1))[0]] if rng.random() < .9 else of[k]
        score = np.round(rng.uniform(.05, 1, n), 1)
        found.append(np.column_stack([np.full(n, i), of, score, seen[:, 2:].prod(1)]))
        truth.append(np.column_stack([np.full(m, i), cls, boxes[:, 2:].prod(1) * .8, crowd]))
        pairs.append(overlaps(seen, boxes, crowd).astype(np.float32))
    arrays = {"found": np.concatenate(found), "truth": np.concatenate(truth),
              "iou": np.concatenate([p.reshape(-1) for p in pairs])}
    for name, (lo, hi) in RANGES.items():
        ap = np.full((CLASSES, 10), np.nan)
        for c in range(CLASSES):
            parts = [evaluate_image(f[f[:, 1] == c][:, 2:], t[t[:, 1] == c][:, 2:],
                                    p[f[:, 1] == c][:, t[:, 1] == c], lo, hi) for f, t, p in zip(found, truth, pairs)]
            objects = sum(p[3] for p in parts)
            if objects:
                scores, match, skip = (np.concatenate([p[k] for p in parts], axis=min(k, 1)) for k in range(3))
                ap[c] = precision(scores, match, skip, objects)
        arrays[name] = ap
        print(name, np.round(ap.mean(1), 4))
    np.savez_compressed(OUT, **arrays)


if __name__ == "__main__":
    main()
