#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Weights after some steps of PyTorch's optimisers, in float64, and running statistics of its batch norm.

    scripts/vectors/optim.py > tests/optim/optim_vectors.h

Rows with clocks of their own are optimisers of their own here. Their growth is that of 3D Gaussian Splatting
(`cat_tensors_to_optimizer`, `_prune_optimizer`); schedules are its `get_expon_lr_func`, and what Ultralytics' trainer
does to its groups.
"""
import math

import numpy as np
import torch

N, STEPS = 5, 6
torch.set_default_dtype(torch.float64)


def start():
    return torch.nn.Parameter(torch.tensor([(i - 2) / 4 for i in range(N)]))


def gradient(w, step, which=0):
    """Of a crooked valley: the same formula as in the C test."""
    k = torch.arange(N) + 1.0
    return k * (w - 0.25) + torch.sin(k * step + which) / 8


def run(make, clip=0):
    w = start()
    opt = make([w])
    for step in range(1, STEPS + 1):
        w.grad = gradient(w.detach(), step)
        if clip:
            torch.nn.utils.clip_grad_norm_([w], clip)
        opt.step()
    return w.detach()


def show(name, a):
    print("static const double %s[] = { %s };" % (name, ", ".join("%.17g" % x for x in a)))


def statistics():
    bn = torch.nn.BatchNorm1d(2)
    for step in range(1, 4):
        i = torch.arange(8).reshape(4, 2)
        bn(torch.sin(i * step + 1.0) + i / 4)
    return torch.cat((bn.running_mean, bn.running_var))


def clipped(alone):
    """Two networks whose gradients are clipped together or each by its own norm, and points whose are not."""
    a, b, c = start(), start(), start()
    opt = [o.SGD([a], lr=0.05, momentum=0.9), o.SGD([b], lr=0.1), o.Adam([c], lr=0.02, eps=1e-15)]
    for step in range(1, STEPS + 1):
        for which, w in enumerate((a, b, c)):
            w.grad = gradient(w.detach(), step, which)
        for some in ([a], [b]) if alone else ([a, b],):
            torch.nn.utils.clip_grad_norm_(some, 0.5)
        for one in opt:
            one.step()
    return torch.cat((a, b, c)).detach()


def phases():
    """The first group steps always, the second from step 4 on, the third in odd steps."""
    w = [start(), start(), start()]
    opt = [o.Adam([x], lr=0.05) for x in w]
    for step in range(1, STEPS + 1):
        for which, x in enumerate(w):
            x.grad = gradient(x.detach(), step, which)
            if (True, step > 3, step % 2 == 1)[which]:
                opt[which].step()
    return torch.cat(w).detach()


def yolo():
    """Biases, weights, norms as Ultralytics' trainer has them, four batches an epoch; then their averages."""
    batches, epochs, warm, lr0, lrf, momentum = 4, 3, 6, 0.05, 0.01, 0.937
    lf = lambda x: max(1 - x / epochs, 0) * (1 - lrf) + lrf
    w = [start(), start(), start()]
    opt = o.SGD([w[0]], lr=lr0, momentum=momentum, nesterov=True)
    opt.add_param_group({"params": [w[1]], "weight_decay": 0.1})
    opt.add_param_group({"params": [w[2]], "weight_decay": 0.0})
    average = [x.detach().clone() for x in w]
    for ni in range(batches * epochs):
        for j, x in enumerate(opt.param_groups):
            x["lr"] = lr0 * lf(ni // batches)
            if ni <= warm:
                x["lr"] = np.interp(ni, [0, warm], [0.1 if j == 0 else 0.0, x["lr"]])
                x["momentum"] = np.interp(ni, [0, warm], [0.8, momentum])
        for which, x in enumerate(w):
            x.grad = gradient(x.detach(), ni + 1, which)
        opt.step()
        d = 0.9 * (1 - math.exp(-(ni + 1) / 5))
        for x, a in zip(w, average):
            a *= d
            a += (1 - d) * x.detach()
    return torch.cat(w).detach(), torch.cat(average)


def linear(epochs=10, lr0=0.01, lrf=0.01):
    x = o.SGD([start()], lr=lr0)
    s = o.lr_scheduler.LambdaLR(x, lr_lambda=lambda x: max(1 - x / epochs, 0) * (1 - lrf) + lrf)
    out = []
    for _ in range(13):
        out.append(x.param_groups[0]["lr"])
        x.step()
        s.step()
    return out


def log_linear(steps, lr_init=1.6e-4 * 1.0395, lr_final=1.6e-6 * 1.0395, max_steps=30000):
    t = np.clip(np.array(steps) / max_steps, 0, 1)
    return np.exp(np.log(lr_init) * (1 - t) + np.log(lr_final) * t)


def row(r):
    return torch.tensor([(i - 2) / 4 + r / 8 for i in range(N)])


def rows(grow):
    """Sets of rows 0, 1 to 2, 3 that step always, in odd steps, in every third; row 4 never does. In the middle the
    second set keeps its second row, and its first becomes a new one behind it."""
    w = [torch.nn.Parameter(torch.stack(x)) for x in ([row(0)], [row(1), row(2)], [row(3)])]
    opt = [o.Adam([x], lr=0.05, eps=1e-15) for x in w]
    for step in range(1, 2 * STEPS + 1):
        first = 0
        for k, x in enumerate(w):
            x.grad = torch.stack([gradient(x[r].detach(), step, first + r) for r in range(len(x))])
            first += len(x)
            if step % (k + 1) == (1 if k == 1 else 0):
                opt[k].step()
        if grow and step == STEPS:
            state = opt[1].state.pop(w[1])
            w[1] = torch.nn.Parameter(w[1].detach()[[1, 0]])
            for name in ("exp_avg", "exp_avg_sq"):
                state[name] = torch.stack((state[name][1], torch.zeros(N)))
            opt[1].param_groups[0]["params"] = [w[1]]
            opt[1].state[w[1]] = state
    return torch.cat(w + [row(4)[None]]).detach().flatten()


def muon(rows, columns):
    """Muon of a matrix as Liu et al. 2025 scale it, by singular values, which its rounds change and nothing else."""
    w = torch.arange(rows * columns).reshape(rows, columns) / 8 - 1.0
    pull = torch.arange(rows * columns).reshape(rows, columns) + 1.0
    mean, lr, decay, momentum, clip = torch.zeros(rows, columns), 0.05, 0.1, 0.95, 20
    for step in range(1, STEPS + 1):
        g = pull * (w - 0.25) / 8 + torch.sin(pull * step)
        g = g * min(1, clip / g.norm())
        mean = momentum * mean + (1 - momentum) * g
        ahead = momentum * mean + (1 - momentum) * g
        u, s, v = torch.linalg.svd(ahead / ahead.norm(), full_matrices=False)
        for _ in range(5):
            s = 3.4445 * s - 4.7750 * s ** 3 + 2.0315 * s ** 5
        w = w - lr * decay * w - lr * 0.2 * max(rows, columns) ** 0.5 * (u * s) @ v
    return w.flatten()


print("/* SPDX-License-Identifier: Apache-2.0 */")
print("/* Made by scripts/vectors/optim.py. */\n")
o = torch.optim
show("want_sgd", run(lambda p: o.SGD(p, lr=0.05, weight_decay=0.1)))
show("want_momentum", run(lambda p: o.SGD(p, lr=0.05, momentum=0.9, weight_decay=0.1)))
show("want_nesterov", run(lambda p: o.SGD(p, lr=0.05, momentum=0.9, nesterov=True)))
show("want_adam", run(lambda p: o.Adam(p, lr=0.05)))
show("want_adam_l2", run(lambda p: o.Adam(p, lr=0.05, betas=(0.8, 0.99), eps=1e-6, weight_decay=0.1)))
show("want_adamw", run(lambda p: o.AdamW(p, lr=0.05, weight_decay=0.1)))
show("want_clipped", run(lambda p: o.SGD(p, lr=0.05), clip=0.5))
show("want_statistics", statistics().detach())
show("want_joint", clipped(False))
show("want_alone", clipped(True))
show("want_phases", phases())
weights, average = yolo()
show("want_yolo", weights)
show("want_yolo_average", average)
show("want_linear", linear())
show("want_log_linear", log_linear([0, 1, 7500, 15000, 29999, 30000, 99999]))
show("want_muon_wide", muon(3, 5))
show("want_muon_tall", muon(5, 3))
show("want_rows", rows(False))
show("want_rows_grown", rows(True))
