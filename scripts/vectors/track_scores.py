#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Reference values of the scores of trackers, by NumPy and SciPy after TrackEval's rules, for tests/eval/test_track.

    scripts/vectors/track_scores.py        writes tests/vectors/track_scores.npz

Four sequences of things that wander, found with noise, misses, false boxes, exchanged ids and frames in which there is
nothing or nothing is found: truth and found (n, 7) sequence, frame, id, box; scores (5, 7) hota, deta, assa, mota, idf1,
switches, ids taken by somebody who is no twin, of each sequence and of all together; deta and assa (19) of all at each threshold.
"""
import os

import numpy as np
from scipy.optimize import linear_sum_assignment

OUT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../tests/vectors/track_scores.npz")
SEQUENCES, FRAMES = 4, 40
ALPHAS = np.arange(.05, .99, .05)
EPS = np.finfo(float).eps


def overlaps(a, b):
    lo, hi = np.maximum(a[:, None, :2], b[None, :, :2]), np.minimum(a[:, None, 2:], b[None, :, 2:])
    both = np.clip(hi - lo, 0, None).prod(2)
    size = [(x[:, 2:] - x[:, :2]).prod(1) for x in (a, b)]
    return both / (size[0][:, None] + size[1][None] - both)


def frames_of(truth, found):
    """Of each frame ids by number and the overlaps"""
    numbers = [{v: k for k, v in enumerate(sorted(set(x[:, 1])))} for x in (truth, found)]
    out = []
    for f in range(FRAMES):
        a, b = truth[truth[:, 0] == f], found[found[:, 0] == f]
        out.append(([numbers[0][v] for v in a[:, 1]], [numbers[1][v] for v in b[:, 1]], overlaps(a[:, 2:], b[:, 2:])))
    return out, len(numbers[0]), len(numbers[1])


def hota(frames, n, m):
    shared, of_truth, of_found = np.zeros((n, m)), np.zeros((n, 1)), np.zeros((1, m))
    for a, b, s in frames:
        whole = s.sum(0)[None] + s.sum(1)[:, None] - s
        shared[np.ix_(a, b)] += np.where(whole > EPS, s / np.where(whole > EPS, whole, 1), 0)
        of_truth[a, 0] += 1
        of_found[0, b] += 1
    align = shared / (of_truth + of_found - shared)
    pairs = []
    for a, b, s in frames:
        i, j = linear_sum_assignment(-(align[np.ix_(a, b)] * s))
        pairs += [(a[p], b[q], s[p, q]) for p, q in zip(i, j)]
    tp, associated = np.zeros(19), np.zeros(19)
    for t, alpha in enumerate(ALPHAS):
        count = np.zeros((n, m))
        for p, q, s in pairs:
            if s >= alpha - EPS:
                count[p, q] += 1
        tp[t] = count.sum()
        associated[t] = (count * count / np.maximum(1, of_truth + of_found - count)).sum()
    return np.stack([tp, of_truth.sum() - tp, of_found.sum() - tp, associated])


def clear(frames, n):
    """Identities k and k + 1 are twins for even k"""
    ever, before, owner = [None] * n, [None] * n, {}
    tp = fn = fp = switches = taken = 0
    for a, b, s in frames:
        if not a or not b:
            fp, fn = fp + len(b), fn + len(a)
            continue
        score = s + 1000. * np.array([[before[p] == q for q in b] for p in a])
        score[s < .5 - EPS] = 0
        i, j = linear_sum_assignment(-score)
        pairs = [(a[p], b[q]) for p, q in zip(i, j) if score[p, q] > EPS]
        switches += sum(ever[p] is not None and ever[p] != q for p, q in pairs)
        taken += sum(owner.get(q, p) // 2 != p // 2 for p, q in pairs)
        before = [None] * n
        for p, q in pairs:
            ever[p] = before[p] = q
            owner[q] = p
        tp, fn, fp = tp + len(pairs), fn + len(a) - len(pairs), fp + len(b) - len(pairs)
    return np.array([tp, fn, fp, switches, taken])


def identity(frames, n, m):
    """With a stand-in for each identity that stays alone, as Ristani et al. put it"""
    shared, of_truth, of_found = np.zeros((n, m)), np.zeros(n), np.zeros(m)
    for a, b, s in frames:
        shared[np.ix_(a, b)] += s >= .5
        of_truth[a] += 1
        of_found[b] += 1
    fp, fn = np.zeros((n + m, n + m)), np.zeros((n + m, n + m))
    fp[n:, :m] = fn[:n, m:] = 1e10
    for i in range(n):
        fn[i, :m] = fn[i, m + i] = of_truth[i]
    for j in range(m):
        fp[:n, j] = fp[n + j, j] = of_found[j]
    fn[:n, :m] -= shared
    fp[:n, :m] -= shared
    at = linear_sum_assignment(fn + fp)
    id_fn, id_fp = fn[at].sum(), fp[at].sum()
    return np.array([of_truth.sum() - id_fn, id_fn, id_fp])


def scores(h, c, i):
    deta, assa = h[0] / np.maximum(1, h[:3].sum(0)), h[3] / np.maximum(1, h[0])
    return [np.sqrt(deta * assa).mean(), deta.mean(), assa.mean(), (c[0] - c[2] - c[3]) / max(1, c[0] + c[1]),
            i[0] / max(1, i[0] + (i[1] + i[2]) / 2), c[3], c[4]], deta, assa


def make(rng):
    n = rng.integers(3, 7)
    place, speed = rng.uniform(0, 150, (n, 2)), rng.normal(0, 3, (n, 2))
    size, name = rng.uniform(25, 60, (n, 2)), rng.permutation(50)[:n] + 1
    truth, found = [], []
    for f in range(FRAMES):
        place += speed
        speed += rng.normal(0, .5, (n, 2))
        if rng.random() < .15:
            i, j = rng.integers(0, n, 2)
            name[[i, j]] = name[[j, i]]
        if rng.random() < .05:
            name[rng.integers(0, n)] = 100 + f
        boxes = np.hstack([place, place + size])
        for k in range(n):
            if 12 <= f < 14 or (k == 0 and 20 < f < 30):
                continue
            truth.append([f, 10 * k + 3, *boxes[k]])
        for k in range(n):
            if rng.random() < .8 and f not in (5, 6):
                found.append([f, name[k], *(boxes[k] + rng.normal(0, .1, 4) * np.tile(size[k], 2))])
        if rng.random() < .2 and f != 6:
            p = rng.uniform(0, 200, 2)
            found.append([f, 200 + f, *p, *(p + rng.uniform(10, 60, 2))])
    return np.array(truth), np.array(found)


def main():
    rng = np.random.default_rng(20)
    total, rows, truths, founds = [0, 0, 0], [], [], []
    for s in range(SEQUENCES):
        truth, found = make(rng)
        frames, n, m = frames_of(truth, found)
        counts = hota(frames, n, m), clear(frames, n), identity(frames, n, m)
        total = [a + b for a, b in zip(total, counts)]
        rows.append(scores(*counts)[0])
        truths.append(np.column_stack([np.full(len(truth), s), truth]))
        founds.append(np.column_stack([np.full(len(found), s), found]))
    row, deta, assa = scores(*total)
    print(np.round(np.array(rows + [row]), 4))
    np.savez_compressed(OUT, truth=np.concatenate(truths), found=np.concatenate(founds), scores=np.array(rows + [row]),
                        deta=deta, assa=assa)


if __name__ == "__main__":
    main()
