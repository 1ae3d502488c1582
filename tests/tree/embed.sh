#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# The examples of docs/from-c-and-python.md built outside the tree against the installed library, in C, C++ and Python,
# beside what palmar predict finds in the same picture.
. "${srcdir:?}/tests/tree/stage.sh"
set -e
top=$(cd "${srcdir:?}" && pwd)
palmar=$PWD/palmar
: "${datadir:?}"
rm -rf tests/tree/embed.dir
mkdir -p tests/tree/embed.dir
cd tests/tree/embed.dir

"$palmar" synth --preset tiny --frames 8 --out data >/dev/null 2>&1
"$palmar" train --quiet --config hocat-tiny --data data --out run --set optim.steps=1 --set optim.batch=2 \
    --set train.validate_every=0 >/dev/null
{
    printf 'P6\n320 240\n255\n'
    head -c 230400 "$palmar"
} >picture.ppm
"$palmar" predict run - --object mug --side right --quiet <picture.ppm >predict.json
wrist=$(sed 's/.*"joints3d_m": \[\[\([^]]*\)\].*/\1/' predict.json | tr -d , |
    awk '{ printf "%.4f %.4f %.4f", $1, $2, $3 }')

cp "$top"/docs/examples/from_c/* .
env -u MAKEFLAGS -u MFLAGS -u MAKELEVEL make -s CC="$CC" CXX="$CXX" PKG_CONFIG="$PKG_CONFIG" \
    CFLAGS="-O2 -Wall -Wextra -Werror $EXTRA_CFLAGS" CXXFLAGS="-O2 -Wall -Wextra -Werror $EXTRA_CFLAGS"
./pose run picture.ppm | tee pose.out
grep -q "^wrist $wrist m" pose.out
[ "$(wc -l <pose.c)" -le 30 ]
tail -c 230400 picture.ppm >picture.raw
cat picture.raw picture.raw picture.raw | ./film run 320 240 >film.out
[ "$(grep -c '^pinch 0\.' film.out)" = 3 ]
if ./pose run/config.json picture.ppm 2>error.out; then
    echo "a configuration was opened as a checkpoint"
    exit 1
fi
grep -q config.json error.out

# Python with NumPy, where it is, and with a library that needs no sanitizer loaded before it.
PYTHON=${PYTHON:-/usr/bin/python3}
"$PYTHON" -c 'import numpy' 2>/dev/null || exit 0
case $EXTRA_CFLAGS in *sanitize*) exit 0 ;; esac
PYTHONPATH=$stage$datadir/palmar/python PYTHONDONTWRITEBYTECODE=1 "$PYTHON" - <<'PY'
import json
import numpy
import palmar

rgb = numpy.fromfile("picture.raw", numpy.uint8).reshape(240, 320, 3)
with open("predict.json") as f:
    want = json.load(f)
with palmar.Palmar("run") as p:
    query = {"object": p.load_object("mug")}
    hand, = p.estimate(rgb, [query])
    keys = ("joints", "joints3d_m"), ("joints2d", "joints2d_px"), ("rotations", "theta_rad"), ("shape", "beta")
    for key, theirs in keys:
        numpy.testing.assert_allclose(hand[key].ravel(), numpy.ravel(want["hands"][0][theirs]), rtol=1e-6, atol=1e-9)
    assert bool(hand["trusted"]) == want["hands"][0]["trusted"]
    assert hand["agreement_px"] == want["hands"][0]["agreement_px"]
    assert bool(hand["object_found"]) == want["objects"][0]["found"]
    assert abs(hand["object_confidence"] - want["objects"][0]["confidence"]) < 1e-6
    assert hand["object_inliers"] == want["objects"][0]["inliers"]
    if hand["object_found"]:
        numpy.testing.assert_array_equal(hand["object_rotation"].ravel(), want["objects"][0]["R"])
        numpy.testing.assert_array_equal(hand["object_translation"], want["objects"][0]["t_m"])
    assert p.faces.min() == 0 and p.faces.max() == 777

    # a window of a larger picture, and one whose pixels are apart
    large = numpy.zeros((300, 400, 3), numpy.uint8)
    large[10:250, 20:340] = rgb
    other, = p.estimate(large[10:250, 20:340], [query])
    assert (other["vertices"] == hand["vertices"]).all()
    planes = numpy.ascontiguousarray(rgb.transpose(2, 0, 1)).transpose(1, 2, 0)
    other, = p.estimate(planes, [query])
    assert (other["vertices"] == hand["vertices"]).all()

    two = p.estimate(rgb, [query, {"left": 1, "hand_box": (10, 10, 150, 150)}], camera=(400, 400, 160, 120))
    assert len(two) == 2 and two[1]["joints"].shape == (21, 3)
    for bad, line in (({"object": 9}, "object 9"), ({"hand_box": (5, 5, 1, 9)}, "empty")):
        try:
            p.estimate(rgb, [bad])
        except palmar.Error as e:
            assert line in str(e), e
        else:
            raise AssertionError(line)
try:
    palmar.Palmar("nowhere")
except palmar.Error as e:
    assert "nowhere" in str(e)
else:
    raise AssertionError("nowhere was opened")
print("python", palmar.__version__)
PY
