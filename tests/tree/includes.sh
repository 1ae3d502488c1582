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
below="$lt/base/|$lt/kernels/"
only_from $lt/base     "$lt/base/"
only_from $lt/kernels  "$below"
only_from $lt/geometry "$below|$lt/geometry/"
only_from $lt/graph    "$below|$lt/graph/"
only_from $lt/ops      "$below|$lt/geometry/|$lt/graph/|$lt/ops/"
only_from $lt/nn       "$below|$lt/geometry/|$lt/graph/|$lt/ops/|$lt/nn/"
only_from $lt/optim    "$below|$lt/graph/|$lt/optim/"
only_from $lt/io       "$lt/base/|$lt/geometry/|$lt/graph/|$lt/ops/|$lt/io/"
only_from models       "$lt/|models/"
only_from assets       "$lt/|assets/"
only_from vision       "$lt/|assets/|vision/"
below="$lt/|assets/|vision/|data/"
only_from data         "$below"
only_from synth        "$below|synth/"
below="$below|models/|estimate/"
only_from estimate     "$below"
only_from train        "$below|train/|eval/metrics/metrics\.h"
only_from eval         "$below|eval/"
only_from pipeline     "$below|pipeline/"
only_from cli          "$below|synth/|train/|eval/|pipeline/|cli/"

# Models open no files.
wrong=$(grep -rnE '\b(fopen|open|opendir|lt_(npz|npy|json|image|file)_[a-z_]*) *\(' --include='*.c' models)
[ -z "$wrong" ] || { echo "models open no files:"; echo "$wrong"; bad=1; }
exit $bad
