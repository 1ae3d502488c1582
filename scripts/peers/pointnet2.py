# SPDX-License-Identifier: Apache-2.0
"""PointNet++ with one radius a level in PyTorch, as ULIP sizes it (models/pointnet2/pointnet2.py there): the first
level alone, or the whole encoder. The vectorised form: no loop but that of the farthest points, over whole batches."""
import torch
from torch import nn
from torch.nn import functional as F

LEVELS = ((512, .2, 32, (64, 64, 128)), (128, .4, 64, (128, 128, 256)), (0, 0, 0, (256, 512, 1024)))


def farthest(points, n):
    """points (B, N, 3) to (B, n), from the first"""
    B, N, _ = points.shape
    each = torch.arange(B)
    index = torch.zeros(B, n, dtype=torch.long)
    distance = torch.full((B, N), float("inf"), dtype=points.dtype)
    at = torch.zeros(B, dtype=torch.long)
    for k in range(n):
        index[:, k] = at
        distance = torch.minimum(distance, ((points - points[each, at][:, None]) ** 2).sum(-1))
        at = distance.argmax(-1)
    return index


def rows(x, index):
    """x (B, N, C), index (B, ...) to (B, ..., C)"""
    return x[torch.arange(len(x)).view(-1, *[1] * (index.dim() - 1)), index]


def around(points, centres, radius, n):
    """The first n within the radius, (B, M, n)"""
    N = points.shape[1]
    square = ((centres ** 2).sum(-1)[:, :, None] + (points ** 2).sum(-1)[:, None] - 2 * centres @ points.transpose(1, 2)
              if points.dtype == torch.float32 else ((centres[:, :, None] - points[:, None]) ** 2).sum(-1))
    index = torch.where(square <= radius ** 2, torch.arange(N), N).sort(-1).values[..., :n]
    return torch.where(index == N, index[..., :1], index)


class Level(nn.Module):
    def __init__(self, features, points, radius, samples, widths, first="mlp_convs.0"):
        super().__init__()
        self.points, self.radius, self.samples, self.first = points, radius, samples, first
        sizes = (3 + features,) + widths
        convs = [nn.Conv2d(a, b, 1) for a, b in zip(sizes, widths)]
        self.mlp_convs = nn.ModuleList(convs)
        self.mlp_bns = nn.ModuleList(nn.BatchNorm2d(w) for w in widths)
        if first == "input":                                    # not a published weight's name
            self.input, self.mlp_convs = convs[0], nn.ModuleDict({"1": convs[1], "2": convs[2]})

    def convs(self):
        return [self.input, *self.mlp_convs.values()] if self.first == "input" else self.mlp_convs

    def forward(self, points, features=None):
        if self.points:
            centres = rows(points, farthest(points, self.points))
            index = around(points, centres, self.radius, min(self.samples, points.shape[1]))
            x = rows(points, index) - centres[:, :, None]
        else:
            centres, index, x = None, None, points[:, None]
        if features is not None:
            x = torch.cat((x, features[:, None] if index is None else rows(features, index)), -1)
        x = x.permute(0, 3, 1, 2)
        for conv, norm in zip(self.convs(), self.mlp_bns):
            x = F.relu(norm(conv(x)))
        return centres, x.amax(3).transpose(1, 2)


class FirstLevel(nn.Module):
    def __init__(self, features=87):
        super().__init__()
        self.sa1 = Level(features, *LEVELS[0], first="input")

    def forward(self, points, features):
        return self.sa1(points, features)[1]

    def loss(self, points, features, target):
        return F.mse_loss(self(points, features), target)


class PointNet2(nn.Module):
    def __init__(self, dropout=.4):
        super().__init__()
        self.sa1, self.sa2, self.sa3 = (Level(f, *l) for f, l in zip((0, 128, 256), LEVELS))
        self.fc1, self.bn1 = nn.Linear(1024, 512), nn.BatchNorm1d(512)
        self.fc2, self.bn2 = nn.Linear(512, 256), nn.BatchNorm1d(256)
        self.dropout = nn.Dropout(dropout)

    def forward(self, points):
        x = None
        for level in (self.sa1, self.sa2, self.sa3):
            points, x = level(points, x)
        x = self.dropout(F.relu(self.bn1(self.fc1(x[:, 0]))))
        return self.dropout(F.relu(self.bn2(self.fc2(x))))

    def loss(self, points, target):
        return F.mse_loss(self(points), target)
