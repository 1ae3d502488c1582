#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Reference values of the models, by the PyTorch twins of scripts/peers in float64, for tests/models.

    scripts/vectors/models.py [NAME...]        writes tests/vectors/models/NAME.npz

Parameters and inputs are hashed from their names, so that the C tests make the same ones and the files
hold results alone: names and sizes of the parameters, outputs of inference, and of a training step the
loss and the length of each parameter's gradient.
"""
import contextlib
import io
import os
import sys

import numpy as np
import torch

HERE = os.path.dirname(os.path.abspath(__file__))
OUT = os.path.join(HERE, "../../tests/vectors/models")
sys.path[:0] = [HERE, os.path.join(HERE, "../peers")]

from action import Action                   # noqa: E402
from csp_seg import CspSeg                  # noqa: E402
from efficientnet import EfficientNetB0     # noqa: E402
from hocat import Hocat                     # noqa: E402
from lpips import Lpips                     # noqa: E402
from osx import Osx                         # noqa: E402
from pointnet2 import FirstLevel, PointNet2     # noqa: E402
from reid import Reid                       # noqa: E402
from resnet import ResNet50                 # noqa: E402
from unified import Unified                 # noqa: E402
from vit import Vit                         # noqa: E402
with contextlib.redirect_stdout(io.StringIO()):     # it prints its own vectors
    from geometry import hand as hashed_hand, hashed    # noqa: E402
import ops                                  # noqa: E402


def named(name, *shape):
    """Numbers in [-1, 1) that depend on the name, by its FNV-1a hash"""
    seed = 2166136261
    for byte in name.encode():
        seed = (seed ^ byte) * 16777619 % 2 ** 32
    return hashed(seed, *shape)


def value(name, shape):
    """A parameter's: weights keep the variance, the rest is near what it is at first; in float32"""
    h = named(name, *shape)
    if len(shape) > 1:
        h = h * np.sqrt(3 / np.prod(shape[1:]))
    elif name.endswith((".weight", "running_var", "temperature")):
        h = 1 + h / 2
    else:
        h = h / 8
    return h.astype(np.float32).astype(np.float64)


def filled(model):
    model = model.double()
    state = {k: torch.tensor(value(k, tuple(v.shape))) for k, v in model.state_dict().items()
             if not k.endswith("num_batches_tracked")}
    model.load_state_dict(state, strict=False)
    return model


def unit(name, *shape):
    return torch.tensor(named(name, *shape) / 2 + 0.5)


def save(name, model, outputs, inputs, targets):
    model = filled(model)
    with torch.no_grad():
        out = model.eval()(*inputs)
    loss = model.train().loss(*inputs, *(unit(k, *shape) for k, shape in targets.items()))
    loss.backward()
    arrays = {k: o.numpy().astype(np.float32) for k, o in zip(outputs, out if isinstance(out, tuple) else (out,))}
    arrays["loss"] = loss.detach().numpy()
    arrays["names"] = np.array([k for k, _ in model.named_parameters()])
    arrays["sizes"] = np.array([p.numel() for p in model.parameters()])
    arrays["gradients"] = np.array([0 if p.grad is None else p.grad.norm() for p in model.parameters()])
    np.savez_compressed(os.path.join(OUT, name + ".npz"), **arrays)
    print(name, len(arrays["names"]), arrays["sizes"].sum())


def resnet50():
    save("resnet50", ResNet50(8, (1, 2, 1, 1), 10), ["logits"], [unit("image", 4, 3, 64, 64)], {"target": (4, 10)})


def efficientnet_b0():
    save("efficientnet_b0", EfficientNetB0(10, 0, 0), ["logits"], [unit("image", 4, 3, 64, 64)],
         {"target": (4, 10)})


def hocat():
    """At most one map cell a bin: boxes of at most 32 pixels."""
    hand_box = torch.tensor([[10, 8, 41, 36], [30, 29, 60, 61]], dtype=torch.float64)
    object_box = torch.tensor([[4, 4, 33, 30], [22, 31, 52, 62]], dtype=torch.float64)
    hand = {k: torch.tensor(v) for k, v in hashed_hand().items()}
    save("hocat", Hocat(8, (1, 1, 1, 1), 8, 1, 2, 1, hand=hand),
         ["joints2d", "rotation", "beta", "vertices", "joints", "conf", "point_x", "point_y"],
         [unit("image", 2, 3, 64, 64), hand_box, object_box],
         {"joints2d": (2, 21, 2), "rotation": (2, 16, 3, 3), "beta": (2, 10), "points2d": (2, 21, 2),
          "mask": (2, 8, 8), "weight": (2,)})


