#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Pictures with EXIF as Pillow writes it, films as FFmpeg and mkvmerge do, and what Pillow, FFmpeg and OpenCV make of
them, for tests/io: python3 pictures.py > picture_vectors.h
"""
import io
import subprocess
import tempfile

import numpy as np
import piexif
from PIL import Image


def emit(name, data):
    print(f"static const uint8_t {name}[{len(data)}] = {{")
    for i in range(0, len(data), 20):
        print("    " + " ".join(f"{b}," for b in data[i:i + 20]))
    print("};\n")


def emit_numbers(name, kind, x):
    print(f"static const {kind} {name}[{x.size}] = {{")
    flat = [f"{v:.9g}" for v in x.ravel()]
    for i in range(0, len(flat), 8):
        print("    " + ", ".join(flat[i:i + 8]) + ",")
    print("};\n")


def saved(image, *args, **kwargs):
    f = io.BytesIO()
    image.save(f, *args, **kwargs)
    return f.getvalue()


def exif(orientation, camera=None):
    """camera: the EXIF directory"""
    return piexif.dump({"0th": {piexif.ImageIFD.Orientation: orientation}, "Exif": camera or {}})


def picture():
    """4 x 2 pixels: red, green above blue, white"""
    rgb = np.zeros((2, 4, 3), np.uint8)
    rgb[0, :2], rgb[0, 2:], rgb[1, :2], rgb[1, 2:] = (255, 0, 0), (0, 255, 0), (0, 0, 255), (255, 255, 255)
    return Image.fromarray(rgb)


def pictures():
    tag = piexif.ExifIFD
    dslr = {tag.FocalLength: (50, 1), tag.FocalPlaneXResolution: (57281767, 10000), tag.FocalPlaneResolutionUnit: 2,
            tag.PixelXDimension: 5184, tag.PixelYDimension: 3456}
    compact = {tag.FocalLength: (58, 10), tag.FocalPlaneXResolution: (2560, 1), tag.FocalPlaneResolutionUnit: 3}
    yield "exif_png", saved(picture(), "png", exif=exif(6))
    yield "exif_webp", saved(picture(), "webp", lossless=True, exif=exif(8))
    yield "exif_dslr", saved(picture(), "jpeg", exif=exif(1, dslr))
    yield "exif_compact", saved(picture(), "jpeg", exif=exif(3, compact))


def run(*command):
    return subprocess.run(command, check=True, capture_output=True).stdout


def films(folder):
    """Two frames: left half red, right half blue, a green bar above; shown a quarter turn to the left. Then the corners
    of its first frame as FFmpeg shows it."""
    rgb = np.zeros((32, 48, 3), np.uint8)
    rgb[:, :24], rgb[:, 24:], rgb[:8] = (255, 0, 0), (0, 0, 255), (0, 255, 0)
    plain, turned, mkv = folder + "/plain.mp4", folder + "/turned.mp4", folder + "/turned.mkv"
    subprocess.run(["ffmpeg", "-v", "error", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s", "48x32", "-r", "25", "-i", "-",
                    "-c:v", "mpeg4", "-q:v", "2", "-bitexact", "-y", plain], input=2 * rgb.tobytes(), check=True)
    run("ffmpeg", "-v", "error", "-i", plain, "-c", "copy", "-metadata:s:v", "rotate=90", "-bitexact", "-y", turned)
    run("mkvmerge", "-q", "--deterministic", "1", "--projection-pose-roll", "0:90", "-o", mkv, plain)
    with open(turned, "rb") as f:
        yield "film_turned", f.read()
    with open(mkv, "rb") as f:
        yield "film_turned_mkv", f.read()
    seen = np.frombuffer(run("ffmpeg", "-v", "error", "-i", turned, "-frames:v", "1", "-f", "rawvideo", "-pix_fmt", "rgb24",
                             "-"), np.uint8)
    assert seen.size == rgb.size
    yield "film_turned_corners", seen.reshape(48, 32, 3)[[0, 0, -1, -1], [0, -1, 0, -1]].tobytes()


def main():
    print("/* SPDX-License-Identifier: Apache-2.0 */")
    print("/* Pictures and films of other software: scripts/vectors/pictures.py > tests/io/picture_vectors.h */")
    print("#ifndef TESTS_IO_PICTURE_VECTORS_H\n#define TESTS_IO_PICTURE_VECTORS_H\n\n#include <stdint.h>\n")
    for name, data in pictures():
        emit(name, data)
    with tempfile.TemporaryDirectory() as folder:
        for name, data in films(folder):
            emit(name, data)
    print("#endif")


main()
