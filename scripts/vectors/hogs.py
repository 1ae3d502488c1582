#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Reference values of HOGS's parts, by PyTorch in float64, for tests/models.

    scripts/vectors/hogs.py [NAME...]        writes tests/vectors/models/hogs_NAME.npz

V-PM is written as the paper has it: the condition of each Gaussian from what is sampled of the ViT's map, and the trunk
on all of it. Parameters and inputs are hashed from their names, so that the C tests make the same ones and the files
hold results alone: outputs, names of the parameters, the length of each one's gradient; of parameters with a row a set
that of the row in use.
"""
import contextlib
import io
import os
import sys

import numpy as np
import torch
import torch.nn.functional as F

HERE = os.path.dirname(os.path.abspath(__file__))
OUT = os.path.join(HERE, "../../tests/vectors/models")
sys.path[:0] = [HERE, os.path.join(HERE, "../peers")]

from pointnet2 import around, farthest, rows        # noqa: E402
from ops import SUITES, harmonics                             # noqa: E402
with contextlib.redirect_stdout(io.StringIO()):     # it prints its own vectors
    from models import named                        # noqa: E402

SETS, WHICH, N, VIT, SIDE = 3, 1, 11, 7, 3
RANGE = {"places": (-.1, .1), "centres": (-1, 1), "covariance": (0, 1e-4), "sh": (-1, 1), "place": (-.4, 2.4),
         "F": (-1, 1), "map": (-1, 1), "near_t": (-.01, .01), "hand": (-.07, .07), "surface": (-.05, .05),
         "inverse": (5, 10), "t": (0, .1), "true_t": (0, .1), "offset": (-.05, .05), "corners": (-.1, .1)}


def single(x):
    return torch.tensor(np.asarray(x).astype(np.float32).astype(np.float64))


def given(name, *shape):
    lo, hi = RANGE.get(name, (0, 1))
    return single(lo + (hi - lo) * (named(name, *shape) / 2 + .5))


class Params(dict):
    def __call__(self, name, *shape):
        near_one = len(shape) == 1 and name.endswith(".weight")
        fan = shape[2] if len(shape) == 3 else np.prod(shape[1:])
        scale = .5 if near_one else .125 if name.endswith("bias") or len(shape) == 1 else np.sqrt(3 / fan)
        self[name] = single(near_one + scale * named(name, *shape)).requires_grad_()
        return self[name]

    def linear(self, name, k, o):
        w, b = self(name + ".weight", o, k), self(name + ".bias", o)
        return lambda x: F.linear(x, w, b)

    def norm(self, name, n):
        w, b = self(name + ".weight", n), self(name + ".bias", n)
        return lambda x: F.layer_norm(x, (n,), w, b)

    def sets(self, name, *sizes, slope=.01):
        layers = [(self("%s.%d.weight" % (name, i), SETS, o, k)[WHICH], self("%s.%d.bias" % (name, i), SETS, o)[WHICH])
                  for i, (k, o) in enumerate(zip(sizes, sizes[1:]))]

        def run(x):
            for i, (w, b) in enumerate(layers):
                x = F.linear(F.leaky_relu(x, slope) if i else x, w, b)
            return x
        return run


def skin(p):
    x = (given("places", N, 3) - given("centre", 3)) * given("inverse", 3)
    w = torch.softmax(p.sets("skin", 3, 8, 8, 8, 8, 16)(x), -1)
    return {"weights": w, "l_skin": ((w - given("target", N, 16)) ** 2).sum(1).mean()}, {}


def sampled(x, place, h, w):
    """x (B, h w, C) at place (B, N, 2) in cells to (B, N, C)"""
    B, _, C = x.shape
    grid = (2 * place + 1) / torch.tensor([w, h], dtype=x.dtype) - 1
    maps = x.transpose(1, 2).reshape(B, C, h, w)
    return F.grid_sample(maps, grid[:, None], align_corners=False)[:, :, 0].transpose(1, 2)


def encoded(p, places, one_blob):
    unit = places / 2 + .5
    if one_blob:
        return one_blob_of(unit)
    return hash_grid_of(unit, p("vpm.hash.table", 40, 2))


def suite_function(name, case):
    """The function that scripts/vectors/ops.py holds an op against, out of its suite"""
    found = {}

    class Catch:
        def case(self, key, fn, *inputs, **_):
            found[key] = fn
    SUITES[name](Catch())
    return found[case]


one_blob_of = suite_function("one_blob", "sixteen")
hash_grid_of = suite_function("hash_grid", "halves")


def vpm(use_f, use_p, use_g, one_blob=False, alpha3=False):
    def run(p):
        f, cells, place = given("F", 1, VIT), given("map", 1, SIDE * SIDE, VIT), given("place", 1, N, 2)
        seen = [f.expand(N, VIT)] * use_f + [sampled(cells, place, SIDE, SIDE)[0]] * use_p
        enc = encoded(p, given("centres", N, 3), one_blob)
        condition = p.linear("vpm.reduce", VIT * len(seen), 6)(torch.cat(seen, 1))
        own = torch.cat((enc, 1e4 * given("covariance", N, 6), given("sh", N, 48), given("opacity", N, 1)), 1)
        x = torch.cat(([own] if use_g else []) + [condition], 1)
        out = p.sets("vpm.trunk", x.shape[1], 8, 8, 8, 15)(x)
        dp, ds, dq, z = out[:, :3], out[:, 3:6], out[:, 6:10], out[:, 10:]
        c = given("c_sh", N, 3)
        hidden = F.relu(p.linear("vpm.alpha1", 8, 64)(torch.cat((c, z), 1)))
        alpha = torch.sigmoid(p.linear("vpm.alpha2", 64, 3 if alpha3 else 1)(hidden))
        v = torch.sigmoid(p.linear("vpm.colour", 5, 3)(z))
        weight = given("weight", N)
        mean = lambda x: (x * weight).sum() / weight.sum()
        return {"l_place": mean(torch.linalg.norm(dp, dim=1)), "l_scale": mean(ds.abs().sum(1)),
                "l_rotation": mean(dq[:, 1:].abs().sum(1)), "place_change": dp, "scale_change": ds,
                "rotation_change": dq, "appearance": z, "colour": (1 - alpha) * c + alpha * v,
                "condition": condition[None]}, \
            {"place_change": "d_place", "scale_change": "d_scale", "rotation_change": "d_rotation"}
    return run


def avatar(p):
    parent = [-1] + [0 if i % 3 == 1 else i - 1 for i in range(1, 16)]
    enc = hash_grid_of(given("centres", N, 3) / 2 + .5, p("avatar.hash.table", 40, 2))
    pose, said = given("articulation", 16, 13), []
    everything = p.sets("avatar.pose.root", 192, 6)(pose[:, :12].reshape(1, -1))
    for i in range(16):
        x = torch.cat((pose[i:i + 1], said[parent[i]] if i else everything), 1)
        said.append(p.sets("avatar.pose.%d" % i, 19, 19, 6, slope=0)(x))
    x = torch.cat((enc, torch.cat(said, 1).expand(N, 96)), 1)
    out = given("started", 1) * p.sets("avatar.deform", 100, 8, 8, 8, 26)(x)
    looks = {k: p.sets("avatar.look_" + k, 5 + 15 + 16 + 16, 6, 6, 3) for k in ("hand", "object")}
    table = p("avatar.code", SETS, 16)
    v = given("direction", N, 3)
    seen = torch.cat((given("feature", N, 5), harmonics(v / v.norm(dim=1, keepdim=True))[:, 1:]), 1)
    look = lambda k, shade, code: torch.sigmoid(looks[k](torch.cat((seen, shade, code.expand(N, 16)), 1)))
    return {"place_change": out[:, :3], "scale_change": out[:, 3:6], "rotation_change": out[:, 6:10],
            "shade": out[:, 10:], "colour": look("hand", out[:, 10:], table[WHICH]),
            "rigid": look("object", 0 * out[:, 10:], table[WHICH])}, \
        {"place_change": "d_place", "scale_change": "d_scale", "rotation_change": "d_rotation"}


def batch_norm(p, name, x):
    return F.batch_norm(x, None, None, p(name + ".weight", x.shape[1]), p(name + ".bias", x.shape[1]), True)


def gpm(width):
    B, P, E, C, M = 2, 40, 4, 6, 9
    level = ((E + 6 + 48 + 1, 5), (5, 6), (6, 9))

    def tokens(p):
        points = given("points", B, P, 3)
        unit = points - points.mean(1, keepdim=True)
        unit = unit / torch.linalg.norm(unit, dim=2).amax(1)[:, None, None]
        e1, e2 = p.linear("embed1", 3, 64), p.linear("embed2", 64, 48)
        embed = lambda c: e2(F.leaky_relu(e1(c), .01))
        features = torch.cat((given("encoding", B, P, E), 1e4 * given("covariance", B, P, 6),
                              embed(given("colour", B, P, 3)), given("opacity", B, P, 1)), 2)
        index = farthest(unit, M)
        centres = rows(unit, index)
        near = around(unit, centres, .6, 8)
        x = torch.cat((rows(unit, near) - centres[:, :, None], rows(features, near)), 3).permute(0, 3, 1, 2)
        for i, (k, o) in enumerate(level):
            name = "sa1." + ("mlp_convs.%d" % i if i else "input")
            w, b = p(name + ".weight", o, k + (0 if i else 3), 1, 1), p(name + ".bias", o)
            x = F.relu(batch_norm(p, "sa1.mlp_bns.%d" % i, F.conv2d(x, w, b)))
        place = rows(given("place", B, P, 2), index)
        condition = given("base", B, C)[:, None] + sampled(given("map", B, SIDE * SIDE, C), place, SIDE, SIDE)
        return torch.cat((rows(points, index) - given("root", B, 3)[:, None], x.amax(3).transpose(1, 2), condition,
                          embed(rows(given("rgb", B, P, 3), index))), 2)

    def attention(p, name, x, heads, d):
        q, k, v = (p.linear("%s.self_attn.%s" % (name, part), d, d)(x).view(B, M, heads, d // heads).transpose(1, 2)
                   for part in "qkv")
        y = torch.softmax(q @ k.transpose(2, 3) / np.sqrt(d // heads), 3) @ v
        return p.linear(name + ".self_attn.out", d, d)(y.transpose(1, 2).reshape(B, M, d))

    def head(p, name, d, out):
        layers = [p.linear("%s.%d" % (name, i), d, o) for i, o in enumerate((d, d, out))]
        return lambda x: layers[2](F.relu(layers[1](F.relu(layers[0](x)))))

    def run(p):
        x = tokens(p)
        d = width or x.shape[2]
        x = p.linear("project", x.shape[2], d)(x) if width else x
        between = []
        for i in range(2):
            name = "encoder.%d" % i
            y = x + attention(p, name, x, 3, d)
            x = p.norm(name + ".norm1", d)(y)
            y = p.linear(name + ".linear2", 10, d)(F.relu(p.linear(name + ".linear1", d, 10)(x)))
            x = p.norm(name + ".norm2", d)(x + y)
            between.append(x)
        norm, t, r = p.norm("norm", d), head(p, "translation", d, 3), head(p, "rotation", d, 9)
        between = [norm(x) for x in between]
        dt, dr = t(between[-1]).mean(1), r(between[-1]).mean(1).view(B, 3, 3)
        weight = given("weight", B)
        smooth = lambda a, b: (F.smooth_l1_loss(a, b.expand_as(a), reduction="none").flatten(1).mean(1) * weight
                               ).sum() / weight.sum()
        R, true_R, corners = given("R", B, 3, 3), given("true_R", B, 3, 3), given("corners", B, 8, 3)
        turn = (true_R - R).view(B, 1, 9)
        l_rot = sum(smooth(r(x), turn) for x in between) / 2
        l_trans = sum(smooth(t(x), given("offset", B, 3)[:, None]) for x in between) / 2
        posed = lambda a, b: corners @ a.transpose(1, 2) + b[:, None]
        l_corner = smooth(posed(R + dr, given("t", B, 3) + dt), posed(true_R, given("true_t", B, 3)))
        return {"delta_T": dt, "delta_R": dr, "l_rot": l_rot, "l_trans": l_trans, "l_corner": l_corner,
                "l_pose": 10 * l_rot + 1e4 * l_trans + 1e3 * l_corner}, dict.fromkeys(("l_rot", "l_trans", "l_corner"))
    return run


def contact(p):
    B, H, S = 2, 60, 50
    R = single(torch.eye(3, dtype=torch.float64).expand(B, 3, 3).numpy() + .1 * given("near_R", B, 3, 3).numpy())
    t = given("near_t", B, 3)
    hand, surface = given("hand", B, H, 3), given("surface", B, S, 3)
    posed = surface @ R.transpose(1, 2) + t[:, None]
    d = torch.linalg.norm(hand[:, :, None] - posed[:, None], dim=3).amin(2)
    cell = torch.floor(((hand - t[:, None]) @ R + .0625) * 512)
    ball = ((cell - 31.5) ** 2).sum(2) < 400
    zone = (np.arange(B * H) % 8 - 1).reshape(B, H)
    touching = torch.zeros(B, H, dtype=torch.bool)
    for b in range(B):
        for z in range(6):
            at = np.nonzero(zone[b] == z)[0]
            i = at[int(d[b, at].argmin())]
            touching[b, i] = not ball[b, i]
    mean = lambda tau, which: (tau * torch.tanh(d / tau))[which].mean()
    return {"l_cont": mean(.01, touching), "l_pen": mean(.02, ball)}, {}


PARTS = {"skin": skin, "vpm_fpg": vpm(1, 1, 1), "vpm_fg": vpm(1, 0, 1, one_blob=True),
         "vpm_fp": vpm(1, 1, 0, alpha3=True), "vpm_pg": vpm(0, 1, 1), "gpm_wide": gpm(0),
         "gpm_projected": gpm(12), "contact": contact, "avatar": avatar}


def length(p, name):
    grad = p[name].grad
    if grad is None:
        return 0.
    by_rows = ".trunk." in name or name.startswith("skin.") or (name.startswith("avatar.") and ".hash." not in name)
    return float((grad[WHICH] if by_rows else grad).norm())


def main():
    for name in sys.argv[1:] or PARTS:
        p = Params()
        outputs, weighed_by = PARTS[name](p)
        terms = [(outputs[k] * given(weighed_by.get(k, "d_" + k), *outputs[k].shape)).sum() for k in outputs
                 if weighed_by.get(k, k)]
        loss = sum(terms)
        if loss.requires_grad:
            loss.backward()
        arrays = {k: v.detach().numpy() for k, v in outputs.items()}
        arrays.update(names=np.array(list(p), dtype=str), gradients=np.array([length(p, k) for k in p]))
        np.savez_compressed(os.path.join(OUT, "hogs_%s.npz" % name), **arrays)
        print(name, float(loss), len(p))


if __name__ == "__main__":
    main()
