#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Measure one network or layer in PyTorch, in a process of its own; for scripts/bench-peers.

    run_torch.py MODEL infer BATCH eager|channels_last|jit RUNS SECONDS
    run_torch.py MODEL train BATCH eager|channels_last RUNS SECONDS
    run_torch.py MODEL export BATCH FOLDER

prints one line of JSON. RUNS timed runs or SECONDS, whichever ends first, but one at least; export writes
model.onnx, and inputs and outputs as raw float32. MODEL may be a layer, as "attention:tokens=1024".
"""
import json
import os
import resource
import sys
import time
import warnings

warnings.filterwarnings("ignore")

import torch                                # noqa: E402

from action import Action                   # noqa: E402
from csp_seg import CspSeg                  # noqa: E402
from efficientnet import EfficientNetB0     # noqa: E402
from gpm import Gpm                         # noqa: E402
from hocat import Hocat                     # noqa: E402
from layers import layer                    # noqa: E402
from lpips import Lpips                     # noqa: E402
from pointnet2 import FirstLevel            # noqa: E402
from reid import Reid                       # noqa: E402
from resnet import ResNet50                 # noqa: E402
from unified import Unified                 # noqa: E402
from vit import Vit                         # noqa: E402


def osx():
    from osx import Osx                     # alone in its wish for torchvision
    return Osx()


WARM_UP = 3
SIZE = {"resnet50": 256, "efficientnet_b0": 224, "hocat": 256, "unified": 224, "vit:b32": 224, "vit:s16": 224,
        "lpips": 150, "csp_seg": 640, "reid": 128, "osx": 256}
MODEL = {"resnet50": ResNet50, "efficientnet_b0": EfficientNetB0, "hocat": Hocat, "unified": Unified,
         "vit:b32": lambda: Vit("b32"), "vit:s16": lambda: Vit("s16"), "lpips": Lpips, "pointnet2": FirstLevel,
         "gpm:encoder": Gpm, "csp_seg": CspSeg, "reid": Reid, "osx": osx, "action": Action,
         "action:full": lambda: Action("full")}
CELLS = {"hocat": 32, "unified": 28}


def inputs(name, batch):
    """By name. The boxes are those of palmar bench: half the crop wide and high."""
    if name == "pointnet2":
        return {"points": torch.rand(batch, 2048, 3), "features": torch.rand(batch, 2048, 87)}
    if name == "gpm:encoder":
        return {"tokens": torch.rand(batch, 512, 435)}
    if name.startswith("action"):
        return {"body": torch.rand(batch, 3, 30, 65), "hand_object": torch.rand(batch, 3, 30, 30),
                "valid": torch.rand(batch, 30), "on": torch.rand(batch)}
    S = SIZE[name]
    width = {"reid": S // 2, "osx": S * 3 // 4}.get(name, S)
    image = torch.rand(batch, 3, S, width)
    if name == "unified":
        return {"image": image, "depth": torch.rand(batch, 1, S, S)}
    if name == "lpips":
        return {"image": image, "truth": torch.rand(batch, 3, S, S)}
    if name != "hocat":
        return {"image": image}
    box = torch.tensor([[0.2 * S, 0.25 * S, 0.7 * S, 0.75 * S]]).repeat(batch, 1)
    return {"image": image, "hand_box": box, "object_box": box.clone()}


def targets(name, batch):
    if name == "pointnet2":
        return [torch.rand(batch, 512, 128)]
    if name == "lpips":
        return []
    if name.startswith("action"):
        return [torch.rand(batch, 10), torch.rand(batch)]
    if name.startswith("vit"):
        return [torch.rand(batch, {"vit:b32": 768, "vit:s16": 384}[name])]
    if name not in CELLS:
        return [torch.rand(batch, 1000)]
    shapes = (21, 2), (16, 3, 3), (10,), (21, 2), (CELLS[name], CELLS[name]), ()
    return [torch.rand(batch, *s) for s in shapes]


def built(name, x):
    """Weights at random, and running statistics near those of inputs, so that no signal dies on its way; 0.1 of the
    variance's first value, 1, stays, or rounding errors would grow where a map of few cells hardly varies. A norm of
    rows has no statistics of one."""
    model = MODEL[name]()
    norms = [m for m in model.modules() if isinstance(m, (torch.nn.BatchNorm1d, torch.nn.BatchNorm2d))]
    for m in norms:
        m.momentum = 0.9
    with torch.no_grad():
        model.train()(*(inputs(name, 2).values() if name == "reid" else x))
    for m in norms:
        m.momentum = 0.1
    return model.eval()


def for_inference(name, batch):
    """The model and its inputs by name"""
    if name not in MODEL:
        return layer(name, batch)
    x = inputs(name, batch)
    return built(name, x.values()), x


def prepared(model, x, layout):
    if layout == "channels_last":
        model = model.to(memory_format=torch.channels_last)
        x[0] = x[0].to(memory_format=torch.channels_last)
    if layout == "jit":
        model = torch.jit.optimize_for_inference(torch.jit.freeze(torch.jit.trace(model.eval(), x)))
    return model


def inference(name, batch, layout):
    model, x = for_inference(name, batch)
    x, copies = list(x.values()), getattr(model, "copies", 1)
    model = prepared(model, x, layout)
    return lambda: model(*x), copies


def training(name, batch, layout):
    x, t = list(inputs(name, batch).values()), targets(name, batch)
    model = prepared(MODEL[name]().train(), x, layout)
    if name == "lpips":                     # frozen: the gradient is the image's
        x[0].requires_grad_()
        return lambda: model.loss(*x).backward(), 1
    adam = torch.optim.Adam(model.parameters(), lr=1e-6, weight_decay=5e-4, foreach=True)

    def step():
        adam.zero_grad(set_to_none=True)
        model.loss(*x, *t).backward()
        adam.step()
    return step, 1


def measure(subject, runs, seconds):
    run, copies = subject
    ms = []
    for _ in range(min(WARM_UP, runs)):
        run()
    start = time.perf_counter()
    while not ms or (len(ms) < runs and time.perf_counter() - start < seconds):
        t = time.perf_counter()
        run()
        ms.append(1e3 * (time.perf_counter() - t) / copies)
    ms.sort()
    middle = (ms[(len(ms) - 1) // 2] + ms[len(ms) // 2]) / 2
    return {"median_ms": middle, "min_ms": ms[0], "runs": len(ms),
            "peak_rss_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024}


@torch.onnx.symbolic_helper.parse_args("v", "v", "f", "i", "i", "i", "i")
def roi_align(g, x, rois, scale, rows, columns, ratio, aligned):
    """Debian's torchvision writes that of opset 10, and later ones take its boxes to lie half a pixel elsewhere"""
    def columns_of(*at):
        return g.op("Gather", rois, g.op("Constant", value_t=torch.tensor(at)), axis_i=1)

    image = g.op("Squeeze", columns_of(0), g.op("Constant", value_t=torch.tensor([1])))
    return g.op("RoiAlign", x, columns_of(1, 2, 3, 4), g.op("Cast", image, to_i=7), spatial_scale_f=scale,
                output_height_i=rows, output_width_i=columns, sampling_ratio_i=max(0, ratio),
                coordinate_transformation_mode_s="half_pixel" if aligned else "output_half_pixel")


