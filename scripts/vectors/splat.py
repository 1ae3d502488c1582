#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Reference images and gradients of the splat rasteriser, by PyTorch in float64: every Gaussian at every pixel.

    scripts/vectors/splat.py            writes tests/vectors/ops/splat_raster.npz and tests/vectors/splat_scene.npz,
                                        every STEP-th row and column of the scene of palmar bench --model splat

Written from the formulas alone: no tiles, no lists, alpha by exp, the covariance inverted as a matrix, gradients by
autograd. Only the number of instances looks at tiles: an ellipse's border is sampled densely.
"""
import math
import os
import sys

import numpy as np
import torch

from ops import OUT, Suite
import ops

TILE, NEAR, LOW_PASS = 16, 0.2, 0.3
STEP = 7


def project(centre, axes, camera, offset, W, H):
    """Places (N, 2) and covariances (N, 2, 2) on the screen"""
    fx, fy, cx, cy = camera
    x, y, z = centre.unbind(1)
    tx, ty = W / (2 * fx), H / (2 * fy)
    xc = z * torch.clamp(x / z, -cx / fx - .3 * tx, (W - cx) / fx + .3 * tx)
    yc = z * torch.clamp(y / z, -cy / fy - .3 * ty, (H - cy) / fy + .3 * ty)
    o = torch.zeros_like(z)
    J = torch.stack([fx / z, o, -fx * xc / z ** 2, o, fy / z, -fy * yc / z ** 2], 1).reshape(-1, 2, 3)
    cov = J @ axes @ axes.transpose(1, 2) @ J.transpose(1, 2) + LOW_PASS * torch.eye(2, dtype=z.dtype)
    uv = torch.stack([fx * x / z + cx, fy * y / z + cy], 1)
    return (uv if offset is None else uv + offset), cov


def drawn_rows(centre, axes, opacity, colour):
    fine = torch.isfinite(centre).all(1) & torch.isfinite(axes).all(2).all(1) & torch.isfinite(opacity)
    return fine & torch.isfinite(colour).all(1) & (centre[:, 2] > NEAR) & (opacity >= 1 / 255)


def tiles_met(uv, cov, opacity, W, H):
    """For one Gaussian: of each row of tiles those between the ellipse's sides"""
    reach = 2 * math.log(255 * opacity)
    angle = np.linspace(0, 2 * np.pi, 40001)
    border = np.linalg.cholesky(cov) @ np.stack([np.cos(angle), np.sin(angle)]) * math.sqrt(reach) + uv[:, None]
    n = 0
    for top in range(0, H, TILE):
        inside = border[:, (border[1] >= top - .01) & (border[1] <= min(top + TILE - 1, H - 1) + .01)]
        rows = np.arange(top, min(top + TILE, H))
        if not len(rows[(rows >= border[1].min()) & (rows <= border[1].max())]):
            continue
        low, high = inside[0].min(), inside[0].max()
        first, last = max(0, math.ceil(low)), min(W - 1, math.floor(high))
        if first <= last:
            n += last // TILE - first // TILE + 1
    return n


def render(centre, axes, opacity, colour, camera, offset, W, H, first=0):
    """Planes and what they are made of, by name"""
    fine = drawn_rows(centre, axes, opacity, colour)
    n = len(centre)
    uv, cov = project(torch.where(fine[:, None], centre, torch.ones(3, dtype=centre.dtype)),
                      torch.where(fine[:, None, None], axes, torch.zeros(3, 3, dtype=centre.dtype)),
                      camera, offset, W, H)
    Q = torch.linalg.inv(cov)
    row, col = torch.meshgrid(torch.arange(H, dtype=centre.dtype), torch.arange(W, dtype=centre.dtype), indexing="ij")
    T, done = torch.ones(H, W, dtype=centre.dtype), torch.zeros(H, W, dtype=torch.bool)
    image = [torch.zeros(3, H, W, dtype=centre.dtype) for _ in range(2)]
    share = [torch.zeros(H, W, dtype=centre.dtype) for _ in range(2)]
    depth = torch.zeros(H, W, dtype=centre.dtype)
    for i in sorted((i for i in range(n) if fine[i]), key=lambda i: (np.float32(centre[i, 2].item()), i)):
        dx, dy = uv[i, 0] - col, uv[i, 1] - row
        sigma = .5 * (Q[i, 0, 0] * dx ** 2 + Q[i, 1, 1] * dy ** 2) + Q[i, 0, 1] * dx * dy
        alpha = torch.clamp(opacity[i] * torch.exp(-sigma), max=.99)
        there = (alpha >= 1 / 255) & ~done
        done = done | (there & (T * (1 - alpha) < 1e-4))
        w = torch.where(there & ~done, alpha * T, torch.zeros_like(T))
        s = 0 if i < first else 1
        image[s] = image[s] + w * colour[i][:, None, None]
        share[s] = share[s] + w
        depth = depth + w * centre[i, 2]
        T = torch.where(w > 0, T * (1 - alpha), T)
    return dict(image=image, share=share, depth=depth, light=T, uv=uv, cov=cov, fine=fine)


def counts(r, opacity, W, H):
    """radius (N) and the number of instances"""
    radius, instances = np.zeros(len(opacity)), 0
    for i in range(len(opacity)):
        if not r["fine"][i]:
            continue
        cov = r["cov"][i].detach().numpy()
        m = tiles_met(r["uv"][i].detach().numpy(), cov, float(opacity[i]), W, H)
        mean = (cov[0, 0] + cov[1, 1]) / 2
        instances += m
        if m:
            radius[i] = math.ceil(3 * math.sqrt(mean + math.sqrt(max(.1, mean ** 2 - np.linalg.det(cov)))))
    return torch.tensor(radius), torch.tensor(float(instances), dtype=torch.float64)


