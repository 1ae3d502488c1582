# SPDX-License-Identifier: Apache-2.0
"""The action model in PyTorch: the twin of models/action, with its parameter names, and whole adjacency matrices."""
import math

import torch
from torch import nn
from torch.nn import functional as F

BODY = [(0, 1), (0, 2), (1, 3), (2, 4), (3, 5), (4, 6), (5, 14), (5, 15), (5, 16), (6, 17), (6, 18), (6, 19), (0, 7),
        (7, 8), (7, 9), (8, 10), (9, 11), (10, 12), (11, 13), (7, 24), (24, 22), (24, 23), (22, 20), (23, 21)]
UNITS = {"small": (32, 32, 64, 64, 128, 128), "full": (64, 64, 64, 64, 128, 128, 128, 256, 256, 256)}


def fingers(wrist, first):
    return [(first + i - 1 if i % 4 else wrist, first + i) for i in range(20)]


def neighbours(n, edges):
    a = torch.eye(n, dtype=torch.float64)
    for i, k in edges:
        a[i, k] = a[k, i] = 1
    return a


def body_graph(centre=7):
    edges = BODY + fingers(12, 25) + fingers(13, 45)
    a = neighbours(65, edges)
    far = torch.full((65,), 65)
    far[centre] = 0
    for _ in range(65):
        for i, k in edges:
            far[i], far[k] = min(far[i], far[k] + 1), min(far[k], far[i] + 1)
    n, out = a / a.sum(0), torch.zeros(3, 65, 65, dtype=torch.float64)
    for v in range(65):
        for w in range(65):
            out[0 if v == w else 1 if far[v] >= far[w] else 2, v, w] = n[v, w]
    return out


def hand_object_graph():
    cube = [(21 + i, 21 + (i | b)) for i in range(8) for b in (1, 2, 4) if not i & b]
    a = neighbours(30, fingers(0, 1) + cube + [(29, 21 + i) for i in range(8)] + [(29, i) for i in (0, 4, 8, 12, 16, 20)])
    d = a.sum(0).rsqrt()
    return (d[:, None] * a * d)[None]


