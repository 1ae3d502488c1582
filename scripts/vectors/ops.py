#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Reference values and gradients of the ops, by PyTorch in float64, for tests/ops.

    scripts/vectors/ops.py [NAME...]        writes tests/vectors/ops/NAME.npz

A case has the arrays case.in0 ..., case.out0 ..., case.dout0 ..., case.din0 ..., and case.infer0 where
the op computes something else without training. Inputs are float32, so that both programs read the
same numbers. roi_align is written out in NumPy after torchvision's definition, and skinning
is the formula of scripts/vectors/geometry.py in torch.
"""
import importlib.util
import math
import os
import sys

import numpy as np
import torch
import torch.nn.functional as F

HERE = os.path.dirname(os.path.abspath(__file__))
OUT = os.path.join(HERE, "../../tests/vectors/ops")
rng = np.random.default_rng(2025)


def clear(*shape):
    """0.1 <= |x| < 1"""
    return (rng.uniform(0.1, 1, shape) * rng.choice([-1, 1], shape)).astype(np.float32)


def positive(*shape):
    return rng.uniform(0.5, 1.5, shape).astype(np.float32)


def apart(*shape):
    n = int(np.prod(shape))
    return (0.01 * (rng.permutation(n) - n // 2)).reshape(shape).astype(np.float32)


class Suite:
    def __init__(self):
        self.arrays = {}

    def case(self, name, fn, *inputs, const=(), infer=None):
        """fn of float64 tensors to a tensor or several; const: places of inputs without gradient."""
        x = [None if a is None else torch.tensor(np.asarray(a, np.float64), requires_grad=i not in const)
             for i, a in enumerate(inputs)]
        outs = fn(*x)
        outs = outs if isinstance(outs, (tuple, list)) else (outs,)
        douts = [rng.uniform(-1, 1, tuple(o.shape)).astype(np.float32) for o in outs]
        total = sum((o * torch.tensor(d.astype(np.float64))).sum() for o, d in zip(outs, douts))
        if total.requires_grad:
            total.backward()
        for i, a in enumerate(inputs):
            if a is None:
                continue
            self.arrays["%s.in%d" % (name, i)] = np.asarray(a, np.float32)
            if i not in const:
                grad = x[i].grad if x[i].grad is not None else torch.zeros_like(x[i])
                self.arrays["%s.din%d" % (name, i)] = grad.numpy()
        for i, (o, d) in enumerate(zip(outs, douts)):
            self.arrays["%s.out%d" % (name, i)] = o.detach().numpy()
            self.arrays["%s.dout%d" % (name, i)] = d
        if infer:
            self.arrays["%s.infer0" % name] = infer(*x).detach().numpy()


def unary(fn, wide=False):
    def make(s):
        s.case("one", fn, clear(1))
        s.case("rows", fn, clear(3, 67))
        s.case("map", fn, clear(2, 3, 5, 7))
        s.case("empty", fn, clear(0, 7))
        if wide:
            s.case("wide", fn, np.linspace(-12, 12, 241))
    return make


def binary(fn):
    def make(s):
        for name, a, b in (("same", (2, 3, 5), (2, 3, 5)), ("row", (4, 67), (67,)), ("column", (5, 33), (5, 1)),
                           ("channel", (2, 3, 4, 5), (1, 3, 1, 1)), ("crossed", (3, 1, 5), (4, 1)),
                           ("left", (1, 3), (2, 5, 3)), ("number", (2, 19), ()), ("numbers", (), ()),
                           ("gate", (2, 3, 4, 4), (2, 3, 1, 1)), ("empty", (0, 3), (1, 3))):
            s.case(name, fn, clear(*a), clear(*b))
        s.case("itself", lambda x: fn(x, x), clear(3, 17))
    return make


def scale(s):
    s.case("rows", lambda x: -2.5 * x, clear(3, 67))
    s.case("number", lambda x: -2.5 * x, clear())
    s.case("zero", lambda x: 0 * x, clear(5))
    s.case("empty", lambda x: -2.5 * x, clear(0, 7))


def leaky_relu(s):
    leaky = lambda x: F.leaky_relu(x, 0.1)
    s.case("one", leaky, clear(1))
    s.case("map", leaky, clear(2, 3, 5, 7))
    s.case("relu", F.relu, clear(3, 67))
    s.case("steep", lambda x: F.leaky_relu(x, 3), clear(19))
    s.case("empty", leaky, clear(0, 7))


def reshape(s):
    flat = lambda x: x.reshape(-1)
    s.case("flat", flat, clear(2, 3, 5))
    s.case("chain", lambda x: x.reshape(2, 12), clear(4, 6))
    s.case("number", flat, clear())
    s.case("empty", flat, clear(0, 7))


def detach(s):
    fn = lambda x, y: x * y.detach()
    s.case("beside", fn, clear(3, 5), clear(3, 5), const=(1,))
    s.case("empty", fn, clear(0), clear(0), const=(1,))


def sample_index(s):
    fn = lambda x, y: x + y * torch.arange(len(y), dtype=y.dtype)[:, None]
    s.case("beside", fn, clear(3, 5), np.ones((3, 5)), const=(1,))
    s.case("one", fn, clear(1, 2), np.ones((1, 2)), const=(1,))
    s.case("empty", fn, clear(0, 2), np.ones((0, 2)), const=(1,))


def permute(s):
    rolled = lambda x: x.permute(*np.roll(np.arange(x.dim()), 1).tolist())
    s.case("rolled", rolled, clear(2, 3, 5, 7))
    s.case("heads", lambda x: x.permute(0, 2, 1, 3), clear(2, 3, 4, 5))
    s.case("same", lambda x: x.permute(0, 1), clear(3, 5))
    s.case("transposed", rolled, clear(17, 33))
    s.case("row", rolled, clear(7))
    s.case("number", lambda x: x * 1, clear())
    s.case("empty", rolled, clear(3, 0))


def concat(s):
    at = lambda axis: lambda *x: torch.cat(x, axis)
    s.case("three", at(1), clear(2, 3, 5), clear(2, 1, 5), clear(2, 4, 5))
    s.case("first", at(0), clear(2, 7), clear(3, 7))
    s.case("last", at(2), clear(2, 3, 7), clear(2, 3, 2))
    s.case("alone", at(0), clear(5))
    s.case("itself", lambda x: torch.cat((x, x), 0), clear(2, 3))
    s.case("empty", at(0), clear(0, 7), clear(2, 7))


def slice_(s):
    s.case("middle", lambda x: x.narrow(1, 1, 3), clear(2, 4, 5))
    s.case("first", lambda x: x.narrow(0, 0, 1), clear(3, 7))
    s.case("whole", lambda x: x * 1, clear(5))
    s.case("nothing", lambda x: x.narrow(0, 2, 0), clear(5, 3))
    s.case("overlap", lambda x: x.narrow(0, 0, 3) * x.narrow(0, 2, 3), clear(5, 3))


def rows(s):
    def at(first, n):
        return lambda x: torch.nn.functional.pad(x, [0, 0] * (x.dim() - 1) + [16, 16]).narrow(0, first + 16, n)

    s.case("middle", at(2, 3), clear(7, 5))
    s.case("whole", at(0, 4), clear(4, 2, 3))
    s.case("numbers", at(1, 2), clear(5))
    s.case("before", at(-2, 3), clear(4, 3))
    s.case("behind", at(3, 4), clear(5, 3))
    s.case("outside", at(9, 2), clear(3, 2))
    s.case("overlap", lambda x: at(0, 3)(x) * at(2, 3)(x), clear(5, 3))


def linear(s):
    s.case("rows", F.linear, clear(3, 7), clear(5, 7), clear(5))
    s.case("no_bias", F.linear, clear(3, 7), clear(5, 7))
    s.case("vector", F.linear, clear(9), clear(4, 9), clear(4))
    s.case("deep", F.linear, clear(2, 3, 67), clear(17, 67), clear(17))
    s.case("one", F.linear, clear(1, 1), clear(1, 1), clear(1))
    s.case("no_rows", F.linear, clear(0, 7), clear(5, 7), clear(5))
    s.case("no_features", lambda x, w, b: x @ w.T + b, clear(3, 0), clear(5, 0), clear(5))


def matmul(s):
    s.case("batch", torch.matmul, clear(2, 3, 7), clear(2, 7, 5))
    s.case("one", torch.matmul, clear(1, 1), clear(1, 1))
    s.case("single", torch.matmul, clear(17, 33), clear(33, 19))
    s.case("empty_batch", torch.matmul, clear(0, 3, 7), clear(0, 7, 5))
    s.case("empty_sum", torch.matmul, clear(3, 0), clear(0, 5))


def attend(heads):
    def fn(q, k, v):
        B, T, C = q.shape
        split = lambda x: x.reshape(B, x.shape[1], heads, C // heads).transpose(1, 2)
        p = torch.softmax(split(q) @ split(k).transpose(2, 3) / math.sqrt(C // heads), -1)
        return (p @ split(v)).transpose(1, 2).reshape(B, T, C)
    return fn


def attention(s):
    s.case("cross", attend(2), clear(2, 5, 6), clear(2, 7, 6), clear(2, 7, 6))
    s.case("one", attend(1), clear(1, 1, 1), clear(1, 1, 1), clear(1, 1, 1))
    s.case("self", lambda x: attend(3)(x, x, x), clear(2, 9, 12))
    s.case("blocks", attend(2), clear(1, 67, 4), clear(1, 70, 4), clear(1, 70, 4))
    s.case("no_queries", attend(2), clear(2, 0, 6), clear(2, 7, 6), clear(2, 7, 6))
    s.case("empty_batch", attend(2), clear(0, 5, 6), clear(0, 7, 6), clear(0, 7, 6))


def conv2d(s):
    conv = lambda **o: lambda x, w, b=None: F.conv2d(x, w, b, **o)
    s.case("plain", conv(), clear(2, 3, 5, 7), clear(4, 3, 3, 3), clear(4))
    s.case("pointwise", conv(), clear(2, 5, 4, 9), clear(3, 5, 1, 1), clear(3))
    s.case("no_bias", conv(padding=1), clear(1, 2, 6, 5), clear(3, 2, 3, 3))
    s.case("strided", conv(stride=2, padding=1), clear(2, 3, 9, 8), clear(4, 3, 3, 3), clear(4))
    s.case("stem", conv(stride=2, padding=3), clear(1, 3, 13, 17), clear(2, 3, 7, 7))
    s.case("skip", conv(stride=2), clear(1, 4, 7, 9), clear(5, 4, 1, 1))
    s.case("dilated", conv(padding=2, dilation=2), clear(1, 2, 7, 9), clear(3, 2, 3, 3), clear(3))
    s.case("grouped", conv(padding=1, groups=2), clear(2, 4, 5, 6), clear(6, 2, 3, 3), clear(6))
    s.case("depthwise", conv(padding=1, groups=5), clear(2, 5, 6, 19), clear(5, 1, 3, 3), clear(5))
    s.case("oblong", conv(), clear(1, 2, 6, 8), clear(3, 2, 1, 5), clear(3))
    s.case("one", conv(), clear(1, 1, 1, 1), clear(1, 1, 1, 1), clear(1))
    s.case("empty", conv(padding=1), clear(0, 2, 6, 5), clear(3, 2, 3, 3), clear(3))
    s.case("only_h", conv(stride=(2, 1), padding=(4, 0)), clear(2, 3, 15, 7), clear(4, 3, 9, 1), clear(4))
    s.case("only_h_apart", conv(padding=(2, 0), dilation=(2, 1)), clear(1, 3, 8, 5), clear(2, 3, 3, 1))


def max_pool2d(s):
    pool = lambda *o, **k: lambda x: F.max_pool2d(x, *o, **k)
    s.case("stem", pool(3, 2, 1), apart(2, 3, 9, 8))
    s.case("halves", pool(2, 2), apart(1, 2, 5, 7))
    s.case("ceiled", pool(2, 2, ceil_mode=True), apart(1, 2, 5, 7))
    s.case("ceiled_pad", pool(3, 2, 1, ceil_mode=True), apart(1, 2, 6, 7))
    s.case("apart", pool(1, 3, ceil_mode=True), apart(1, 2, 7, 8))
    s.case("one", pool(3, 2, 1), apart(1, 1, 1, 1))
    s.case("empty", lambda x: torch.zeros(0, 3, 5, 4, dtype=x.dtype) + x.sum(), apart(0, 3, 9, 8))


def global_avg_pool(s):
    fn = lambda x: x.mean((2, 3))
    s.case("map", fn, clear(2, 3, 5, 7))
    s.case("one", fn, clear(1, 1, 1, 1))
    s.case("empty", fn, clear(0, 3, 5, 7))


def upsample_nearest(s):
    up = lambda f: lambda x: x.repeat_interleave(f, 2).repeat_interleave(f, 3)
    s.case("twice", up(2), clear(2, 3, 5, 7))
    s.case("triple", up(3), clear(1, 2, 3, 1))
    s.case("once", up(1), clear(1, 2, 3, 4))
    s.case("empty", up(2), clear(1, 3, 0, 7))


def resize_bilinear(s):
    to = lambda h, w: lambda x: F.interpolate(x, (h, w), mode="bilinear", align_corners=False)
    s.case("up", to(7, 11), clear(2, 3, 5, 4))
    s.case("down", to(3, 2), clear(1, 2, 8, 7))
    s.case("same", to(7, 11), clear(1, 1, 7, 11))
    s.case("from_one", to(7, 11), clear(1, 2, 1, 1))
    s.case("to_one", to(1, 1), clear(1, 2, 4, 3))
    s.case("empty", lambda x: torch.zeros(0, 3, 7, 11, dtype=x.dtype) + x.sum(), clear(0, 3, 5, 4))


def bilinear(x, y, u):
    """x (C, H, W) at row y, column u: 0 beyond a pixel outside, else clamped to the border."""
    H, W = x.shape[1:]
    if y < -1 or y > H or u < -1 or u > W:
        return torch.zeros(x.shape[0], dtype=x.dtype)
    y, u = max(y, 0), max(u, 0)
    y0, u0 = min(int(y), H - 1), min(int(u), W - 1)
    y1, u1 = min(y0 + 1, H - 1), min(u0 + 1, W - 1)
    fy, fu = (0 if y0 == H - 1 else y - y0), (0 if u0 == W - 1 else u - u0)
    top = x[:, y0, u0] * (1 - fu) + x[:, y0, u1] * fu
    return top * (1 - fy) + (x[:, y1, u0] * (1 - fu) + x[:, y1, u1] * fu) * fy


def roi(out_h, out_w, scale):
    def fn(x, boxes):
        pooled = []
        for box in boxes.detach().numpy():
            if not np.isfinite(box).all() or not 0 <= box[0] < x.shape[0]:
                pooled.append(torch.zeros(x.shape[1], out_h, out_w, dtype=x.dtype) + 0 * x.sum())
                continue
            x0, y0, x1, y1 = box[1:] * scale
            bin_h, bin_w = max(y1 - y0, 1) / out_h, max(x1 - x0, 1) / out_w
            n_y, n_x = math.ceil(bin_h), math.ceil(bin_w)
            cells = [sum(bilinear(x[int(box[0])], y0 + i * bin_h + (a + .5) * bin_h / n_y,
                                  x0 + j * bin_w + (b + .5) * bin_w / n_x)
                         for a in range(n_y) for b in range(n_x)) / (n_y * n_x)
                     for i in range(out_h) for j in range(out_w)]
            pooled.append(torch.stack(cells, 1).reshape(x.shape[1], out_h, out_w))
        return torch.stack(pooled) if pooled else torch.zeros(0, x.shape[1], out_h, out_w, dtype=x.dtype) + 0 * x.sum()
    return fn


def roi_align(s):
    boxes = [[0, 4, 4, 20, 24], [1, -10, -6, 12, 9], [1, 20, 18, 60, 70], [0, 8, 8, 8.5, 8.25],
             [0, 100, 100, 140, 140], [1, 30, 30, 10, 10], [0, 0, 0, 32, 36]]
    s.case("boxes", roi(4, 3, .25), clear(2, 3, 9, 8), boxes, const=(1,))
    nan, inf = math.nan, math.inf
    broken = [[2, 0, 0, 9, 9], [-1, 0, 0, 9, 9], [0, nan, 0, 9, 9], [0, 0, 0, inf, 9], [1, 0, 0, 9, 9], [nan, 0, 0, 9, 9]]
    s.case("broken", roi(4, 3, .25), clear(2, 2, 6, 6), broken, const=(1,))
    s.case("whole", roi(1, 1, .25), clear(1, 1, 20, 20), [[0, 0, 0, 80, 80], [0, -40, -40, 160, 150]], const=(1,))
    s.case("no_boxes", roi(4, 3, .25), clear(2, 3, 9, 8), np.zeros((0, 5)), const=(1,))
    s.case("no_images", roi(4, 3, .25), clear(0, 3, 9, 8), [[0, 0, 0, 9, 9], [1, 0, 0, 9, 9]], const=(1,))


def conv2d_within(s):
    def pooled(pad):
        def fn(x, w, b, boxes, more, others):
            return roi(4, 3, .25)(F.leaky_relu(F.conv2d(x, w, b, padding=pad), .1), boxes) + more
        return fn

    boxes = [[0, 4, 4, 20, 24], [1, 10, 6, 12, 9], [1, 20, 18, 60, 70], [0, 8, 8, 8.5, 8.25],
             [0, 100, 100, 140, 140], [1, 30, 30, 10, 10], [0, 9, 5, 16, 21]]
    others, x = [[1, 16, 16, 20, 20]], (2, 3, 9, 8)
    for name, k in ("square", 3), ("pointwise", 1):
        s.case(name, pooled(k // 2), clear(*x), clear(5, 3, k, k), clear(5), boxes, clear(7, 5, 4, 3), others,
               const=(3, 5))
    s.case("shrinking", pooled(0), clear(*x), clear(5, 3, 3, 3), clear(5), boxes, clear(7, 5, 4, 3), others,
           const=(3, 5))
    s.case("winograd", pooled(1), clear(2, 32, 20, 17), clear(32, 32, 3, 3), clear(32),
           [[0, 21, 30, 44, 61], [1, 33, 5, 64, 40]], clear(2, 32, 4, 3), others, const=(3, 5))
    s.case("no_boxes", pooled(1), clear(*x), clear(5, 3, 3, 3), clear(5), np.zeros((0, 5)), clear(0, 5, 4, 3), others,
           const=(3, 5))


LINKS = [(0, 0, 0, .5), (1, 3, 0, .25), (0, 1, 1, 1.5), (1, 2, 1, -.75), (0, 2, 2, 1), (1, 0, 2, 2), (1, 4, 2, .5),
         (0, 3, 3, -1), (0, 4, 4, .125), (1, 2, 4, 1)]


def aggregate(s):
    def fn(x, mask):
        C = x.shape[1] // 2
        A = torch.zeros(2, 5, 5, dtype=x.dtype)
        for k, v, w, a in LINKS:
            A[k, v, w] = a
        return sum(torch.einsum("bctv,vw->bctw", x[:, k * C:(k + 1) * C], A[k] * mask[k]) for k in range(2))

    s.case("few", fn, clear(2, 6, 3, 5), clear(2, 5, 5))
    s.case("moments", fn, clear(1, 2, 37, 5), clear(2, 5, 5))


def window_means(s):
    def to(h, w):
        def fn(x, more):
            if not len(x):
                return more + x.sum()
            y = F.interpolate(x, (h, w), mode="bilinear", align_corners=False)
            seen = [slice(0, -1), slice(None), slice(1, None)]
            return torch.stack([torch.stack([y[:, :, r, c].mean((2, 3)) for c in seen], 2) for r in seen], 2) + more
        return fn

    s.case("same", to(5, 4), clear(2, 3, 5, 4), clear(2, 3, 3, 3))
    s.case("up", to(10, 8), clear(2, 3, 5, 4), clear(2, 3, 3, 3))
    s.case("odd", to(2, 7), clear(1, 2, 6, 3), clear(1, 2, 3, 3))
    s.case("empty", to(10, 8), clear(0, 3, 5, 4), clear(0, 3, 3, 3))


def between(size, *shape):
    """Places clear of whole numbers, from three cells before a map to two behind it"""
    return (np.floor(rng.uniform(-3, np.asarray(size) + 2, shape)) + rng.uniform(.1, .9, shape)).astype(np.float32)


def sampled(x, at):
    """x (B, C, H, W) at (B, h, w, 2) columns and rows, cells' centres at whole numbers"""
    size = torch.tensor([x.shape[3], x.shape[2]], dtype=x.dtype)
    return F.grid_sample(x, (2 * at + 1) / size - 1, align_corners=False)


