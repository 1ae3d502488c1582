# SPDX-License-Identifier: Apache-2.0
"""Reference numbers for tests/vision/test_crop.c: colour changes by the formulas that torchvision documents
(hue through Python's colorsys), blur by SciPy. Run: python3 scripts/vectors/augment.py > tests/vision/augment_vectors.h
"""
import colorsys
import numpy as np
from scipy.ndimage import gaussian_filter

H, W = 4, 5
rng = np.random.RandomState(7)
image = np.round(rng.rand(3, H, W), 3)
image[:, 0, 0] = 0.5          # grey: no hue
image[:, 0, 1] = 0            # black
image[:, 0, 2] = (1, 0, 0)    # pure red


def grey(x):
    return 0.2989 * x[0] + 0.587 * x[1] + 0.114 * x[2]


def blend(x, other, factor):
    return np.clip(factor * x + (1 - factor) * other, 0, 1)


def hue(x, shift):
    out = np.empty_like(x)
    for i in np.ndindex(H, W):
        h, s, v = colorsys.rgb_to_hsv(*x[(slice(None),) + i])
        out[(slice(None),) + i] = colorsys.hsv_to_rgb((h + shift) % 1, s, v)
    return out


def blur(x, sigma):
    return np.stack([gaussian_filter(c, sigma, mode="nearest", truncate=3 / sigma) for c in x])


def show(name, x):
    print("static const float %s[%d] = {" % (name, x.size))
    flat = x.ravel()
    for i in range(0, flat.size, 5):
        print("    " + " ".join("%.9gf," % float(v) if v % 1 else "%d," % v for v in flat[i:i + 5]))
    print("};")


print("/* SPDX-License-Identifier: Apache-2.0 */")
print("/* Made by scripts/vectors/augment.py */")
print("enum { VECTOR_H = %d, VECTOR_W = %d };" % (H, W))
show("vector_image", image)
show("vector_brightness", blend(image, 0, 1.4))
show("vector_contrast", blend(image, grey(image).mean(), 0.6))
show("vector_saturation", blend(image, grey(image), 1.3))
show("vector_hue_up", hue(image, 0.12))
show("vector_hue_down", hue(image, -0.15))
show("vector_blur", blur(image, 0.5))
