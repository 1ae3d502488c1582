#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Who may include whom. An arrow that runs the other way is printed, and fails. Configure's own header is
# <config.h>: in quotes, a file in libtensor/io would get the config.h beside it.
cd "${srcdir:?}" || exit 1
bad=0

# only_from FOLDER PATTERN: files in FOLDER include of ours only what matches PATTERN
only_from()
{
    [ -d "$1" ] || return
    wrong=$(grep -rnE '^ *# *include "' --include='*.[ch]' --include='*.cpp' --include='*.inc' "$1" |
        grep -vE "include \"($2)")
    [ -z "$wrong" ] && return
    echo "$1 may include only $2:"
    echo "$wrong"
    bad=1
}

lt=libtensor
k=$lt/kernels
io=$lt/io
below="$lt/base/|$k/"
only_from $lt/base     "$lt/base/"
only_from $k           "$below"
only_from $k/gemm      "$lt/base/|$k/kernels\.h|$k/gemm/"
only_from $k/conv      "$lt/base/|$k/kernels\.h|$k/gemm/|$k/conv/"
only_from $k/blocks    "$lt/base/|$k/kernels\.h|$k/gemm/|$k/conv/|$k/blocks/"
only_from $k/int8      "$lt/base/|$k/kernels\.h|$k/gemm/|$k/conv/|$k/int8/"
only_from $k/splat     "$lt/base/|$k/kernels\.h|$k/vec/|$k/splat/"
only_from $lt/geometry "$below|$lt/geometry/"
only_from $lt/graph    "$below|$lt/graph/"
only_from $lt/ops      "$below|$lt/geometry/|$lt/graph/|$lt/ops/"
only_from $lt/nn       "$below|$lt/geometry/|$lt/graph/|$lt/ops/|$lt/nn/"
only_from $lt/optim    "$below|$lt/graph/|$lt/optim/"
only_from $io          "$lt/base/|$lt/geometry/|$lt/graph/|$lt/ops/|$io/"
file="$io/(file|atomic_file|kind|module)\.h"
only_from $io/text     "$lt/base/|$file|$io/text/"
only_from $io/array    "$lt/base/|$file|$io/text/|$io/array/"
only_from $io/pickle   "$lt/base/|$file|$io/text/|$io/array/|$io/pickle/"
only_from $io/torch    "$lt/base/|$file|$io/text/|$io/array/|$io/pickle/|$io/torch/"
only_from $io/onnx     "$lt/base/|$lt/graph/|$lt/ops/|$file|$io/protobuf\.h|$io/onnx/"
only_from $io/image    "$lt/base/|$file|$io/image/"
only_from $io/mesh     "$lt/base/|$lt/geometry/|$file|$io/text/|$io/array/|$io/mesh/"
only_from assets       "$lt/|assets/"
only_from vision       "$lt/|assets/|vision/"
below="$lt/|assets/|vision/|data/"
only_from data         "$below"
only_from synth        "$below|eval/metrics/|synth/"
below="$below|models/|estimate/"
only_from estimate     "$below"
only_from train        "$below|train/"
only_from eval         "$below|eval/"
only_from pipeline     "$below|pipeline/"
only_from libpalmar    "$below|pipeline/|libpalmar/"
only_from tasks        "$below|train/|eval/|synth/|tasks/"
only_from cli          "$below|synth/|train/|eval/|pipeline/|tasks/|cli/"

# No circles: at each place where the paths of a file and of a header it includes part, one room, or one file that is in
# none, stands above the other. What tsort cannot put in order is printed.
grep -rnoE '^ *# *include "[^"]+"' --include='*.[ch]' --include='*.cpp' --include='*.inc' \
    libtensor assets vision data synth models estimate train eval pipeline libpalmar tasks cli |
    sed -E 's/^([^:]+):[0-9]+: *# *include "([^"]+)"/\1 \2/' |
    awk '{
        n = split($1, from, "/"); m = split($2, to, "/"); at = ""
        for (i = 1; i < n && i < m && from[i] == to[i]; i++)
            at = at from[i] "/"
        if (from[i] != to[i])
            print at from[i], at to[i]
    }' | sort -u | tsort >/dev/null || bad=1

# Models open no files.
wrong=$(grep -rnE '\b(fopen|open|opendir|lt_(npz|npy|json|image|file)_[a-z_]*) *\(' --include='*.c' models)
[ -z "$wrong" ] || { echo "models open no files:"; echo "$wrong"; bad=1; }
exit $bad
