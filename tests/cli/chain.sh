#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# The command as the user guide shows it, from nothing to pictures, as small as it goes.
set -eu
here=tests/cli/chain.dir
rm -rf "$here"
mkdir -p "$here"

# leaves FILE...: a step's results are there and not empty
leaves()
{
    for f in "$@"; do
        [ -s "$here/$f" ] || {
            echo "no $here/$f"
            exit 1
        }
    done
}

./palmar synth --preset tiny --frames 12 --out "$here/data" 2>/dev/null
leaves data/train.txt data/evaluation_xyz.json data/manifest.json

./palmar train --config hocat-tiny --data "$here/data" --out "$here/run" --quiet \
    --set optim.steps=2 --set optim.batch=4 --set model.width=8 --set train.validate_samples=4
leaves run/config.json run/log.jsonl run/checkpoints/last.safetensors

./palmar eval "$here/run" --data "$here/data" --no-bench >"$here/tables.txt" 2>/dev/null
leaves run/eval/table.md run/eval/scores.json run/eval/per-sample.csv run/eval/per-joint.csv run/eval/pictures.png
grep -q '(synthetic)' "$here/tables.txt"

./palmar predict "$here/run" "$here"/data/evaluation/*/rgb --object mustard_bottle --out "$here/seen" 2>/dev/null
./palmar info "$here/run/checkpoints/last.safetensors" | grep -q hocat
set -- "$here"/seen/*.overlay.png
[ $# = 4 ]

# A run's folder is not written over, and the line says what to do.
if ./palmar train --config hocat-tiny --data "$here/data" --out "$here/run" 2>"$here/refused.txt"; then
    echo "trained over an old run"
    exit 1
fi
grep -q -e --resume "$here/refused.txt"
