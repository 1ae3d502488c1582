#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A splat rasteriser in PyTorch, tiled, with autograd: what palmar bench --model splat is held against.

    scripts/peers/splat.py [--threads N] [--runs N] [--size S] [--gaussians N] [--tile T]

One image of three channels, the scene of scripts/vectors/splat.py. Gaussians are projected and sorted in one go; then
each tile takes those whose 3-sigma square meets it, and all of its pixels and Gaussians are one array: alpha, its
running product, the weighed sum. Prints a line of JSON like palmar bench's: medians of forward, and of forward and
backward with the mean of the image as the loss.
"""
import argparse
import json
import os
import sys
import time

import torch

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../vectors"))
import splat as reference

NEAR, LOW_PASS, MOST_ALPHA, LEAST_ALPHA, LEAST_LIGHT = .2, .3, .99, 1 / 255, 1e-4


def rotation(q):
    w, x, y, z = (q / q.norm(dim=1, keepdim=True)).unbind(1)
    return torch.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
                        2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
                        2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], 1).view(-1, 3, 3)


def project(centre, scale, quaternion, focal, middle):
    """Places (N, 2), the entries a, b, c of the inverse covariance, radii"""
    x, y, z = centre.unbind(1)
    axes = rotation(quaternion) * scale[:, None]
    over = focal / z
    p = over[:, None] * (axes[:, 0] - (x / z)[:, None] * axes[:, 2])
    r = over[:, None] * (axes[:, 1] - (y / z)[:, None] * axes[:, 2])
    a, b, c = (p * p).sum(1) + LOW_PASS, (p * r).sum(1), (r * r).sum(1) + LOW_PASS
    det = a * c - b * b
    mean = (a + c) / 2
    radius = torch.ceil(3 * torch.sqrt(mean + torch.sqrt(torch.clamp(mean * mean - det, min=.1))))
    return torch.stack([over * x + middle, over * y + middle], 1), torch.stack([c, -b, a], 1) / det[:, None], radius


def lists(uv, radius, size, tile):
    """For each tile, the Gaussians in it: a product of two tables, as that is one call"""
    edge = torch.arange(0, size, tile, dtype=uv.dtype)
    low, high = uv.detach() - radius[:, None], uv.detach() + radius[:, None]
    column = (high[:, :1] >= edge) & (low[:, :1] <= edge + tile - 1)
    row = (high[:, 1:] >= edge) & (low[:, 1:] <= edge + tile - 1)
    return [[(column[:, i] & row[:, j]).nonzero().squeeze(1) for i in range(len(edge))] for j in range(len(edge))]


def render(centre, scale, quaternion, opacity, colour, size, tile):
    focal, middle = size * .6 / .24, size / 2 - .5
    order = torch.argsort(centre.detach()[:, 2])
    order = order[centre.detach()[order, 2] > NEAR]
    uv, conic, radius = project(centre[order], scale[order], quaternion[order], focal, middle)
    opacity, colour = opacity[order], colour[order]
    pieces = []
    for j, line in enumerate(lists(uv, radius.detach(), size, tile)):
        strip = []
        for i, at in enumerate(line):
            h, w = min(tile, size - j * tile), min(tile, size - i * tile)
            if not len(at):
                strip.append(torch.zeros(h, w, 3))
                continue
            place, q = uv[at], conic[at]
            dx = place[:, :1] - torch.arange(i * tile, i * tile + w)            # (n, w)
            dy = place[:, 1:] - torch.arange(j * tile, j * tile + h)            # (n, h)
            power = ((-.5 * q[:, :1] * dx * dx)[:, None, :] + (-.5 * q[:, 2:] * dy * dy)[:, :, None]
                     - q[:, 1, None, None] * dy[:, :, None] * dx[:, None, :])
            alpha = torch.clamp(opacity[at, None, None] * torch.exp(power), max=MOST_ALPHA)
            alpha = (alpha * ((alpha >= LEAST_ALPHA) & (power <= 0))).view(len(at), -1)
            light = torch.cumprod(1 - alpha, 0)
            before = torch.cat([torch.ones(1, alpha.shape[1]), light[:-1]])
            weight = alpha * before * (light >= LEAST_LIGHT)
            strip.append((weight.t() @ colour[at]).view(h, w, 3))
        pieces.append(torch.cat(strip, 1))
    return torch.cat(pieces, 0)


def timed(run, runs):
    times = []
    for i in range(runs + 3):
        start = time.perf_counter()
        run()
        times.append(1e3 * (time.perf_counter() - start))
    times = sorted(times[3:])
    return times[len(times) // 2], times[0]


def main():
    parser = argparse.ArgumentParser()
    for name, default in (("threads", 2), ("runs", 20), ("size", 224), ("gaussians", 10000), ("tile", 16)):
        parser.add_argument("--" + name, type=int, default=default)
    o = parser.parse_args()
    torch.set_num_threads(o.threads)
    cloud = [torch.tensor(a) for a in reference.scene(o.gaussians)]

    def forward():
        with torch.no_grad():
            return render(*cloud, o.size, o.tile)

    def both():
        for t in cloud:
            t.requires_grad_(True)
            t.grad = None
        render(*cloud, o.size, o.tile).abs().mean().backward()

    image = forward()
    f, f_min = timed(forward, o.runs)
    b, b_min = timed(both, o.runs)
    print(json.dumps({"program": "torch " + torch.__version__, "threads": o.threads, "tile": o.tile,
                      "forward_ms": f, "forward_min_ms": f_min, "both_ms": b, "both_min_ms": b_min,
                      "mean": float(image.mean()),
                      "norms": [float(t.grad.norm()) for t in cloud]}))


if __name__ == "__main__":
    main()