def deformable_attention(s):
    def fn(heads, h, w):
        def one_scale(value, offset, logit, reference):
            (B, _, C), T, P = value.shape, logit.shape[1], logit.shape[2] // heads
            maps = value.reshape(B, h, w, heads, C // heads).permute(0, 3, 4, 1, 2).reshape(B * heads, C // heads, h, w)
            at = reference[None, :, None, None] + offset.reshape(B, T, heads, P, 2)
            seen = sampled(maps, at.transpose(1, 2).reshape(B * heads, T, P, 2))
            share = torch.softmax(logit.reshape(B, T, heads, P), 3).transpose(1, 2).reshape(B * heads, 1, T, P)
            return (seen * share).sum(3).reshape(B, C, T).transpose(1, 2)
        return one_scale

    def case(name, B, heads, h, w, C, T, P):
        f = fn(heads, h, w) if B and T else lambda v, o, l, r: torch.zeros(B, T, C, dtype=v.dtype) + 0 * (v.sum() + o.sum() + l.sum())
        s.case(name, f, clear(B, h * w, C), between(1, B, T, heads * P * 2), clear(B, T, heads * P),
               np.floor(rng.uniform(-2, 9, (T, 2))), const=(3,))

    case("cross", 2, 2, 5, 7, 12, 9, 3)
    case("wide", 1, 2, 5, 7, 38, 5, 4)
    case("one", 1, 1, 1, 1, 1, 1, 1)
    case("no_queries", 2, 2, 5, 7, 6, 0, 2)
    case("empty_batch", 0, 2, 5, 7, 6, 3, 2)


def grid_sample(s):
    def case(name, x, h, w):
        B, C, H, W = x
        f = lambda a, g: F.grid_sample(a, g, align_corners=False)
        if B * h * w == 0:
            f = lambda a, g: torch.zeros(B, C, h, w, dtype=a.dtype) + 0 * (a.sum() + g.sum())
        s.case(name, f, clear(*x), (2 * between((W, H), B, h, w, 2) + 1) / np.array([W, H]) - 1)

    case("maps", (2, 3, 5, 7), 4, 3)
    case("channels", (1, 37, 6, 5), 2, 9)
    case("one", (1, 1, 1, 1), 1, 1)
    case("no_places", (2, 3, 5, 7), 0, 3)
    case("empty", (0, 3, 5, 7), 4, 3)


def conv_transpose2d(s):
    conv = lambda **k: lambda x, w, b=None: F.conv_transpose2d(x, w, b, **k)
    s.case("plain", conv(), clear(2, 3, 5, 4), clear(3, 4, 3, 3), clear(4))
    s.case("up1", conv(stride=2, padding=1), clear(2, 6, 4, 4), clear(6, 5, 3, 3), clear(5))
    s.case("up2", conv(stride=2, padding=1), clear(1, 4, 7, 6), clear(4, 3, 4, 4), clear(3))
    s.case("up3", conv(stride=2), clear(1, 3, 5, 6), clear(3, 2, 6, 6), clear(2))
    s.case("no_bias", conv(stride=2, padding=1), clear(1, 2, 6, 5), clear(2, 3, 4, 4))
    s.case("gaps", conv(stride=2), clear(1, 2, 3, 4), clear(2, 3, 1, 1), clear(3))
    s.case("oblong", conv(), clear(1, 2, 3, 4), clear(2, 3, 1, 5), clear(3))
    s.case("one", conv(), clear(1, 1, 1, 1), clear(1, 1, 1, 1), clear(1))
    s.case("empty", lambda x, w, b: torch.zeros(0, 3, 12, 10, dtype=x.dtype) + 0 * (x.sum() + w.sum() + b.sum()),
           clear(0, 2, 6, 5), clear(2, 3, 4, 4), clear(3))


def soft_argmax2d(s):
    def fn(h):
        H, W = h.shape[2:]
        u = (torch.arange(W, dtype=h.dtype) + .5) / W
        v = (torch.arange(H, dtype=h.dtype) + .5) / H
        return torch.stack(((h * u).sum((2, 3)), (h * v[:, None]).sum((2, 3))), 2)
    s.case("map", fn, clear(2, 3, 5, 7))
    s.case("one", fn, clear(1, 1, 1, 1))
    s.case("empty", fn, clear(0, 3, 5, 7))


def softmax(s):
    fn = lambda x: torch.softmax(x, -1)
    s.case("rows", fn, clear(3, 67))
    s.case("one", fn, clear(4, 1))
    s.case("high", fn, 100 + 3 * clear(3, 17))
    s.case("deep", fn, clear(2, 2, 3, 5))
    s.case("no_rows", fn, clear(0, 5))
    s.case("no_columns", lambda x: x * 1, clear(3, 0))


def layer_norm(s):
    fn = lambda x, w, b: F.layer_norm(x, x.shape[-1:], w, b, 1e-5)
    s.case("rows", fn, clear(2, 3, 8), clear(8), clear(8))
    s.case("one_row", fn, clear(5), clear(5), clear(5))
    s.case("prime", fn, clear(5, 67), clear(67), clear(67))
    s.case("no_rows", lambda x, w, b: x * w + b, clear(0, 7), clear(7), clear(7))
    s.case("no_columns", lambda x, w, b: x * w + b, clear(3, 0), clear(0), clear(0))


def l2_normalise(s):
    def fn(eps):
        return lambda x: x / (torch.sqrt((x * x).sum(1, keepdim=True)) + eps)
    s.case("map", fn(1e-10), clear(2, 3, 5, 7))
    s.case("rows", fn(0.5), clear(3, 67))
    s.case("wide", fn(0.5), clear(2, 5, 263))
    s.case("one", fn(0.5), clear(1, 1))
    s.case("empty", fn(1e-10), clear(0, 3, 2))


def batch_norm(s):
    train = lambda x, w, b, m, v: F.batch_norm(x, None, None, w, b, True, 0, 1e-5)
    infer = lambda x, w, b, m, v: F.batch_norm(x, m, v, w, b, False, 0, 1e-5)
    for name, shape in (("map", (2, 3, 5, 7)), ("rows", (9, 5)), ("one_channel", (3, 1, 4))):
        n = shape[1]
        s.case(name, train, clear(*shape), clear(n), clear(n), clear(n), positive(n), const=(3, 4), infer=infer)
    leaky = lambda x: F.leaky_relu(x, 0.1)
    stats = lambda n: (clear(n), clear(n), clear(n), positive(n))
    s.case("leaky", lambda *x: leaky(train(*x)), clear(2, 3, 5, 7), *stats(3), const=(3, 4),
           infer=lambda *x: leaky(infer(*x)))
    s.case("residual", lambda *x: leaky(x[5] + train(*x[:5])), clear(2, 3, 5, 7), *stats(3), clear(2, 3, 5, 7),
           const=(3, 4), infer=lambda *x: leaky(x[5] + infer(*x[:5])))
    s.case("sum", lambda *x: x[5] + train(*x[:5]), clear(3, 2, 4), *stats(2), clear(3, 2, 4), const=(3, 4),
           infer=lambda *x: x[5] + infer(*x[:5]))


def channel_affine(s):
    fn = lambda x, a, b: x * a.reshape(-1, *[1] * (x.dim() - 2)) + b.reshape(-1, *[1] * (x.dim() - 2))
    s.case("map", fn, clear(2, 3, 5, 7), clear(3), clear(3))
    s.case("rows", fn, clear(4, 5), clear(5), clear(5))
    s.case("empty", fn, clear(0, 5, 3), clear(5), clear(5))


def rot6d(s):
    def fn(x):
        b1 = F.normalize(x[..., :3], dim=-1)
        b2 = F.normalize(x[..., 3:] - (b1 * x[..., 3:]).sum(-1, keepdim=True) * b1, dim=-1)
        return torch.stack((b1, b2, torch.cross(b1, b2, dim=-1)), -1)
    s.case("joints", fn, clear(2, 16, 6))
    s.case("one", fn, clear(6))
    s.case("empty", fn, clear(0, 6))


def geometry():
    spec = importlib.util.spec_from_file_location("geometry", os.path.join(HERE, "geometry.py"))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def skin_of(h):
    """geometry.skin in torch: vertices and joints of one sample"""
    t = {k: torch.tensor(v) for k, v in h.items()}

    def one(R, beta):
        v = t["template"] + t["shapedirs"] @ beta
        joints = t["regressor"] @ v
        if "posedirs" in t:
            v = v + t["posedirs"] @ (R[1:] - torch.eye(3, dtype=R.dtype)).reshape(-1)
        A, at = [], []
        for k, p in enumerate(h["parent"]):
            bone = joints[k] - (joints[p] if k else 0)
            A.append(R[k] if k == 0 else A[p] @ R[k])
            at.append(bone if k == 0 else A[p] @ bone + at[p])
        A, at = torch.stack(A), torch.stack(at)
        move = at - torch.einsum("kab,kb->ka", A, joints)
        v = torch.einsum("ik,kab,ib->ia", t["weights"], A, v) + t["weights"] @ move
        return v - at[0], at - at[0]

    return one


def skin(s):
    g = geometry()
    hand, small = skin_of(g.hand()), skin_of(g.rig(37, 5, 3))
    bare = skin_of({k: v for k, v in g.rig(37, 5, 3).items() if k != "posedirs"})

    def both(R, beta):
        r = [hand(a, b) for a, b in zip(R, beta)]
        if not r:
            nothing = 0 * (R.sum() + beta.sum())
            return nothing + torch.zeros(0, g.V, 3), nothing + torch.zeros(0, 21, 3)
        v, joints = (torch.stack(x) for x in zip(*r))
        return v, torch.cat([joints, v[:, g.TIPS]], 1)[:, g.SIMPLE]

    def small_both(R, beta):
        v, joints = (torch.stack(x) for x in zip(*[small(a, b) for a, b in zip(R, beta)]))
        return v, torch.stack([v[:, 36], joints[:, 4], joints[:, 0], v[:, 2]], 1)

    s.case("both", both, clear(2, 16, 3, 3), clear(2, 10))
    s.case("vertices", lambda R, b: both(R, b)[0], clear(1, 16, 3, 3), clear(1, 10))
    s.case("keypoints", lambda R, b: both(R, b)[1], clear(1, 16, 3, 3), clear(1, 10))
    s.case("empty", both, clear(0, 16, 3, 3), clear(0, 10))
    s.case("small", small_both, clear(3, 5, 3, 3), clear(3, 3))
    s.case("bare", lambda R, b: torch.stack([bare(x, y)[0] for x, y in zip(R, b)]), clear(5, 5, 3, 3), clear(5, 3))


def loss(of):
    def fn(a, b, w=None):
        each = of(a - b)
        if w is None:
            return each.mean()
        per = each.reshape(each.shape[0], -1)
        return (per.mean(1) * w).sum() / w.sum()

    def make(s):
        w = positive(3)
        w[1] = 0
        s.case("weighed", fn, clear(3, 4, 5), clear(3, 4, 5), w, const=(2,))
        s.case("plain", fn, clear(3, 67), clear(3, 67))
        s.case("target", fn, clear(2, 5), clear(2, 5), positive(2), const=(1, 2))
        s.case("number", fn, clear(), clear())
    return make


def cross_entropy(s):
    def fn(x, t, w=None):
        rows = -(t * torch.log_softmax(x, -1)).sum(-1).flatten(1).mean(1) if x.ndim > 2 else \
            -(t * torch.log_softmax(x, -1)).sum(-1)
        return rows.mean() if w is None else (rows * w).sum() / w.sum()

    def targets(*shape):
        t = positive(*shape)
        t.flat[0] = 0
        return t

    w = positive(3)
    w[1] = 0
    s.case("weighed", fn, clear(3, 4, 5), targets(3, 4, 5), w, const=(2,))
    s.case("plain", fn, clear(3, 67), targets(3, 67))
    s.case("target", fn, clear(2, 3, 5), targets(2, 3, 5), positive(2), const=(1, 2))
    s.case("one", fn, clear(1, 1), positive(1, 1))


def sum_(s):
    s.case("rows", lambda x: x.sum(), clear(3, 67))
    s.case("number", lambda x: x.sum(), clear())
    s.case("empty", lambda x: x.sum(), clear(0, 7))


def confidence_target(s):
    def weighed(a, b, w):
        return ((a - b).abs().flatten(1).mean(1) * w).sum() / w.sum()

    def confidence(conf, x, y, g, mask, w):
        far = torch.sqrt((x - g[:, :, 0, None, None]) ** 2 + (y - g[:, :, 1, None, None]) ** 2)
        return weighed(conf, (torch.exp(-far) * mask[:, None]).detach(), w)

    def places(conf, x, y, g, mask, w):
        m = mask[:, None]
        return weighed(x * m, g[:, :, 0, None, None] * m, w) + weighed(y * m, g[:, :, 1, None, None] * m, w)

    m, p, mask = (2, 21, 2, 2), (2, 21, 2), rng.integers(0, 2, (2, 2, 2))
    s.case("confidence", confidence, positive(*m), positive(*m), positive(*m), positive(*p), mask, positive(2),
           const=(1, 2, 3, 4, 5))
    s.case("places", places, positive(*m), positive(*m), positive(*m), positive(*p), mask, positive(2),
           const=(0, 3, 4, 5))


def heatmap_loss(s):
    def around(u, n, margin):
        at = np.clip(u * (n - 2 * margin) + margin - .5, 0, n - 1)
        return np.maximum(0, 1 - abs(np.arange(n) - at[..., None]))

    def loss(h, w, margin):
        def fn(x, places, weight):
            p = places.numpy()
            target = around(p[..., 1], h, margin)[..., :, None] * around(p[..., 0], w, margin)[..., None, :]
            rows = -(torch.tensor(target).flatten(2) * torch.log_softmax(x, -1)).sum(-1).mean(1)
            return (rows * weight).sum() / weight.sum()
        return fn

    places = rng.uniform(-.2, 1.2, (3, 4, 2)).astype(np.float32)
    s.case("plain", loss(4, 5, 0), clear(3, 4, 20), places, positive(3), const=(1, 2))
    s.case("margin", loss(6, 7, 2), clear(3, 4, 42), places, positive(3), const=(1, 2))


def volume_loss(s):
    def around(at, n):
        return np.maximum(0, 1 - abs(np.arange(n) - np.clip(at, 0, n - 1)[..., None]))

    def loss(depth, rows, columns):
        def fn(x, places, known, weight):
            p = places.numpy()
            target = around(p[..., 2], depth)[..., :, None, None] * around(p[..., 1], rows)[..., None, :, None] \
                * around(p[..., 0], columns)[..., None, None, :]
            samples = -(torch.tensor(target).flatten(2) * torch.log_softmax(x, -1)).sum(-1).mul(known).mean(1)
            return (samples * weight).sum() / weight.sum()
        return fn

    places = rng.uniform(-1, 5, (3, 4, 3)).astype(np.float32)
    known = rng.integers(0, 2, (3, 4))
    s.case("volume", loss(2, 4, 5), clear(3, 4, 40), places, known, positive(3), const=(1, 2, 3))
    s.case("flat", loss(1, 3, 7), clear(3, 4, 21), places, np.ones((3, 4)), positive(3), const=(1, 2, 3))


def moved(x, T):
    return (T[:, :, :3] @ x[:, :, None])[:, :, 0] + T[:, :, 3]


def transform_points(s):
    s.case("each", moved, clear(7, 3), clear(7, 3, 4))
    s.case("shared", moved, clear(5, 3), clear(1, 3, 4))
    s.case("constant", moved, clear(3, 3), clear(3, 3, 4), const=(1,))
    s.case("one", moved, clear(1, 3), clear(1, 3, 4))
    s.case("empty", moved, clear(0, 3), clear(1, 3, 4))


def transform_back(s):
    fn = lambda x, T: (T[:, :, :3].transpose(1, 2) @ x[:, :, None])[:, :, 0]
    s.case("each", fn, clear(7, 3), clear(7, 3, 4))
    s.case("shared", fn, clear(5, 3), clear(1, 3, 4))
    s.case("empty", fn, clear(0, 3), clear(1, 3, 4))


def blend_transforms(s):
    fn = lambda w, T: torch.einsum("nb,bij->nij", w, T)
    s.case("field", fn, clear(9, 5), clear(5, 3, 4))
    s.case("constant", fn, clear(4, 2), clear(2, 3, 4), const=(1,))
    s.case("empty", fn, clear(0, 2), clear(2, 3, 4))


def left(q):
    """The matrix of r -> q r"""
    w, x, y, z = q.unbind(-1)
    rows = (w, -x, -y, -z), (x, w, -z, y), (y, z, w, -x), (z, -y, x, w)
    return torch.stack([torch.stack(r, -1) for r in rows], -2)


def rotation_of(q):
    """v -> u v conj(u), of unit vectors v, as products of quaternions"""
    u = q / q.norm(dim=-1, keepdim=True)
    conj = u * torch.tensor([1., -1, -1, -1], dtype=q.dtype)
    v = F.pad(torch.eye(3, dtype=q.dtype), (1, 0)).T                    # a column each
    product = left(u) @ torch.stack([(left(v[:, k]) @ conj[..., None])[..., 0] for k in range(3)], -1)
    return product[..., 1:, :]


def splat_axes(s):
    fn = lambda scale, q, T: T[:, :, :3] @ rotation_of(q) @ torch.diag_embed(torch.exp(scale))
    s.case("each", fn, clear(7, 3), clear(7, 4), clear(7, 3, 4))
    s.case("shared", fn, clear(5, 3), clear(5, 4), clear(1, 3, 4))
    s.case("constant", fn, clear(3, 3), clear(3, 4), clear(3, 3, 4), const=(2,))
    s.case("empty", fn, clear(0, 3), clear(0, 4), clear(1, 3, 4))


def splat_covariance(s):
    upper = torch.triu_indices(3, 3)
    fn = lambda M: (M @ M.transpose(1, 2))[:, upper[0], upper[1]]
    s.case("some", fn, clear(7, 3, 3))
    s.case("empty", fn, clear(0, 3, 3))


def quaternion_turn(s):
    def fn(q, d):
        return (left(torch.cat([torch.ones_like(d[:, :1]), d[:, 1:]], 1)) @ q[:, :, None])[:, :, 0]
    s.case("some", fn, clear(7, 4), clear(7, 4))
    s.case("empty", fn, clear(0, 4), clear(0, 4))


def harmonics(d):
    """The basis of 3DGS at unit directions: real spherical harmonics, with the signs (-1)^m and y, z, x its order"""
    x, y, z = d.unbind(-1)
    one, pi = torch.ones_like(x), math.pi
    k1, k2, k3 = math.sqrt(3 / (4 * pi)), math.sqrt(15 / pi) / 2, math.sqrt(7 / pi) / 4
    return torch.stack([
        one * math.sqrt(1 / (4 * pi)), -k1 * y, k1 * z, -k1 * x,
        k2 * x * y, -k2 * y * z, math.sqrt(5 / pi) / 4 * (3 * z * z - 1), -k2 * x * z, k2 / 2 * (x * x - y * y),
        -k3 * math.sqrt(2.5) * y * (3 * x * x - y * y), k3 * math.sqrt(60) * x * y * z,
        -k3 * math.sqrt(1.5) * y * (5 * z * z - 1), k3 * z * (5 * z * z - 3), -k3 * math.sqrt(1.5) * x * (5 * z * z - 1),
        k3 * math.sqrt(15) * z * (x * x - y * y), -k3 * math.sqrt(2.5) * x * (x * x - 3 * y * y)], -1)


def check_harmonics():
    """Against SciPy's complex ones: sqrt 2 times the real or imaginary part, which have Condon and Shortley's sign"""
    from scipy.special import sph_harm
    d = F.normalize(torch.tensor(clear(50, 3).astype(np.float64)), dim=-1)
    x, y, z = d.numpy().T
    azimuth, polar = np.arctan2(y, x), np.arccos(z)
    want = []
    for l in range(4):
        for m in range(-l, l + 1):
            part = sph_harm(abs(m), l, azimuth, polar)
            want.append(part.real if m == 0 else math.sqrt(2) * (part.imag if m < 0 else part.real))
    assert np.allclose(harmonics(d).numpy(), np.array(want).T, atol=1e-12)


def sh_colour(s):
    check_harmonics()

    def of_degree(degree):
        n = (min(max(degree, 0), 3) + 1) ** 2

        def fn(sh, v):
            b = harmonics(v / v.norm(dim=-1, keepdim=True))
            return torch.relu(0.5 + torch.einsum("nk,nkc->nc", b[:, :n], sh[:, :n]))
        return fn

    s.case("three", of_degree(3), clear(9, 16, 3), clear(9, 3))
    s.case("two", of_degree(2), clear(5, 16, 3), clear(5, 3))
    s.case("one", of_degree(1), clear(5, 16, 3), clear(5, 3))
    s.case("zero", of_degree(0), clear(5, 16, 3), clear(5, 3))
    s.case("negative", of_degree(-1), clear(2, 16, 3), clear(2, 3))
    s.case("nine", of_degree(9), clear(2, 16, 3), clear(2, 3))
    s.case("given", of_degree(3), clear(4, 16, 3), clear(4, 3), const=(1,))
    s.case("empty", of_degree(3), clear(0, 16, 3), clear(0, 3))


def nearest_rotation(s):
    def fn(X, otherwise):
        def one(x, other):
            U, _, Vh = torch.linalg.svd(x)
            return U @ Vh if torch.linalg.det(x) > 0 else other + 0 * x
        flat = [one(x, o) for x, o in zip(X.reshape(-1, 3, 3), otherwise.reshape(-1, 3, 3))]
        return torch.stack(flat).reshape(X.shape) if flat else 0 * X

    near = lambda *shape: (np.eye(3) + .3 * clear(*shape)).astype(np.float32)
    s.case("some", fn, near(6, 3, 3), near(6, 3, 3), const=(1,))
    s.case("one", fn, near(3, 3), near(3, 3), const=(1,))
    mirrored = near(1, 2, 3, 3)
    mirrored[0, 1, 0] *= -1
    s.case("mirrored", fn, mirrored, near(1, 2, 3, 3), const=(1,))
    s.case("empty", fn, near(0, 3, 3), near(0, 3, 3), const=(1,))


def isometry_loss(s):
    def loss(K, hole):
        def fn(a, b=None):
            n = len(a)
            i, j = torch.tensor([(i, (i + 2 * k + 1) % n) for i in range(n) for k in range(K) if i % hole]
                                ).reshape(-1, 2).long().T
            b = a if b is None else b
            d = (a[i] - a[j]).norm(dim=1) - (b[i] - b[j]).norm(dim=1)
            return d.abs().mean() if len(i) else 0 * (a.sum() + b.sum())
        return fn

    s.case("centres", loss(4, 1 << 20), clear(11, 3), clear(11, 3))
    s.case("covariances", loss(4, 1 << 20), clear(11, 6), clear(11, 6))
    s.case("before", loss(4, 1 << 20), clear(11, 3), clear(11, 3), const=(0,))
    s.case("holes", loss(3, 3), clear(10, 3), clear(10, 3))
    s.case("none", loss(2, 1), clear(5, 3), clear(5, 3))
    s.case("itself", loss(2, 99), clear(7, 3))
    s.case("empty", loss(4, 1 << 20), clear(0, 3), clear(0, 3))
def lattice():
    i = np.arange(64)
    return np.stack((i & 3, i >> 2 & 3, i >> 4 & 3), 1)[None].astype(np.float32)


def farthest(points, start, n):
    """Indices of one set's points (N, 3), in float64"""
    distance, at, out = np.full(len(points), np.inf), start, []
    for _ in range(n):
        out.append(at)
        distance = np.minimum(distance, ((points - points[at]) ** 2).sum(1))
        at = int(distance.argmax())
    return out


def farthest_point_sampling(s):
    def case(name, start, n, points):
        fn = lambda x, p: torch.stack([r[farthest(q.numpy(), i, n)] for r, q, i in zip(x, p, start)])
        s.case(name, fn, clear(*points.shape[:2], 2), points, const=(1,))
    case("some", (3, 0, 7), 5, clear(3, 37, 3))
    case("all", (1,), 19, clear(1, 19, 3))
    case("one", (0,), 1, clear(1, 1, 3))
    case("outside", (0, 0), 3, clear(2, 16, 3))
    case("no_start", (0, 0), 3, clear(2, 11, 3))
    case("more", (1,), 6, clear(1, 4, 3))
    case("lattice", (3,), 5, lattice())


def ball_query(s):
    def near(points, centre, radius, n):
        found = [i for i, p in enumerate(points) if ((p - centre) ** 2).sum() <= radius ** 2][:n]
        return found + found[:1] * (n - len(found))

    def case(name, radius, n, points, centres):
        def rows(r, p, centre):
            index = near(p.numpy(), centre.numpy(), radius, n)
            return r[index] if index else torch.zeros(n, 2, dtype=r.dtype)
        fn = lambda x, p, c: torch.stack([torch.stack([rows(r, q, d) for d in ds]) for r, q, ds in zip(x, p, c)])
        s.case(name, fn, clear(*points.shape[:2], 2), points, centres, const=(1, 2))
    case("some", .9, 7, clear(2, 53, 3), clear(2, 11, 3))
    case("many", 5, 3, clear(1, 17, 3), clear(1, 5, 3))
    case("one", .9, 7, clear(1, 1, 3), clear(1, 1, 3))
    case("lattice", 1, 8, lattice(), lattice())


def nearest(s):
    distance = lambda a, b: torch.linalg.norm(a[:, :, None] - b[:, None], dim=-1).amin(2)

    def which(a, b):
        j = torch.linalg.norm(a[:, :, None] - b[:, None], dim=-1).argmin(2)
        return torch.stack([p[i] for p, i in zip(b, j)])
    s.case("distance", distance, clear(2, 7, 3), clear(2, 37, 3))
    s.case("to_constants", distance, clear(1, 5, 3), clear(1, 16, 3), const=(1,))
    s.case("of_constants", distance, clear(1, 40, 3), clear(1, 3, 3), const=(0,))
    s.case("which", which, clear(2, 9, 3), clear(2, 19, 3), const=(0,))
    s.case("one", distance, clear(1, 1, 3), clear(1, 1, 3))


def unit_sphere(s):
    def fn(*count):
        def one(p, n):
            mean = p[:n].mean(0)
            radius = torch.linalg.norm(p[:n] - mean, dim=1).max()
            return (p - mean) / (radius if radius > 0 else 1)
        return lambda x, p: x * torch.stack([one(q, n) for q, n in zip(p, count)])
    s.case("all", fn(9, 9), clear(2, 9, 3), clear(2, 9, 3), const=(1,))
    s.case("first", fn(5, 99), clear(2, 8, 3), clear(2, 8, 3), const=(1,))
    s.case("one", fn(1), clear(1, 1, 3), clear(1, 1, 3), const=(1,))


def index_of(*shape):
    """-1 and 7 are no rows of 7"""
    i = np.arange(int(np.prod(shape)))
    return torch.tensor(np.where(i % 11 == 9, -1, np.where(i % 11 == 10, 7, 3 * i % 7)).reshape(shape))


def take(x, index):
    rows = torch.cat((x, torch.zeros_like(x[:, :1])), 1)
    index = torch.where((index < 0) | (index > 6), 7, index)
    return torch.stack([r[i] for r, i in zip(rows, index)])


def gather(s):
    s.case("flat", lambda x: take(x, index_of(2, 23)), clear(2, 7, 5))
    s.case("grouped", lambda x: take(x, index_of(2, 4, 5)), clear(2, 7, 3))
    s.case("numbers", lambda x: take(x, index_of(3, 9)), clear(3, 7))


def group(s):
    def fn(x, centre=None):
        y = take(x.transpose(1, 2), index_of(2, 4, 5)).permute(0, 3, 1, 2)
        return y if centre is None else y - centre[..., None]
    s.case("around", fn, clear(2, 3, 7), clear(2, 3, 4))
    s.case("no_centre", fn, clear(2, 6, 7))


def hash_grid(s):
    def level(x, table, scale, side, hashed):
        at = x.clamp(0, 1) * scale + .5
        cell = at.floor()
        way, cell, out = at - cell, cell.long(), 0
        for c in range(8):
            bit = torch.tensor([c & 1, c >> 1 & 1, c >> 2])
            k = cell + bit
            if hashed:
                mixed = k * torch.tensor([1, 2654435761, 805459861]) % 2 ** 32
                entry = (mixed[..., 0] ^ mixed[..., 1] ^ mixed[..., 2]) % len(table)
            else:
                entry = (k * torch.tensor([1, side, side * side])).sum(-1) % len(table)
            weight = torch.where(bit == 1, way, 1 - way).prod(-1)
            out = out + weight[..., None] * table[entry]
        return out

    def fn(levels, base, finest, log2_size):
        def run(x, table):
            outs, first = [], 0
            for l in range(levels):
                scale = base * (finest / base) ** (l / (levels - 1)) - 1
                side = math.ceil(round(scale, 9)) + 1
                hashed = (side ** 3 + 7) // 8 * 8 > 2 ** log2_size
                n = 2 ** log2_size if hashed else (side ** 3 + 7) // 8 * 8
                outs.append(level(x, table[first:first + n], scale, side, hashed))
                first += n
            assert first == len(table)
            return torch.cat(outs, -1)
        return run

    place = lambda *shape: rng.uniform(-.1, 1.1, shape).astype(np.float32)
    s.case("grids", fn(3, 4, 16, 8), place(2, 9, 3), clear(576, 2), const=(0,))
    s.case("dense", fn(2, 2, 3, 6), place(5, 3), clear(40, 1), const=(0,))
    s.case("one", fn(2, 2, 3, 6), place(3), clear(40, 3), const=(0,))
    s.case("halves", fn(2, 2, 4, 5), place(7, 3), clear(40, 2), const=(0,))


def one_blob(s):
    def fn(bins):
        def c(t):
            u = (bins * t).clamp(-1, 1)
            return .5 + 15 / 16 * u * (1 - 2 * u ** 2 / 3 + u ** 4 / 5)

        def run(x):
            edge = torch.arange(bins + 1, dtype=x.dtype) / bins - x[..., None]
            total = c(edge - 1) + c(edge) + c(edge + 1)
            return (total[..., 1:] - total[..., :-1]).flatten(-2)
        return run

    inside = lambda *shape: rng.uniform(.01, .99, shape).astype(np.float32)
    s.case("eight", fn(8), inside(7, 3))
    s.case("sixteen", fn(16), inside(7, 3), const=(0,))
    s.case("three", fn(3), inside(2, 3, 5))


def sample_rows(s):
    def fn(x, place):
        B, _, C = x.shape
        grid = (2 * place + 1) / torch.tensor([4., 3.], dtype=x.dtype) - 1
        maps = x.transpose(1, 2).reshape(B, C, 3, 4)
        return F.grid_sample(maps, grid[:, None], align_corners=False)[:, :, 0].transpose(1, 2)

    place = lambda *shape: rng.uniform(-1.5, 4.5, shape).astype(np.float32)
    s.case("rows", fn, clear(2, 12, 5), place(2, 7, 2), const=(1,))
    s.case("channels", fn, clear(1, 12, 67), place(1, 3, 2), const=(1,))


def max_(s):
    fn = lambda x: x.amax(-1)
    for name, shape in (("rows", (3, 67)), ("maps", (2, 3, 5, 32)), ("short", (9, 5)), ("one", (1, 1)), ("row", (17,))):
        s.case(name, fn, apart(*shape))


# ---- the detector: tables of all cells and all objects ----

NO = [-1, 0, 0, 0, 0, 0]
OBJECTS = np.array([[[2, 5, 9, 40.5, 33, 1], [0, 30, 2.5, 61, 50, 0], NO],
                    [NO, [1, 11, 20, 43, 60, 1], NO]], np.float32)


def detect_cells():
    """centre and stride of 84 cells, in pixels"""
    rows = [((x + .5) * s, (y + .5) * s, s) for s, n in ((8, 8), (16, 4), (32, 2)) for y in range(n) for x in range(n)]
    return np.array(rows)


def flat(*maps):
    """(B, C, H, W) of each level -> (B, cells, C)"""
    return torch.cat([m.flatten(2) for m in maps], 2).transpose(1, 2)


def seen_boxes(bins):
    """(B, cells, 64) -> x0 y0 x1 y1 in cells, and the bins' logits (B, cells, 4, 16)"""
    bins = bins.unflatten(2, (4, 16))
    d = (bins.softmax(3) * torch.arange(16.)).sum(3)
    cells = detect_cells()
    centre = torch.tensor(cells[:, :2] / cells[:, 2:])
    return torch.cat([centre - d[..., :2], centre + d[..., 2:]], 2), bins


def ciou(a, b, alpha=None):
    """Zheng et al. 2020, equations 9 to 11; with alpha where it is given"""
    tiny = 1e-7
    aw, ah = a[..., 2] - a[..., 0], a[..., 3] - a[..., 1] + tiny
    bw, bh = b[..., 2] - b[..., 0], b[..., 3] - b[..., 1] + tiny
    near, far = torch.minimum(a[..., 2:], b[..., 2:]), torch.maximum(a[..., :2], b[..., :2])
    common = (near - far).clamp(0).prod(-1)
    iou = common / (aw * ah + bw * bh - common + tiny)
    hull = torch.maximum(a[..., 2:], b[..., 2:]) - torch.minimum(a[..., :2], b[..., :2])
    rho = ((a[..., :2] + a[..., 2:] - b[..., :2] - b[..., 2:]) ** 2).sum(-1) / 4
    v = 4 / math.pi ** 2 * (torch.atan(bw / bh) - torch.atan(aw / ah)) ** 2
    if alpha is None:
        alpha = v / (v - iou + 1 + tiny)
    return iou - rho / ((hull ** 2).sum(-1) + tiny) - alpha * v, alpha


def assign_image(boxes, logits, objects):
    """What the cells of one image are assigned: TOOD over a table of objects and cells"""
    cells, out, n = detect_cells(), np.zeros((84, 3)), len(objects)
    metric, iou, alpha = (np.zeros((n, 84)) for _ in range(3))
    for g, o in enumerate(objects):
        if o[0] < 0:
            continue
        value, a = ciou(boxes, torch.tensor(o[1:5] / cells[:, 2:]))
        inside = ((cells[:, 0] > o[1]) & (cells[:, 1] > o[2]) & (cells[:, 0] < o[3]) & (cells[:, 1] < o[4]))
        iou[g], alpha[g] = value.clamp(0).numpy() * inside, a.numpy()
        metric[g] = np.sqrt(1 / (1 + np.exp(-logits[:, int(o[0])].numpy()))) * iou[g] ** 6
    best = np.zeros((n, 84), bool)
    for g in range(n):
        best[g, np.argsort(-metric[g], kind="stable")[:10]] = True
    best &= metric > 0
    out[:, 0] = np.where(best.any(0), np.where(best, iou, -1).argmax(0), -1)
    for g in range(n):
        mine = out[:, 0] == g
        if mine.any():
            out[mine, 1] = metric[g, mine] / metric[g, mine].max() * iou[g, mine].max()
            out[mine, 2] = alpha[g, mine]
    return out


def assign_cells(maps, objects):
    """maps: boxes of three levels, then classes"""
    with torch.no_grad():
        boxes, logits = seen_boxes(flat(*maps[:3]))[0], flat(*maps[3:6])
        return np.stack([assign_image(b, x, o) for b, x, o in zip(boxes, logits, objects)])


def assigned_rows(assigned, objects):
    """(image, cell), score, alpha and object's row of the cells that have one"""
    b, i = np.nonzero(assigned[..., 0].numpy() >= 0)
    t = assigned[b, i]
    return b, i, t[:, 1], t[:, 2], objects[b, t[:, 0].long()]


def class_loss(maps, objects, assigned):
    x = flat(*maps)
    b, i, score, _, o = assigned_rows(assigned, objects)
    target = torch.zeros_like(x)
    target[b, i, o[:, 0].long()] = score
    return F.binary_cross_entropy_with_logits(x, target, reduction="sum") / max(1, score.sum())


def box_losses(maps, objects, assigned):
    boxes, bins = seen_boxes(flat(*maps))
    b, i, score, alpha, o = assigned_rows(assigned, objects)
    cells = torch.tensor(detect_cells())[i]
    truth, centre = o[:, 1:5] / cells[:, 2:], (cells[:, :2] / cells[:, 2:])
    value, _ = ciou(boxes[b, i], truth, alpha)
    d = torch.cat([centre - truth[:, :2], truth[:, 2:] - centre], 1).clamp(0, 14.99)
    low, logits = d.floor().long(), bins[b, i].reshape(-1, 16)
    two = [F.cross_entropy(logits, k.reshape(-1), reduction="none").view_as(d) for k in (low, low + 1)]
    sides = (two[0] * (low + 1 - d) + two[1] * (d - low)).mean(1)
    total = max(1, score.sum())
    return ((1 - value) * score).sum() / total, (sides * score).sum() / total


def mask_loss(maps, proto, objects, assigned):
    """Pixel p of object k's mask is set where p % 3 is 0 or k is 1."""
    p = np.arange(256)
    masks = np.stack([(p % 3 == 0) | (k == 1) for k in range(3)]).astype(float)
    b, i, _, _, o = assigned_rows(assigned, objects)
    known = o[:, 5] > 0
    b, i, o, k = b[known], i[known], o[known], assigned[b, i][known][:, 0].long()
    z = torch.einsum("nk,nkhw->nhw", flat(*maps)[b, i], proto[b])
    loss = F.binary_cross_entropy_with_logits(z, torch.tensor(masks)[k].view(-1, 16, 16), reduction="none")
    box, at = o[:, 1:5] / 4, torch.arange(16.)
    x = (at >= box[:, :1]) & (at < box[:, 2:3])
    y = (at >= box[:, 1:2]) & (at < box[:, 3:])
    share = (box[:, 2] - box[:, 0]) * (box[:, 3] - box[:, 1]) / 256
    return ((loss * (y[:, :, None] & x[:, None])).mean((1, 2)) / share).sum() / max(1, len(k))


def some_cells():
    i = np.arange(168)
    assigned = i % 7 == 3
    out = np.stack([np.where(assigned, np.where(i >= 84, 1, i % 2), -1), assigned * rng.uniform(.1, .9, 168),
                    assigned * rng.uniform(.1, .5, 168)], 1)
    return out.reshape(2, 84, 3).astype(np.float32)


def levels(channels):
    return [clear(2, channels, n, n) for n in (8, 4, 2)]


def detect_assign(s):
    def fn(a, b, c, objects, factor):
        maps = [m[:, :64] for m in (a, b, c)] + [m[:, 64:] for m in (a, b, c)]
        assigned = assign_cells(maps, objects.numpy())
        assert len(set(assigned[0, :, 0])) == 3             # both objects have cells
        return torch.tensor(assigned) * factor

    s.case("assigned", fn, *levels(67), OBJECTS, clear(2, 84, 3), const=(0, 1, 2, 3))


def detect_class_loss(s):
    s.case("classes", lambda a, b, c, o, t: class_loss((a, b, c), o, t), *levels(3), OBJECTS, some_cells(),
           const=(3, 4))


def detect_box_loss(s):
    s.case("boxes", lambda a, b, c, o, t: box_losses((a, b, c), o, t), *levels(64), OBJECTS, some_cells(), const=(3, 4))


def detect_mask_loss(s):
    s.case("masks", lambda a, b, c, p, o, t: mask_loss((a, b, c), p, o, t), *levels(32), clear(2, 32, 16, 16), OBJECTS,
           some_cells(), const=(4, 5))


def ssim_loss(s):
    g = np.exp(-(np.arange(11) - 5) ** 2 / 4.5)
    window = torch.tensor(np.outer(g, g) / g.sum() ** 2)[None, None]

    def blur(x):
        return F.conv2d(x[:, None], window.to(x.dtype), padding=5)[:, 0]

    def loss(a, b):
        m, n = blur(a), blur(b)
        top = (2 * m * n + 1e-4) * (2 * (blur(a * b) - m * n) + 9e-4)
        return 1 - (top / ((m * m + n * n + 1e-4) * (blur(a * a) - m * m + blur(b * b) - n * n + 9e-4))).mean()

    s.case("picture", loss, positive(3, 17, 14), positive(3, 17, 14), const=(1,))
    s.case("small", loss, positive(1, 4, 7), positive(1, 4, 7), const=(1,))


SUITES = {
    "add": binary(torch.add), "sub": binary(torch.sub), "mul": binary(torch.mul), "scale": scale,
    "leaky_relu": leaky_relu, "sigmoid": unary(torch.sigmoid, True), "tanh": unary(torch.tanh, True),
    "silu": unary(F.silu, True), "elu": unary(F.elu), "gelu": unary(F.gelu, True),
    "quick_gelu": unary(lambda x: x * torch.sigmoid(1.702 * x), True), "reshape": reshape,
    "detach": detach, "sample_index": sample_index, "permute": permute, "concat": concat, "slice": slice_, "rows": rows, "linear": linear, "matmul": matmul,
    "attention": attention, "conv2d": conv2d, "max_pool2d": max_pool2d, "global_avg_pool": global_avg_pool,
    "deformable_attention": deformable_attention, "grid_sample": grid_sample, "conv_transpose2d": conv_transpose2d,
    "upsample_nearest": upsample_nearest, "resize_bilinear": resize_bilinear, "roi_align": roi_align,
    "conv2d_within": conv2d_within, "window_means": window_means, "aggregate": aggregate,
    "soft_argmax2d": soft_argmax2d, "softmax": softmax, "layer_norm": layer_norm,
    "l2_normalise": l2_normalise, "batch_norm": batch_norm,
    "channel_affine": channel_affine, "rot6d": rot6d, "skin": skin, "blend_transforms": blend_transforms,
    "transform_points": transform_points, "transform_back": transform_back, "splat_axes": splat_axes,
    "splat_covariance": splat_covariance, "quaternion_turn": quaternion_turn, "sh_colour": sh_colour,
    "nearest_rotation": nearest_rotation, "isometry_loss": isometry_loss, "mse_loss": loss(torch.square),
    "l1_loss": loss(torch.abs), "sum": sum_, "confidence_target": confidence_target,
    "cross_entropy": cross_entropy, "heatmap_loss": heatmap_loss, "volume_loss": volume_loss,
    "detect_assign": detect_assign, "detect_class_loss": detect_class_loss, "detect_box_loss": detect_box_loss,
    "detect_mask_loss": detect_mask_loss,
    "smooth_l1_loss": loss(lambda d: torch.where(d.abs() < 1, d ** 2 / 2, d.abs() - .5)), "max": max_,
    "ssim_loss": ssim_loss,
    "farthest_point_sampling": farthest_point_sampling, "ball_query": ball_query, "nearest": nearest,
    "unit_sphere": unit_sphere,
    "gather": gather, "group": group, "hash_grid": hash_grid, "one_blob": one_blob, "sample_rows": sample_rows,
}


def main():
    global rng
    os.makedirs(OUT, exist_ok=True)
    for name in sys.argv[1:] or SUITES:
        rng = np.random.default_rng(2025)
        s = Suite()
        SUITES[name](s)
        np.savez_compressed(os.path.join(OUT, name + ".npz"), **s.arrays)


if __name__ == "__main__":
    main()
