# SPDX-License-Identifier: Apache-2.0
"""HOCAT in PyTorch: the twin of models/hocat, full variant, with its parameter names.

RoIAlign is written with grid_sample, one sample a bin, which is RoIAlign's own adaptive choice for boxes
of at most one map cell a bin; the ONNX export gets a RoiAlign node instead. The hand layer has MANO's
array shapes and random contents.
"""
import math

import torch
import torch.nn.functional as F
from torch import nn

from resnet import Trunk

TIPS = [728, 353, 442, 576, 694]
SIMPLE = [0, 13, 14, 15, 16, 1, 2, 3, 17, 4, 5, 6, 18, 10, 11, 12, 19, 7, 8, 9, 20]
POINTS = 21


# ---- RoIAlign ---------------------------------------------------------------------------------------------

class OnnxRoiAlign(torch.autograd.Function):
    @staticmethod
    def symbolic(g, x, boxes, index, out, scale):
        return g.op("RoiAlign", x, boxes, index, coordinate_transformation_mode_s="output_half_pixel",
                    mode_s="avg", output_height_i=out, output_width_i=out, sampling_ratio_i=0,
                    spatial_scale_f=scale)

    @staticmethod
    def forward(ctx, x, boxes, index, out, scale):
        return sampled(x, boxes, out, scale)


def sampled(x, boxes, out, scale):
    """boxes (B, 4) x0 y0 x1 y1 in pixels; one box an image"""
    size = torch.tensor([x.shape[3] - 1, x.shape[2] - 1], dtype=x.dtype)
    low, high = boxes[:, :2] * scale, boxes[:, 2:] * scale
    bins = (torch.arange(out, dtype=x.dtype) + 0.5) / out
    at = low[:, None] + bins[:, None] * torch.clamp(high - low, min=1)[:, None]         # (B, out, 2)
    at = 2 * at / size - 1
    col = at[:, None, :, 0].expand(-1, out, -1)
    row = at[:, :, None, 1].expand(-1, -1, out)
    return F.grid_sample(x, torch.stack([col, row], 3), "bilinear", "border", align_corners=True)


def roi_align(x, boxes, out, scale):
    if torch.onnx.is_in_onnx_export():
        return OnnxRoiAlign.apply(x, boxes, torch.arange(x.shape[0]), out, scale)
    return sampled(x, boxes, out, scale)


# ---- feature pyramids -------------------------------------------------------------------------------------

