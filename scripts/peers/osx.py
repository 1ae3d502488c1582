# SPDX-License-Identifier: Apache-2.0
"""OSX without decoders in PyTorch: the twin of models/body, with its parameter names.

Source: Lin et al. 2023; IDEA-Research/OSX main/OSX_WoDecoder.py, common/nets/module_wo_decoder.py.
"""
import math

import torch
import torch.nn.functional as F
from torch import nn
from torchvision.ops import roi_align

from vit import Attention

#        width layers heads box  fc
SIZES = {"tiny": (192, 12, 3, 64, 128), "s": (384, 12, 6, 128, 256), "b": (768, 12, 12, 256, 512),
         "l": (1024, 24, 16, 256, 512)}
HEIGHT, WIDTH, ROWS, COLUMNS = 256, 192, 16, 12


class Block(nn.Module):
    def __init__(self, width, heads):
        super().__init__()
        self.norm1, self.norm2 = nn.LayerNorm(width, 1e-6), nn.LayerNorm(width, 1e-6)
        self.attn = Attention(width, heads)
        self.mlp = nn.ModuleDict({"fc1": nn.Linear(width, 4 * width), "fc2": nn.Linear(4 * width, width)})

    def forward(self, x):
        x = x + self.attn(self.norm1(x))
        return x + self.mlp["fc2"](F.gelu(self.mlp["fc1"](self.norm2(x))))


class Encoder(nn.Module):
    def __init__(self, width, layers, heads):
        super().__init__()
        self.patch_embed = nn.ModuleDict({"proj": nn.Conv2d(3, width, 16, 16, 2)})
        self.pos_embed = nn.Parameter(0.02 * torch.randn(1 + ROWS * COLUMNS, width))
        self.task_tokens = nn.Parameter(0.02 * torch.randn(31, width))
        self.blocks = nn.Sequential(*[Block(width, heads) for _ in range(layers)])
        self.last_norm = nn.LayerNorm(width, 1e-6)

    def forward(self, image):
        x = self.patch_embed["proj"](image).flatten(2).transpose(1, 2) + self.pos_embed[1:] + self.pos_embed[:1]
        x = self.last_norm(self.blocks(torch.cat([self.task_tokens.expand(len(x), -1, -1), x], 1)))
        return x[:, 31:].transpose(1, 2).reshape(len(x), -1, ROWS, COLUMNS), x[:, :31]


class Position(nn.Module):
    def __init__(self, width, joints, depth):
        super().__init__()
        self.conv = nn.Sequential(nn.Conv2d(width, joints * depth, 1))
        self.joints, self.depth = joints, depth

    def forward(self, x):
        B, _, H, W = x.shape
        heat = self.conv(x).reshape(B, self.joints, -1).softmax(2).view(B, self.joints, self.depth, H, W)
        n = [torch.arange(k).to(heat) for k in (self.depth, H, W)]
        place = torch.stack([(heat.sum((2, 3)) * n[2]).sum(2), (heat.sum((2, 4)) * n[1]).sum(2),
                             (heat.sum((3, 4)) * n[0]).sum(2)], 2)
        return heat, place


def rotations(six):
    """The reference's order: both columns' numbers in turns"""
    x = six.reshape(len(six), -1, 3, 2)
    a = F.normalize(x[..., 0], dim=-1)
    b = F.normalize(x[..., 1] - (a * x[..., 1]).sum(-1, keepdim=True) * a, dim=-1)
    return torch.stack([a, b, torch.cross(a, b, dim=-1)], -1)


class Body(nn.Module):
    def __init__(self, width, fc):
        super().__init__()
        for name, i, o in (("body_conv", width, fc), ("root_pose_out", 25 * (fc + 3), 6),
                           ("body_pose_out", 25 * (fc + 3), 126), ("shape_out", width, 10), ("cam_out", width, 3)):
            self.add_module(name, nn.Sequential(nn.Linear(i, o)))

    def forward(self, tokens, place):
        x = torch.cat([self.body_conv(tokens[:, 6:]), place.detach()], 2).flatten(1)
        camera = self.cam_out(tokens[:, 1])
        z = camera[:, 2:].sigmoid() * math.sqrt(5000 ** 2 * 2.5 ** 2 / (HEIGHT * WIDTH))
        six = torch.cat([self.root_pose_out(x), self.body_pose_out(x)], 1)
        return rotations(six), self.shape_out(tokens[:, 0]), torch.cat([camera[:, :2], z], 1)


def ups(*channels):
    layers = []
    for i, o in zip(channels, channels[1:]):
        layers += [nn.ConvTranspose2d(i, o, 4, 2, 1, bias=False), nn.BatchNorm2d(o), nn.ReLU()]
    return nn.Sequential(*layers)


def sampled(x, place):
    """What a map has at (B, N, 2) columns and rows; a cell's centre is a whole number"""
    size = torch.tensor([x.shape[3] - 1, x.shape[2] - 1]).to(x)
    return F.grid_sample(x, (place / size * 2 - 1)[:, :, None], align_corners=True)[..., 0].transpose(1, 2)


