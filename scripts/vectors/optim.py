#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Weights after some steps of PyTorch's optimisers, in float64, and running statistics of its batch norm.

    scripts/vectors/optim.py > tests/optim/optim_vectors.h
"""
import torch

N, STEPS = 5, 6
torch.set_default_dtype(torch.float64)


def start():
    return torch.nn.Parameter(torch.tensor([(i - 2) / 4 for i in range(N)]))


def gradient(w, step):
    """Of a crooked valley: the same formula as in the C test."""
    k = torch.arange(N) + 1.0
    return k * (w - 0.25) + torch.sin(k * step) / 8


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