def raster(camera, W, H, first=None, white=False, opacity_too=False, depth=False, alone=True):
    """The op's results as a function of its inputs: the image alone, or all three"""
    def fn(centre, axes, opacity, colour, offset=None):
        r = render(centre, axes, opacity, colour, camera, offset, W, H, first or 0)
        bg = 1. if white else 0.
        planes = [r["image"][0] + r["image"][1] + r["light"] * bg]
        if first is not None:
            for s in range(2):
                planes.append(r["image"][s] + (r["share"][1 - s] + r["light"]) * bg)
        if first is not None or opacity_too:
            planes.append((1 - r["light"])[None])
        if first is not None:
            planes += [r["share"][0][None], r["share"][1][None]]
        if depth:
            planes.append(r["depth"][None])
        return torch.cat(planes) if alone else (torch.cat(planes), *counts(r, opacity, W, H))
    return fn


# ---- cases: the numbers stand in tests/ops/splat/raster.c as well ------------------------------------------------

CAMERA = (20., 22., 9.5, 8.)
W, H = 21, 18


def cloud(rng, n, spread, size, far=0):
    """n Gaussians around z = 2, apart in depth"""
    centre = np.stack([rng.uniform(-spread, spread, n) + far, rng.uniform(-spread, spread, n),
                       1.5 + .1 * rng.permutation(n) + rng.uniform(0, .05, n)], 1)
    axes = rng.uniform(-size, size, (n, 3, 3)) + size * np.eye(3)
    return (centre, axes, rng.uniform(.2, .6, n), rng.uniform(0, 1, (n, 3)), np.zeros((n, 2)))


def splat_raster(s):
    rng = np.random.default_rng(50)
    s.case("one", raster(CAMERA, W, H), *cloud(rng, 6, .5, .6))
    s.case("one_white", raster(CAMERA, W, H, white=True, opacity_too=True, depth=True), *cloud(rng, 6, .5, .6))
    s.case("sets", raster(CAMERA, W, H, first=3, depth=True), *cloud(rng, 6, .5, .6))
    s.case("sets_white", raster(CAMERA, W, H, first=2, white=True), *cloud(rng, 6, .5, .6))
    s.case("slanted", raster(CAMERA, W, H, first=1), *cloud(rng, 4, .2, .9, far=1.5))
    s.case("without_offset", raster(CAMERA, W, H, opacity_too=True), *cloud(rng, 5, .5, .6)[:4])
    small = cloud(rng, 60, .7, .04)
    small[2][:] = rng.uniform(.01, .95, 60)
    s.case("small", raster(CAMERA, W, H, first=30, depth=True, alone=False), *small)
    dense = cloud(rng, 80, .4, .2)
    dense[2][:] = rng.uniform(.5, .98, 80)
    s.case("dense", raster(CAMERA, W, H, first=40, alone=False), *dense)
    none = cloud(rng, 8, .5, .4)
    none[0][0, 2], none[0][1, 2], none[0][2, 0] = -1, .1, np.nan            # behind, too near, no place
    none[1][3], none[1][4, 1, 1], none[2][5], none[3][6, 1] = 0, np.inf, 1 / 300, np.nan
    s.case("degenerate", raster(CAMERA, W, H, first=4, alone=False), *none)
    s.case("none", raster(CAMERA, W, H, white=True, alone=False), *cloud(rng, 0, .5, .4))


# ---- the scene of the benchmark -------------------------------------------------------------------------------------

def scene(n=10000):
    rng = np.random.RandomState(7)
    h = n // 2
    d = rng.randn(h, 3)
    shell = d / np.sqrt((d ** 2).sum(1, keepdims=True)) * (.055, .095, .035) + (-.02, 0, 0)
    box = (rng.rand(n - h, 3) - .5) * (.10, .07, .07) + (.03, .02, -.02)
    centre = np.concatenate([shell, box]) + (0, 0, .6)
    scale = .0022 * np.exp(.35 * rng.randn(n, 3))
    quaternion = rng.randn(n, 4)
    opacity = 1 / (1 + np.exp(-(1.5 * rng.randn(n) + .5)))
    return [a.astype(np.float32) for a in (centre, scale, quaternion, opacity, rng.rand(n, 3))]


def rotation(q):
    w, x, y, z = (q / np.linalg.norm(q, axis=1, keepdims=True)).T
    return np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
                     2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
                     2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], 1).reshape(-1, 3, 3)


def draw_scene(path, size=224):
    centre, scale, quaternion, opacity, colour = (a.astype(np.float64) for a in scene())
    axes = (rotation(quaternion) * scale[:, None, :]).astype(np.float32).astype(np.float64)
    focal, middle = size * .6 / .24, size / 2 - .5
    with torch.no_grad():
        r = render(*(torch.tensor(a) for a in (centre, axes, opacity, colour)), (focal, focal, middle, middle), None,
                   size, size)
    image = (r["image"][0] + r["image"][1]).numpy()
    print("mean %.7f, mean opacity %.7f" % (image.mean(), 1 - r["light"].mean()))
    np.savez_compressed(path, image=image[:, ::STEP, ::STEP].astype(np.float32))


if __name__ == "__main__":
    suite = Suite()
    ops.rng = np.random.default_rng(2025)
    splat_raster(suite)
    np.savez_compressed(os.path.join(OUT, "splat_raster.npz"), **suite.arrays)
    draw_scene(os.path.join(OUT, "../splat_scene.npz"))