class Conv(nn.Conv2d):
    def __init__(self, i, o, k, s=1, out=None):
        super().__init__(i, o, (k, 1), (s, 1), (k // 2, 0))
        self.bn = nn.BatchNorm2d(out or o)


class Unit(nn.Module):
    def __init__(self, i, o, first, dropout, graph):
        super().__init__()
        stride = 1 if first or i == o else 2
        self.spatial, self.mask = Conv(i, 3 * o, 1, 1, o), nn.Parameter(torch.ones(3, 65, 65))
        self.temporal = Conv(o, o, 9, stride)
        if not first and i != o:
            self.residual = Conv(i, o, 1, stride)
        self.first, self.dropout = first, 0 if first else dropout
        self.register_buffer("graph", graph, persistent=False)

    def forward(self, x):
        y = self.spatial(x)
        y = y.view(y.shape[0], 3, -1, *y.shape[2:])
        y = F.relu(self.spatial.bn(torch.einsum("bkctv,kvw->bctw", y, self.graph * self.mask)))
        y = F.dropout(self.temporal.bn(self.temporal(y)), self.dropout, self.training)
        if self.first:
            return F.relu(y)
        return F.relu(y + (self.residual.bn(self.residual(x)) if hasattr(self, "residual") else x))


def normed(bn, x):
    """Of each node's coordinates, over time"""
    b, c, t, v = x.shape
    return bn(x.permute(0, 1, 3, 2).reshape(b, c * v, t)).view(b, c, v, t).permute(0, 1, 3, 2)


class Body(nn.Module):
    def __init__(self, variant, dropout):
        super().__init__()
        c, graph = UNITS[variant], body_graph().float()
        self.bn = nn.BatchNorm1d(195)
        share = dropout * (0.5 if variant == "full" else 0.3)
        self.units = nn.ModuleList(Unit(c[k - 1] if k else 3, c[k], k == 0, share, graph) for k in range(len(c)))

    def forward(self, x):
        x = normed(self.bn, x)
        for unit in self.units:
            x = unit(x)
        return x.mean((2, 3))


class Graph(nn.Linear):
    def __init__(self, i):
        super().__init__(i, 64)
        self.mask, self.bn = nn.Parameter(torch.ones(1, 30, 30)), nn.BatchNorm2d(64)
        self.register_buffer("graph", hand_object_graph().float(), persistent=False)

    def forward(self, x):
        y = F.conv2d(x, self.weight[:, :, None, None], self.bias)
        return F.relu(self.bn(torch.einsum("bctv,vw->bctw", y, (self.graph * self.mask)[0])))


class Attention(nn.Module):
    def __init__(self):
        super().__init__()
        self.q, self.k, self.v, self.out = (nn.Linear(128, 128) for _ in range(4))

    def forward(self, x, penalty):
        q, k, v = (f(x).view(*x.shape[:2], 4, 32).transpose(1, 2) for f in (self.q, self.k, self.v))
        w = torch.softmax(q @ k.transpose(2, 3) / math.sqrt(32) + penalty, -1)
        return self.out((w @ v).transpose(1, 2).reshape(x.shape))


class Layer(nn.Module):
    def __init__(self, dropout):
        super().__init__()
        self.norm1, self.attn, self.norm2 = nn.LayerNorm(128), Attention(), nn.LayerNorm(128)
        self.fc1, self.fc2, self.drop = nn.Linear(128, 256), nn.Linear(256, 128), nn.Dropout(dropout)

    def forward(self, x, penalty):
        x = x + self.drop(self.attn(self.norm1(x), penalty))
        return x + self.drop(self.fc2(self.drop(F.relu(self.fc1(self.norm2(x))))))


class HandObject(nn.Module):
    def __init__(self, frames, dropout):
        super().__init__()
        self.bn, self.graph1, self.graph2 = nn.BatchNorm1d(90), Graph(3), Graph(64)
        self.token = nn.Linear(1920, 128)
        self.class_token, self.position = nn.Parameter(torch.zeros(128)), nn.Parameter(torch.zeros(1 + frames, 128))
        self.layers, self.norm = nn.ModuleList(Layer(dropout) for _ in range(3)), nn.LayerNorm(128)

    def forward(self, x, valid):
        y = self.graph2(self.graph1(normed(self.bn, x)))
        y = self.token(y.permute(0, 2, 1, 3).flatten(2))
        y = torch.cat((self.class_token.expand(len(x), 1, -1), y), 1) + self.position
        penalty = F.pad(64 * (valid - 1), (1, 0))[:, None, None]
        for layer in self.layers:
            y = layer(y, penalty)
        return self.norm(y[:, 0])


class Head(nn.Module):
    def __init__(self, features, dropout):
        super().__init__()
        self.fc1, self.norm1, self.fc2, self.norm2 = nn.Linear(features, 256), nn.LayerNorm(256), nn.Linear(256, 128), \
            nn.LayerNorm(128)
        self.fc3, self.drop = nn.Linear(128, 10), nn.Dropout(dropout)

    def forward(self, x):
        x = self.drop(F.relu(self.norm1(self.fc1(x))))
        return self.fc3(self.drop(F.relu(self.norm2(self.fc2(x)))))


class Action(nn.Module):
    def __init__(self, variant="small", frames=30, dropout=1):
        super().__init__()
        self.body, self.hand_object = Body(variant, dropout), HandObject(frames, 0.1 * dropout)
        self.head = Head(UNITS[variant][-1] + 128, 0.3 * dropout)

    def forward(self, body, hand_object, valid, on):
        x = self.hand_object(hand_object, valid) * on[:, None]
        return self.head(torch.cat((self.body(body), x), 1))

    def loss(self, body, hand_object, valid, on, target, weight):
        rows = -(target * F.log_softmax(self(body, hand_object, valid, on), 1)).sum(1)
        return (rows * weight).sum() / weight.sum()