def export(name, batch, folder):
    torch.onnx.register_custom_op_symbolic("torchvision::roi_align", roi_align, 17)
    model, x = for_inference(name, batch)
    with torch.no_grad():
        out = model(*x.values())
    out = out if isinstance(out, tuple) else (out,)
    out = {"out%d" % i: o for i, o in enumerate(out)}
    torch.onnx.export(model, tuple(x.values()), os.path.join(folder, "model.onnx"), opset_version=17,
                      input_names=list(x), output_names=list(out))
    for key, value in {**x, **out}.items():
        value.contiguous().numpy().tofile(os.path.join(folder, key + ".f32"))
    return {"parameters": sum(p.numel() for p in model.parameters()), "copies": getattr(model, "copies", 1),
            "inputs": {key: list(v.shape) for key, v in x.items()}}


def main():
    name, mode, batch, how = sys.argv[1], sys.argv[2], int(sys.argv[3]), sys.argv[4]
    torch.manual_seed(0)
    torch.set_flush_denormal(True)
    if mode == "export":
        result = export(name, batch, how)
    elif mode == "infer":
        with torch.inference_mode():
            result = measure(inference(name, batch, how), int(sys.argv[5]), float(sys.argv[6]))
    else:
        result = measure(training(name, batch, how), int(sys.argv[5]), float(sys.argv[6]))
    print(json.dumps(dict(result, version=torch.__version__.split("a0")[0])))


main()
