#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# The programs that the documents show, built outside the tree and run. Against the installed library: the layer of
# docs/adding-a-layer.md, the network of docs/your-first-network.md, and the C of README.md exactly as printed; against the
# build folder, as they are made of what palmar is made of: the model of docs/adding-a-model.md and the task of
# docs/adding-a-task.md.
. "${srcdir:?}/tests/tree/stage.sh"
set -e
top=$(cd "${srcdir:?}" && pwd)
build=$(pwd)
rm -rf tests/tree/examples.dir
mkdir -p tests/tree/examples.dir
cd tests/tree/examples.dir

cp "$top"/docs/examples/swish_layer/* .
env -u MAKEFLAGS -u MFLAGS -u MAKELEVEL make -s CC="$CC" CFLAGS="-O2 -Wall -Wextra -Werror $EXTRA_CFLAGS" \
    PKG_CONFIG="$PKG_CONFIG"
./swish

cp "$top"/docs/examples/first_network/* .
env -u MAKEFLAGS -u MFLAGS -u MAKELEVEL make -s CC="$CC" CFLAGS="-O2 -Wall -Wextra -Werror $EXTRA_CFLAGS" \
    PKG_CONFIG="$PKG_CONFIG"
./first | tee first.out
grep -q ': equal$' first.out
awk '$1 == "trained" && $2 >= 0.9 { learned = 1 } END { exit !learned }' first.out
[ -s half.safetensors ]
[ -s first.onnx ]

awk '/^```c$/ { on = 1; next } /^```$/ { on = 0 } on' "$top/README.md" >readme.c
# shellcheck disable=SC2046,SC2086 # lists of flags
$CC -O2 -Wall -Wextra -Werror $EXTRA_CFLAGS readme.c -o readme $($PKG_CONFIG --cflags --libs libtensor)
# It leaves freeing to its end, as short programs do.
ASAN_OPTIONS=detect_leaks=0 ./readme | tee readme.out
awk '$1 == "loss" && $2 < 1e-3 { learned = 1 } END { exit !learned }' readme.out

# A program that means another lt_real than the library does not link with it.
# shellcheck disable=SC2046,SC2086 # lists of flags
if $CC -DLT_DOUBLE -O2 $EXTRA_CFLAGS readme.c -o readme_double $($PKG_CONFIG --cflags --libs libtensor) 2>double.err; then
    echo "a program with LT_DOUBLE links with the library in float"
    exit 1
fi
grep -q 'lt_graph_new_of_doubles' double.err

# own NAME ARGUMENTS: build the example of that name, and run it
own()
{
    name=$1
    shift
    cp "$top/docs/examples/$name"/* .
    env -u MAKEFLAGS -u MFLAGS -u MAKELEVEL make -s CC="$CC" CFLAGS="-O2 -Wall -Wextra -Werror $EXTRA_CFLAGS" \
        PKG_CONFIG="$PKG_CONFIG" PALMAR="$top" BUILD="$build"
    "./$name" "$@" 2>own.err >own.out || { cat own.err; exit 1; }
}

own own_task dots
awk '$1 == "dots" && $4 < 1 { learned = 1 } END { exit !learned }' own.out
"$build/palmar" synth --preset tiny --out data >/dev/null 2>&1
own own_model data model
grep -q '^PA-MPJPE [0-9.]* mm$' own.out
grep -q '"small":' model/log.jsonl