class Gate(nn.Module):
    def __init__(self, channels):
        super().__init__()
        self.fc1 = nn.Linear(channels, channels // 16, bias=False)
        self.fc2 = nn.Linear(channels // 16, channels, bias=False)

    def forward(self, x):
        return x * torch.sigmoid(self.fc2(F.relu(self.fc1(x.mean((2, 3))))))[:, :, None, None]


class Pyramid(nn.Module):
    def __init__(self, channels, out):
        super().__init__()
        self.top = nn.Conv2d(channels[3], out, 1)
        for i in (2, 1, 0):
            setattr(self, "lateral%d" % (i + 2), nn.Conv2d(channels[i], out, 1))
            setattr(self, "se%d" % (i + 2), Gate(channels[i]))
        self.smooth = nn.Conv2d(out, out, 3, 1, 1)
        self.se_out = Gate(out)

    def forward(self, c):
        p = self.top(c[3])
        for i in (2, 1, 0):
            lateral = getattr(self, "lateral%d" % (i + 2))(getattr(self, "se%d" % (i + 2))(c[i]))
            p = lateral + F.interpolate(p, lateral.shape[2:], mode="bilinear", align_corners=False)
        return self.se_out(self.smooth(p))


# ---- cross-attention --------------------------------------------------------------------------------------

def project(x, conv):
    return F.linear(x, conv.weight.flatten(1), conv.bias)


class AttentionBlock(nn.Module):
    def __init__(self, channels, heads, ratio):
        super().__init__()
        self.heads = heads
        self.q, self.k, self.v = (nn.Conv2d(channels, channels, 1) for _ in range(3))
        self.norm = nn.LayerNorm(channels)
        self.mlp = nn.Module()
        self.mlp.fc1 = nn.Linear(channels, ratio * channels)
        self.mlp.fc2 = nn.Linear(ratio * channels, channels)

    def split(self, x):
        B, T, C = x.shape
        return x.view(B, T, self.heads, C // self.heads).transpose(1, 2)

    def forward(self, x, minor):
        q, k, v = (self.split(t) for t in (project(x, self.q), project(minor, self.k), project(minor, self.v)))
        scores = torch.softmax(q @ k.transpose(2, 3) * (1 / math.sqrt(q.shape[3])), 3)
        y = (scores @ v).transpose(1, 2).reshape(x.shape) + x
        return self.mlp.fc2(F.gelu(self.mlp.fc1(self.norm(y)))) + y


class CrossAttention(nn.ModuleList):
    def forward(self, hand, minor):
        x, m = (t.flatten(2).transpose(1, 2).contiguous() for t in (hand, minor))
        for block in self:
            x = block(x, m)
        return x.transpose(1, 2).reshape(hand.shape)


# ---- the hand's heat maps and encoder ---------------------------------------------------------------------

class Bottleneck(nn.Module):
    """Pre-activation: x + conv(act(bn(...)))"""

    def __init__(self, channels):
        super().__init__()
        half = channels // 2
        self.bn1, self.conv1 = nn.BatchNorm2d(channels), nn.Conv2d(channels, half, 1)
        self.bn2, self.conv2 = nn.BatchNorm2d(half), nn.Conv2d(half, half, 3, 1, 1)
        self.bn3, self.conv3 = nn.BatchNorm2d(half), nn.Conv2d(half, channels, 1)

    def forward(self, x):
        y = self.conv1(F.leaky_relu_(self.bn1(x), 0.01))
        y = self.conv2(F.leaky_relu_(self.bn2(y), 0.01))
        return self.conv3(F.leaky_relu_(self.bn3(y), 0.01)) + x


class Hourglass(nn.Module):
    def __init__(self, channels, depth):
        super().__init__()
        for name in ("up", "low1", "low3"):
            setattr(self, name, nn.ModuleList(Bottleneck(channels) for _ in range(depth)))
        self.bottom = Bottleneck(channels)

    def forward(self, x, i=0):
        low = self.low1[i](F.max_pool2d(x, 2))
        low = self.forward(low, i + 1) if i + 1 < len(self.up) else self.bottom(low)
        return self.up[i](x) + F.interpolate(self.low3[i](low), scale_factor=2.0, mode="nearest")


class HeatmapHead(nn.Module):
    def __init__(self, channels, levels):
        super().__init__()
        self.hg = Hourglass(channels, levels)
        self.res = Bottleneck(channels)
        self.fc = nn.Sequential(nn.Conv2d(channels, channels, 1), nn.BatchNorm2d(channels), nn.LeakyReLU(0.01, True))
        self.score = nn.Conv2d(channels, POINTS, 1)
        self.temperature = nn.Parameter(torch.ones(POINTS))

    def forward(self, x):
        """encoding, heat maps, places (B, 21, 2) in [0, 1]"""
        encoding = self.fc(self.res(self.hg(x)))
        logits = self.score(encoding)
        R = logits.shape[3]
        heat = torch.softmax(logits.flatten(2) * self.temperature[:, None], 2).view(logits.shape)
        centre = (torch.arange(R, dtype=x.dtype) + 0.5) / R
        return encoding, heat, torch.stack([(heat.sum(2) * centre).sum(2), (heat.sum(3) * centre).sum(2)], 2)


class Encoder(nn.Module):
    def __init__(self, channels, levels):
        super().__init__()
        self.heatmap_conv = nn.Conv2d(POINTS, channels, 1)
        self.encoding_conv = nn.Conv2d(channels, channels, 1)
        self.reg = nn.ModuleList(nn.Sequential(Bottleneck(channels), Bottleneck(channels)) for _ in range(levels))

    def forward(self, heat, encoding):
        x = self.heatmap_conv(heat) + self.encoding_conv(encoding)
        for level in self.reg:
            x = F.max_pool2d(level(x), 2)
        return x.flatten(1)


# ---- hand parameters and hand layer -----------------------------------------------------------------------

def rot6d(x):
    a, b = x[..., :3], x[..., 3:]
    a = F.normalize(a, dim=-1)
    b = F.normalize(b - (a * b).sum(-1, keepdim=True) * a, dim=-1)
    return torch.stack([a, b, torch.cross(a, b, dim=-1)], -1)


def random_hand():
    r = torch.Generator().manual_seed(1)
    return {"template": 0.01 * torch.randn(778, 3, generator=r),
            "shapedirs": 0.01 * torch.randn(778, 3, 10, generator=r),
            "posedirs": 0.01 * torch.randn(778, 3, 135, generator=r),
            "regressor": torch.randn(16, 778, generator=r).softmax(1),
            "weights": torch.randn(778, 16, generator=r).softmax(1)}


class Hand(nn.Module):
    """rotations (B, 16, 3, 3), betas (B, 10) -> vertices (B, 778, 3), key points (B, 21, 3)"""

    def __init__(self, hand=None):
        super().__init__()
        h = hand or random_hand()
        constants = {
            "template": h["template"].flatten(), "weights": h["weights"],
            "shapedirs": h["shapedirs"].flatten(0, 1).T.contiguous(),                   # (10, 778 * 3)
            "posedirs": h["posedirs"].flatten(0, 1).T.contiguous(),                     # (135, 778 * 3)
            "rest": h["regressor"] @ h["template"],                                     # joints without shape
            "rest_dirs": torch.einsum("jv,vck->kjc", h["regressor"], h["shapedirs"]).flatten(1),
        }
        for name, value in constants.items():
            self.register_buffer(name, value, persistent=False)

    def forward(self, R, beta):
        B = R.shape[0]
        joints = self.rest + (beta @ self.rest_dirs).view(B, 16, 3)
        v = self.template + beta @ self.shapedirs + (R[:, 1:] - torch.eye(3, dtype=R.dtype)).flatten(1) @ self.posedirs
        A, t = R[:, :1].expand(-1, 5, -1, -1), joints[:, :1].expand(-1, 5, -1)          # five fingers at once
        As, ts, above = [R[:, :1]], [joints[:, :1]], joints[:, :1]
        for level in range(3):
            now = joints[:, 1 + level::3]
            t = (A @ (now - above)[..., None])[..., 0] + t
            A = A @ R[:, 1 + level::3]
            As.append(A)
            ts.append(t)
            above = now
        order = [0] + [1 + 5 * level + finger for finger in range(5) for level in range(3)]
        A, t = torch.cat(As, 1)[:, order], torch.cat(ts, 1)[:, order]
        move = t - (A @ joints[..., None])[..., 0]
        v = v.view(B, 778, 3)
        blend = (self.weights @ torch.cat([A, move[..., None]], 3).view(B, 16, 12)).view(B, 778, 3, 4)
        v = (blend[..., :3] @ v[..., None])[..., 0] + blend[..., 3]
        key = torch.cat([t, v[:, TIPS]], 1)[:, SIMPLE]
        return v - t[:, :1], key - t[:, :1]


class Mano(nn.Module):
    def __init__(self, features, hidden1, hidden2):
        super().__init__()
        self.fc1, self.fc2 = nn.Linear(features, hidden1), nn.Linear(hidden1, hidden2)
        self.pose, self.shape = nn.Linear(hidden2, 96), nn.Linear(hidden2, 10)

    def forward(self, x):
        x = F.leaky_relu(self.fc2(F.leaky_relu(self.fc1(x), 0.01)), 0.01)
        return rot6d(self.pose(x).view(-1, 16, 6)), self.shape(x)


# ---- the object's control points --------------------------------------------------------------------------

class ObjectLayer(nn.Module):
    def __init__(self, channels):
        super().__init__()
        half = channels // 2
        self.conv1, self.bn1 = nn.Conv2d(channels, half, 1), nn.BatchNorm2d(half)
        self.conv2, self.bn2 = nn.Conv2d(half, channels, 3, 1, 1), nn.BatchNorm2d(channels)

    def forward(self, x):
        x = F.leaky_relu_(self.bn1(self.conv1(x)), 0.1)
        return F.leaky_relu_(self.bn2(self.conv2(x)), 0.1)


class ObjectHead(nn.Module):
    def __init__(self, channels, layers):
        super().__init__()
        self.layers = layers
        for i in range(layers):
            self.add_module(str(i), ObjectLayer(channels))
        self.head = nn.Conv2d(channels, 3 * POINTS, 1)

    def forward(self, x):
        """confidence, x, y, each (B, 21, R, R)"""
        for i in range(self.layers):
            x = getattr(self, str(i))(x)
        conf, px, py = self.head(x).chunk(3, 1)
        centre = (torch.arange(x.shape[3], dtype=x.dtype) + 0.5) / x.shape[3]
        return torch.sigmoid(conf), 0.1 * px + centre, 0.1 * py + centre[:, None]


# ---- the whole --------------------------------------------------------------------------------------------

def mse(a, b, w):
    return ((a - b).square().flatten(1).mean(1) * w).sum() / w.sum()


def l1(a, b, w):
    return ((a - b).abs().flatten(1).mean(1) * w).sum() / w.sum()


def hand_object_loss(hand, out, joints2d, rotation, beta, points2d, mask, weight):
    conf, px, py = out[5:]
    vertices, joints = hand(rotation, beta)
    gx, gy, m = points2d[:, :, :1, None], points2d[:, :, 1:, None], mask[:, None]
    target = (torch.exp(-torch.sqrt((px - gx) ** 2 + (py - gy) ** 2)) * m).detach()
    return (100 * mse(out[0], joints2d, weight) + 1e4 * mse(out[4], joints, weight)
            + 1e4 * mse(out[3], vertices, weight) + 10 * mse(out[1], rotation, weight)
            + 0.1 * mse(out[2], beta, weight)
            + 500 * (l1(px * m, gx * m, weight) + l1(py * m, gy * m, weight))
            + 100 * l1(conf, target, weight))


class Hocat(nn.Module):
    """image (B, 3, S, S), hand_box, object_box (B, 4) -> joints2d, rotation, beta, vertices, joints, conf, x, y"""

    def __init__(self, width=64, blocks=(3, 4, 6, 3), roi=32, depth=4, heads=4, ratio=4, object_layers=3,
                 hand=None):
        super().__init__()
        C, levels = 4 * width, int(math.log2(roi)) - 1
        self.roi = roi
        self.trunk = Trunk(width, blocks, 0.01)
        self.hand_fpn, self.object_fpn = (Pyramid(self.trunk.channels, C) for _ in range(2))
        self.hocat = CrossAttention(AttentionBlock(C, heads, ratio) for _ in range(depth))
        self.hand_head = HeatmapHead(C, levels)
        self.hand_encoder = Encoder(C, levels)
        self.mano = Mano(4 * C, 4 * C, 2 * C)
        self.object_head = ObjectHead(C, object_layers)
        self.hand = Hand(hand)

    def forward(self, image, hand_box, object_box):
        c = self.trunk.maps(image)
        hand, obj = self.hand_fpn(c), self.object_fpn(c)
        hand_main = roi_align(hand, hand_box, self.roi, 0.25)
        object_main = roi_align(obj, object_box, self.roi, 0.25)
        minor = roi_align(obj, hand_box, self.roi, 0.25).detach()
        encoding, heat, joints2d = self.hand_head(self.hocat(hand_main, minor))
        rotation, beta = self.mano(self.hand_encoder(heat, encoding))
        vertices, joints = self.hand(rotation, beta)
        return (joints2d, rotation, beta, vertices, joints) + self.object_head(object_main)

    def loss(self, image, hand_box, object_box, *truth):
        return hand_object_loss(self.hand, self(image, hand_box, object_box), *truth)
