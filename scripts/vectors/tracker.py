#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Reference values of the tracker and of linear assignment, by NumPy and SciPy, for tests/vision/test_tracker.

    scripts/vectors/tracker.py        writes tests/vectors/tracker.npz

The trackers of Wojke et al. 2017 with filters of eight states and whole matrices, and SciPy's linear_sum_assignment;
one tracker for each class. A film of eight things of two classes whose ways cross, with misses, false boxes, low
scores while hidden and frames dropped: times (F), found (n, 7) frame, box, score, class, look (n, 16); the tracks
reported by deepsort and byte as published, by plain (byte without embeddings) and iou, (m, 8) each: frame, id, class,
detection or -1, box; of the detections that are kept (n), three of four, the same by deepsort and byte where looks
have a say in the overlap (deepsort_looks, byte_looks). Costs (k, 7, 7) of which the first rows x cols of size (k, 2)
count, and least, the sum of the best assignment.
"""
import os

import numpy as np
from scipy.optimize import linear_sum_assignment

OUT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../tests/vectors/tracker.npz")
FPS, SIZE, FRAMES = 30, 16, 150
GATE, MAX_COS, MAX_IOU, LOW_IOU = 9.4877, 0.2, 0.7, 0.5
LOOK_CONF, OVERLAP_COS, UNSURE_IOU = 0.6, 0.5, 0.4
MIN_CONF, LOW_CONF, MAX_AGE, N_INIT, BUDGET = 0.3, 0.1, 30, 3, 100


def measurement(b):
    return np.array([(b[0] + b[2]) / 2, (b[1] + b[3]) / 2, (b[2] - b[0]) / (b[3] - b[1]), b[3] - b[1]])


class Filter:
    """x y a h and their velocities"""
    F = np.block([[np.eye(4), np.eye(4)], [np.zeros((4, 4)), np.eye(4)]])
    H = np.hstack([np.eye(4), np.zeros((4, 4))])

    def __init__(self, box):
        z = measurement(box)
        h = z[3]
        self.x = np.concatenate([z, np.zeros(4)])
        self.P = np.diag([2 * h / 20, 2 * h / 20, 1e-2, 2 * h / 20, 10 * h / 160, 10 * h / 160, 1e-5, 10 * h / 160]) ** 2

    def predict(self):
        h = self.x[3]
        q = np.diag([h / 20, h / 20, 1e-2, h / 20, h / 160, h / 160, 1e-5, h / 160]) ** 2
        self.x = self.F @ self.x
        self.P = self.F @ self.P @ self.F.T + q

    def project(self):
        h = self.x[3]
        return self.H @ self.x, self.H @ self.P @ self.H.T + np.diag([h / 20, h / 20, 1e-1, h / 20]) ** 2

    def distance(self, box):
        z, s = self.project()
        d = measurement(box) - z
        return d @ np.linalg.solve(s, d)

    def update(self, box):
        z, s = self.project()
        k = np.linalg.solve(s, self.H @ self.P).T
        self.x = self.x + k @ (measurement(box) - z)
        self.P = self.P - k @ s @ k.T

    def box(self):
        x, y, a, h = self.x[:4]
        return np.array([x - a * h / 2, y - h / 2, x + a * h / 2, y + h / 2])


class Track:
    def __init__(self, ident, det, least):
        self.id, self.filter, self.hits, self.age, self.det = ident, Filter(det["box"]), 1, 0, det["index"]
        self.looks = [det["look"]] if det["score"] >= least else []

    def confirmed(self):
        return self.hits >= N_INIT


def iou(a, b):
    w, h = min(a[2], b[2]) - max(a[0], b[0]), min(a[3], b[3]) - max(a[1], b[1])
    if w <= 0 or h <= 0:
        return 0.
    return w * h / ((a[2] - a[0]) * (a[3] - a[1]) + (b[2] - b[0]) * (b[3] - b[1]) - w * h)


def pair(tracks, dets, cost, limit):
    """Pairs, tracks left and detections left"""
    if not tracks or not dets:
        return [], tracks, dets
    c = np.array([[cost(t, d) for d in dets] for t in tracks])
    c[c > limit] = limit + 1e-5
    pairs = [(tracks[i], dets[j]) for i, j in zip(*linear_sum_assignment(c)) if c[i, j] <= limit]
    took_t, took_d = [id(t) for t, _ in pairs], [id(d) for _, d in pairs]
    return pairs, [t for t in tracks if id(t) not in took_t], [d for d in dets if id(d) not in took_d]


def cosine(t, d):
    return min(1 - (look @ d["look"]) / np.linalg.norm(look) / np.linalg.norm(d["look"]) for look in t.looks)


def appearance(t, d):
    return 1e5 if t.filter.distance(d["box"]) > GATE else cosine(t, d)


def overlap(t, d):
    return 1 - iou(t.filter.box(), d["box"])


def overlap_of_alike(t, d):
    cost = overlap(t, d)
    if d["score"] < LOOK_CONF:
        return cost if cost <= UNSURE_IOU else 1e5
    return 1e5 if t.looks and cosine(t, d) > OVERLAP_COS else cost


def appearance_of_sure(t, d):
    return appearance(t, d) if t.looks and d["score"] >= LOOK_CONF else 1e5


class Tracker:
    def __init__(self, method):
        self.looks = method.endswith("_looks")
        self.method, self.tracks = method.split("_")[0], []

    def match(self, dets, k):
        high = [d for d in dets if d["score"] >= MIN_CONF]
        low = [d for d in dets if LOW_CONF <= d["score"] < MIN_CONF]
        pairs, left = [], list(self.tracks)
        if self.method in ("deepsort", "byte"):
            for age in range(1, MAX_AGE + 1):
                level = [t for t in left if t.confirmed() and t.age == age]
                more, _, high = pair(level, high, appearance_of_sure if self.looks else appearance, MAX_COS)
                pairs += more
                left = [t for t in left if id(t) not in [id(m) for m, _ in more]]
            seen = [t for t in left if self.looks or t.age == k]
        else:
            seen = [t for t in left if t.age <= MAX_AGE]
        place = overlap_of_alike if self.looks else overlap
        more, _, high = pair(seen, high, place, MAX_IOU)
        pairs += more
        left = [t for t in left if id(t) not in [id(m) for m, _ in more]]
        if self.method in ("byte", "plain"):
            more, _, _ = pair([t for t in left if t.age == k and t.confirmed()], low, place, LOW_IOU)
            pairs += more
        return pairs, high

    def step(self, dets, k):
        for t in self.tracks:
            for _ in range(k):
                t.filter.predict()
            t.age += k
            t.det = -1
        pairs, new = self.match(dets, k)
        for t, d in pairs:
            t.filter.update(d["box"])
            t.hits, t.age, t.det = t.hits + 1, 0, d["index"]
            if d["score"] >= (LOOK_CONF if self.looks else MIN_CONF):
                t.looks = (t.looks + [d["look"]])[-BUDGET:]
        self.tracks = [t for t in self.tracks if t.age == 0 or (t.confirmed() and t.age <= MAX_AGE)]
        return new


def run(times, film, method):
    trackers, rows, last, before = {}, [], 0, None
    for f, time in enumerate(times):
        k = 1 if before is None else max(1, int(np.floor((time - before) * FPS + .5)))
        before = time
        new = []
        for c in sorted(set(trackers) | {d["cls"] for d in film[f]}):
            trackers.setdefault(c, Tracker(method))
            new += [(d["index"], c, d) for d in trackers[c].step([d for d in film[f] if d["cls"] == c], k)]
        for _, c, d in sorted(new, key=lambda x: x[0]):
            last += 1
            trackers[c].tracks.append(Track(last, d, LOOK_CONF if trackers[c].looks else MIN_CONF))
        shown = [(t.id, c, t) for c in trackers for t in trackers[c].tracks if t.confirmed() and t.age <= 1]
        for ident, c, t in sorted(shown, key=lambda x: x[0]):
            rows.append([f, ident, c, t.det, *t.filter.box()])
    return np.array(rows)


def make_film(rng):
    """Ellipses through each other; the last frames are a tenth of a second apart"""
    dropped = {20, 21, 60, 90, 91, 92, 93, 94}
    times = [f / FPS for f in range(FRAMES) if f not in dropped and (f < 130 or f % 3 == 0)]
    looks = rng.normal(size=(8, SIZE))
    looks[1] = looks[0] + .2 * rng.normal(size=SIZE)            # twins
    film = []
    for time in times:
        dets = []
        for i in range(8):
            a = time * (.5 + .13 * i) + i
            c = np.array([200 + 150 * np.cos(a), 120 + 30 * np.sin(1.7 * a) + 5 * i])
            h = 60 + 3 * i + 8 * np.sin(a)
            w = h * (.4 if i < 5 else 1.1)
            hidden = i % 3 == 0 and abs(np.cos(a)) < .25
            box = np.concatenate([c - [w / 2, h / 2], c + [w / 2, h / 2]]) + rng.normal(size=4) * .03 * h
            score = rng.uniform(.05, .35) if hidden else rng.uniform(.4, .95)
            if rng.random() > .08 and not (i == 5 and 1.5 < time < 2) and not (i == 2 and 2 < time < 3.4):
                look = looks[i] + .25 * rng.normal(size=SIZE)
                dets.append((box, score, 0 if i < 5 else 7, look))
        if rng.random() < .2:
            c = rng.uniform(0, 300, 2)
            dets.append((np.concatenate([c, c + rng.uniform(20, 90, 2)]), rng.uniform(.1, .7), 0, rng.normal(size=SIZE)))
        rng.shuffle(dets)
        film.append(dets)
    return times, film


def listed(film):
    rows, looks = [], []
    for f, dets in enumerate(film):
        for box, score, cls, look in dets:
            rows.append([f, *box, score, cls])
            looks.append(look)
    return np.array(rows).astype(np.float32), np.array(looks).astype(np.float32)


def by_frame(times, rows, looks, kept):
    out = []
    for f in range(len(times)):
        at = np.flatnonzero((rows[:, 0] == f) & kept)
        out.append([{"index": n, "box": rows[i, 1:5].astype(float), "score": float(rows[i, 5]), "cls": int(rows[i, 6]),
                     "look": looks[i].astype(float)} for n, i in enumerate(at)])
    return out


def assignments(rng):
    sizes = rng.integers(1, 8, (60, 2))
    cost = np.zeros((60, 7, 7))
    least = []
    for k, (n, m) in enumerate(sizes):
        c = rng.integers(0, 5, (n, m)) if k % 2 else rng.normal(size=(n, m))
        cost[k, :n, :m] = c
        i, j = linear_sum_assignment(c)
        least.append(c[i, j].sum())
    return sizes.astype(np.float64), cost, np.array(least, float)


def main():
    rng = np.random.default_rng(132)
    with np.errstate(all="ignore"):
        times, raw = make_film(rng)
    rows, looks = listed(raw)
    kept = np.random.default_rng(7).random(len(rows)) > .25
    arrays = {"times": np.array(times), "found": rows, "look": looks, "kept": kept.astype(np.float32)}
    for method in ("deepsort", "byte", "plain", "iou", "deepsort_looks", "byte_looks"):
        film = by_frame(times, rows, looks, kept | (not method.endswith("_looks")))
        arrays[method] = run(times, film, method).astype(np.float32)
        print(method, len(arrays[method]), "boxes,", len(set(arrays[method][:, 1])), "tracks")
    arrays["size"], arrays["cost"], arrays["least"] = assignments(rng)
    np.savez_compressed(OUT, **arrays)


if __name__ == "__main__":
    main()