def unified():
    """12 x 12 cells: 3 x 3 go to 2 x 2 and back, as 7 x 7 do to 4 x 4."""
    hand = {k: torch.tensor(v) for k, v in hashed_hand().items()}
    save("unified", Unified(96, 8, 1, 2, 2, 0, 0, hand),
         ["joints2d", "rotation", "beta", "vertices", "joints", "conf", "point_x", "point_y"],
         [unit("image", 4, 3, 96, 96), unit("depth", 4, 1, 96, 96)],
         {"joints2d": (4, 21, 2), "rotation": (4, 16, 3, 3), "beta": (4, 10), "points2d": (4, 21, 2),
          "mask": (4, 12, 12), "weight": (4,)})


def pointnet2_sa1():
    save("pointnet2_sa1", FirstLevel(5), ["embedding"], [unit("points", 1, 600, 3), unit("features", 1, 600, 5)],
         {"target": (1, 512, 128)})


def pointnet2_ulip():
    save("pointnet2_ulip", PointNet2(0), ["embedding"], [unit("points", 3, 520, 3)], {"target": (3, 256)})


def vit():
    save("vit", Vit("tiny"), ["feature", "patches"], [unit("image", 2, 3, 112, 112)], {"target": (2, 192)})


def csp_seg():
    """Two images with the objects of scripts/vectors/ops.py, by its tables"""
    model = CspSeg(5)
    boxes = torch.tensor(ops.OBJECTS, dtype=torch.float64)

    def loss(image):
        out = model(image)
        assigned = torch.tensor(ops.assign_cells(out, ops.OBJECTS))
        box, sides = ops.box_losses(out[:3], boxes, assigned)
        return (7.5 * box + 0.5 * ops.class_loss(out[3:6], boxes, assigned) + 1.5 * sides
                + 7.5 * ops.mask_loss(out[6:9], out[9], boxes, assigned))

    model.loss = loss
    save("csp_seg", model, ["box8", "box16", "box32", "class8", "class16", "class32", "mask8", "mask16", "mask32",
                            "prototypes"], [unit("image", 2, 3, 64, 64)], {})


def reid(name="reid", tf=False):
    save(name, Reid(7, 0, tf), ["embedding"], [unit("image", 4, 3, 128, 64)], {"identity": (4, 7), "weight": (4,)})


def reid_tf():
    reid("reid_tf", True)


def action():
    save("action", Action("small", 14, 0), ["logits"],
         [unit("body", 3, 3, 14, 65), unit("hand_object", 3, 3, 14, 30), unit("valid", 3, 14), unit("on", 3)],
         {"class": (3, 10), "weight": (3,)})


def osx():
    save("osx", Osx("tiny"), ["rotation", "shape", "expression", "camera", "body_place", "hand_place", "box_centre",
                              "box_size"], [unit("image", 2, 3, 256, 192)],
         {"rotation": (2, 53, 3, 3), "shape": (2, 10), "expression": (2, 10), "body_place": (2, 25, 3),
          "hand_place": (2, 40, 3), "box_centre": (2, 3, 2), "box_size": (2, 3, 2), "body_known": (2, 25),
          "hand_known": (2, 40), "box_known": (2, 3), "weight": (2,)})


def lpips():
    """Distances of whole images, and of what is in boxes, as if they were cut there; that of the boxes with its
    gradient."""
    model = filled(Lpips())
    image, truth = unit("image", 2, 3, 45, 61).requires_grad_(), unit("truth", 2, 3, 45, 61)
    boxes = (3, 5, 40, 44), (0, 0, 61, 45)
    boxed = [model(*(v[i:i + 1, :, y0:y1, x0:x1] for v in (image, truth))) for i, (x0, y0, x1, y1) in enumerate(boxes)]
    boxed = torch.cat(boxed)
    (boxed * torch.tensor([1, -0.5])).sum().backward()
    arrays = {"distance": model(image, truth), "raw01": model(image, truth, False), "boxed": boxed,
              "gradient": image.grad}
    arrays = {k: v.detach().numpy().astype(np.float32) for k, v in arrays.items()}
    arrays["names"] = np.array([k for k, _ in model.named_parameters()])
    np.savez_compressed(os.path.join(OUT, "lpips.npz"), **arrays)
    print("lpips", arrays["distance"], arrays["raw01"], arrays["boxed"])


MODELS = {"resnet50": resnet50, "efficientnet_b0": efficientnet_b0, "hocat": hocat, "unified": unified, "vit": vit,
          "csp_seg": csp_seg, "reid": reid, "reid_tf": reid_tf, "action": action, "osx": osx,
          "lpips": lpips, "pointnet2_sa1": pointnet2_sa1, "pointnet2_ulip": pointnet2_ulip}

if __name__ == "__main__":
    for name in sys.argv[1:] or MODELS:
        MODELS[name]()
