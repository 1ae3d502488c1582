# SPDX-License-Identifier: Apache-2.0
"""Hand and object in NumPy pictures: libpalmar, by ctypes.

    import palmar
    p = palmar.Palmar("runs/tiny")
    mug = p.load_object("mug")
    hand, = p.estimate(rgb, [{"hand_box": (210, 120, 420, 330), "object": mug}], camera=(615, 615, 320, 240))
    if hand["trusted"]:
        print(hand["joints"])

What each thing means stands in palmar.h. One Palmar belongs to one thread at a time; a call lets other threads run.
"""
import ctypes
import os

import numpy

# As palmar.h has them, in the compiler's layout.
_IMAGE = numpy.dtype([
    ("rgb", numpy.uintp), ("width", numpy.intc), ("height", numpy.intc), ("stride", numpy.intp),
    ("depth", numpy.uintp), ("depth_stride", numpy.intp), ("camera", numpy.double, 4),
], align=True)
_QUERY = numpy.dtype([
    ("hand_box", numpy.float32, 4), ("object_box", numpy.float32, 4), ("left", numpy.intc), ("object", numpy.intc),
], align=True)
_HAND = numpy.dtype([
    ("joints", numpy.float32, (21, 3)), ("vertices", numpy.float32, (778, 3)), ("joints2d", numpy.float32, (21, 2)),
    ("rotations", numpy.double, (16, 3)), ("shape", numpy.float32, 10), ("translation", numpy.float32, 3),
    ("placed", numpy.intc), ("trusted", numpy.intc), ("agreement_px", numpy.double), ("object_found", numpy.intc),
    ("object_trusted", numpy.intc),
    ("object_rotation", numpy.double, (3, 3)), ("object_translation", numpy.double, 3),
    ("object_inliers", numpy.intc), ("object_confidence", numpy.float32),
], align=True)


def _load():
    """The library that the loader finds, else the one of the tree that this file was installed to."""
    try:
        return ctypes.CDLL("libpalmar.so.0")
    except OSError:
        here = os.path.dirname(os.path.abspath(__file__))
        return ctypes.CDLL(os.path.join(here, "..", "..", "..", "lib", "libpalmar.so.0"))


_lib = _load()
_pointer, _text = ctypes.c_void_p, ctypes.c_char_p
_lib.palmar_open.argtypes = [_text, _text, ctypes.POINTER(_pointer)]
_lib.palmar_close.argtypes = [_pointer]
_lib.palmar_load_object.argtypes = [_pointer, _text, _text, ctypes.POINTER(ctypes.c_int)]
_lib.palmar_film.argtypes = [_pointer, ctypes.c_double]
_lib.palmar_estimate.argtypes = [_pointer, _pointer, ctypes.c_int, _pointer, _pointer]
_lib.palmar_faces.argtypes = [_pointer]
_lib.palmar_faces.restype = ctypes.POINTER(ctypes.c_int32)
_lib.palmar_set_threads.argtypes = [ctypes.c_int]
_lib.palmar_last_error.restype = _text
_lib.palmar_version.restype = _text

__version__ = _lib.palmar_version().decode()


class Error(Exception):
    """A call that failed, with the line that says why."""


def _check(status):
    if status:
        raise Error(_lib.palmar_last_error().decode(errors="replace"))


def _path(name):
    return None if name is None else os.fsencode(name)


def _rows(array, kind, shape, name):
    """The array itself where only its rows are apart, else a copy."""
    array = numpy.asarray(array, kind)
    if array.ndim != len(shape) or any(want and have != want for have, want in zip(array.shape, shape)):
        raise ValueError(f"{name} is {array.shape}, want (height, width{', 3' if len(shape) == 3 else ''})")
    inner = array[0] if array.shape[0] else array
    return array if inner.flags.c_contiguous and array.strides[0] > 0 else numpy.ascontiguousarray(array)


class Palmar:
    """A trained model: a run's folder or a checkpoint. hand: as palmar's --hand; None: that of the training."""

    def __init__(self, run, hand=None):
        self._p = _pointer()
        _check(_lib.palmar_open(_path(run), _path(hand), ctypes.byref(self._p)))
        self.faces = numpy.ctypeslib.as_array(_lib.palmar_faces(self._p), (1538, 3)).copy()

    def __del__(self):
        self.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        """Give its memory back; nothing more can be asked of it."""
        _lib.palmar_close(self._p)
        self._p = _pointer()

    def load_object(self, name, models=None):
        """An object whose pose is to be found, for "object" in a query."""
        number = ctypes.c_int()
        _check(_lib.palmar_load_object(self._p, _path(name), _path(models), ctypes.byref(number)))
        return number.value

    def film(self, fps):
        """Pictures from here on are a film's, fps a second; 0: unrelated."""
        _check(_lib.palmar_film(self._p, fps))

    def estimate(self, rgb, queries=({},), camera=None, depth=None):
        """A structured array of hands, one for each query: a dict of hand_box, object_box, left and object.

        rgb (height, width, 3) of 8 bits; camera (fx, fy, cx, cy); depth (height, width) in metres.
        """
        rgb = _rows(rgb, numpy.uint8, (0, 0, 3), "rgb")
        image, query = numpy.zeros((), _IMAGE), numpy.zeros(len(queries), _QUERY)
        hands = numpy.zeros(len(queries), _HAND)
        image["rgb"], image["stride"] = rgb.ctypes.data, rgb.strides[0]
        image["height"], image["width"] = rgb.shape[:2]
        image["camera"] = (0, 0, 0, 0) if camera is None else camera
        if depth is not None:
            depth = _rows(depth, numpy.float32, rgb.shape[:2], "depth")
            image["depth"], image["depth_stride"] = depth.ctypes.data, depth.strides[0]
        for one, keys in zip(query, queries):
            for key, value in keys.items():
                one[key] = value
        _check(_lib.palmar_estimate(self._p, image.ctypes.data, len(queries), query.ctypes.data, hands.ctypes.data))
        return hands


def set_threads(n):
    """Of all models; below 1: the CPUs this process may use."""
    _lib.palmar_set_threads(n)