class Boxes(nn.Module):
    def __init__(self, width, box):
        super().__init__()
        self.deconv = ups(width + 400, box, box, box)
        self.bbox_center = nn.Sequential(nn.Conv2d(box, 3, 1))
        self.parts = "lhand", "rhand", "face"
        for part in self.parts:
            self.add_module(part + "_size", nn.Sequential(nn.Linear(box, box), nn.ReLU(), nn.Linear(box, 2)))

    def forward(self, x, heat):
        x = self.deconv(torch.cat([x, heat.detach().flatten(1, 2)], 1))
        B, _, H, W = x.shape
        heat = self.bbox_center(x).flatten(2).softmax(2).view(B, 3, H, W)
        centre = torch.stack([(heat.sum(2) * torch.arange(W).to(x)).sum(2),
                              (heat.sum(3) * torch.arange(H).to(x)).sum(2)], 2)
        at = sampled(x, centre.detach())
        size = torch.stack([getattr(self, p + "_size")(at[:, i]) for i, p in enumerate(self.parts)], 1)
        return centre / 8, size


def pixels(centre, size, times):
    half = times * size.max(1, keepdim=True)[0].expand(-1, 2) / 2
    number = torch.arange(len(centre)).to(centre)[:, None]
    return torch.cat([number, 16 * (centre - half), 16 * (centre + half)], 1).detach()


class HandMap(nn.Module):
    def __init__(self, width):
        super().__init__()
        self.deconv = ups(width, width // 2, width // 4)
        self.conv = nn.Sequential(nn.Conv2d(width // 4, width, 1))

    def forward(self, x, left, right):
        x = self.deconv(x)
        left, right = (roi_align(x, box, 16, 0.25) for box in (left, right))
        return self.conv(torch.cat([left.flip(3), right]))


class HandPose(nn.Module):
    def __init__(self, width, fc):
        super().__init__()
        self.hand_conv = nn.Sequential(nn.Conv2d(width, fc, 1), nn.BatchNorm2d(fc), nn.ReLU())
        self.hand_pose_out = nn.Sequential(nn.Linear(20 * (fc + 3), 90))

    def forward(self, x, place):
        place = place.detach()
        x = torch.cat([sampled(self.hand_conv(x), place[..., :2]), place], 2)
        return rotations(self.hand_pose_out(x.flatten(1)))


class Face(nn.Module):
    def __init__(self, width):
        super().__init__()
        self.expr_out, self.jaw_pose_out = nn.Sequential(nn.Linear(width, 10)), nn.Sequential(nn.Linear(width, 6))


class Osx(nn.Module):
    """image (B, 3, 256, 192) -> rotation, shape, expression, camera, body_place, hand_place, box_centre, box_size"""

    def __init__(self, variant="tiny"):
        super().__init__()
        width, layers, heads, box, fc = SIZES[variant]
        self.encoder = Encoder(width, layers, heads)
        self.body_position_net = Position(width, 25, 16)
        self.body_regressor = Body(width, fc)
        self.box_net = Boxes(width, box)
        self.hand_roi_net = HandMap(width)
        self.hand_position_net = Position(width, 20, 16)
        self.hand_regressor = HandPose(width, fc)
        self.face_regressor = Face(width)

    def forward(self, image):
        B = len(image)
        x, tokens = self.encoder(image)
        heat, place = self.body_position_net(x)
        rotation, shape, camera = self.body_regressor(tokens, place)
        centre, size = self.box_net(x, heat)
        hands = self.hand_roi_net(x, *(pixels(centre[:, i], size[:, i], 2) for i in range(2)))
        hand_place = self.hand_position_net(hands)[1]
        hand = self.hand_regressor(hands, hand_place)
        mirror = torch.diag(torch.tensor([-1.0, 1, 1])).to(hand)
        left = hand_place[:B] * torch.tensor([-1, 1, 1]).to(hand) + torch.tensor([15, 0, 0]).to(hand)
        jaw = rotations(self.face_regressor.jaw_pose_out(tokens[:, 3]))
        rotation = torch.cat([rotation, mirror @ hand[:B] @ mirror, hand[B:], jaw], 1)
        return (rotation, shape, self.face_regressor.expr_out(tokens[:, 2]), camera, place,
                torch.cat([left, hand_place[B:]], 1), centre, size)

    def loss(self, image, rotation, shape, expression, body_place, hand_place, box_centre, box_size, body_known, hand_known,
             box_known, weight):
        """Hands are compared in columns and rows of the picture; the camera has no truth of its own"""
        out = self(image)
        hand = []
        for i in range(2):
            box = pixels(out[6][:, i], out[7][:, i], 2)
            uv = box[:, None, 1:3] / 16 + out[5][:, 20 * i:20 * i + 20, :2] * (box[:, 3] - box[:, 1])[:, None, None] / 256
            hand.append(torch.cat([uv, out[5][:, 20 * i:20 * i + 20, 2:]], 2))
        pairs = [(out[0], rotation, None), (out[1], shape, None), (out[2], expression, None),
                 (out[4], body_place, body_known), (torch.cat(hand, 1), hand_place, hand_known),
                 (out[6], box_centre, box_known), (out[7], box_size, None)]

        def term(a, b, known):
            d = (a - b).abs() if known is None else (a * known[..., None] - b * known[..., None]).abs()
            return (d.flatten(1).mean(1) * weight).sum() / weight.sum()
        return sum(term(*p) for p in pairs)
