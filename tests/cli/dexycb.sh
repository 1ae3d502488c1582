#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# A small dataset in DexYCB's layout: made, told about, trained on and scored; a damaged sample is passed over.
set -eu
here=tests/cli/dexycb.dir
rm -rf "$here"
mkdir -p "$here"

./palmar synth --layout dexycb --preset tiny --frames 60 --out "$here/data" 2>/dev/null
[ -s "$here/data/synthetic.json" ]
./palmar synth --layout dexycb --png --out "$here/png" 2>&1 | grep -q 'images are JPEG'
[ ! -e "$here/png" ]
[ -s "$here/data/manifest.json" ]
[ -s "$here"/data/calibration/intrinsics/836212060125_640x480.yml ]

# 3 subjects x 8 sequences x 2 cameras, a frame each; the fifth sequence of each object is for evaluation.
./palmar train --config hocat-tiny --data "$here/data" --out "$here/run" --quiet \
    --set optim.steps=2 --set optim.batch=4 --set model.width=8 --set train.validate_samples=1000 \
    --set data.bilinear=true

# What is scored is what was validated: finger tips, sampling and all.
pa_mpjpe() { sed -n 's/.*"pa_mpjpe_mm": *\([0-9]*\.[0-9]\{4\}\).*/\1/p' | head -n 1; }
validated=$(pa_mpjpe <"$here/run/log.jsonl")
./palmar eval "$here/run" --data "$here/data" --split val --no-bench --json >"$here/scores.json" 2>/dev/null
scored=$(tr ',' '\n' <"$here/scores.json" | pa_mpjpe)
[ -n "$validated" ] && [ "$validated" = "$scored" ]

./palmar eval "$here/run" --data "$here/data" --no-bench >"$here/tables.txt" 2>/dev/null
grep -q 'DexYCB s0.*split test; 4 samples, 0 failed' "$here/tables.txt"

./palmar info --data "$here/data" >"$here/info.txt"
grep -q 'right hands on the hand model' "$here/info.txt"
grep -q 'left hands on the hand model' "$here/info.txt"

# An object that the unified estimator finds no pose of is a miss, wherever the stand-in for a pose would be.
./palmar train --config unified-tiny --data "$here/data" --out "$here/blind" --quiet \
    --set optim.steps=1 --set optim.batch=4 --set train.validate_every=0 --set data.contact_mm=0
./palmar eval "$here/blind" --data "$here/data" --no-bench >"$here/blind.txt" 2>/dev/null
grep -q '"no_object_pose_percent":[[:space:]]*100$' "$here/blind/eval/scores.json"
grep -q '^| unified (synthetic) .*| full .*| *0\.00 | *0\.00 |$' "$here/blind/eval/table.md"

# The toolkit's result file of hand joints, and its score.
./palmar eval "$here/run" --data "$here/data" --submit "$here/hpe.txt" 2>/dev/null
[ "$(wc -l <"$here/hpe.txt")" = 4 ]
./palmar eval --pred "$here/hpe.txt" --data "$here/data" 2>/dev/null | grep -q '^relative_mpjpe_mm: '

./palmar eval --pred "$here/data/manifest.json" --data "$here/data" 2>&1 | grep -q 'are scored'

# A sample twice is one too many.
cat "$here/hpe.txt" "$here/hpe.txt" >"$here/twice.txt"
./palmar eval --pred "$here/twice.txt" --data "$here/data" 2>&1 | grep -q 'two lines for sample'

# Its file of object poses has what is in the hand alone.
./palmar eval "$here/run" --data "$here/data" --submit "$here/poses.csv" 2>/dev/null
./palmar eval --pred "$here/poses.csv" --data "$here/data" >"$here/bop.txt" 2>/dev/null
grep -q '^all ' "$here/bop.txt"
grep -q '^grasp only  *4  *4 ' "$here/bop.txt"

# Pictures cut short, one to train and one to validate on: each named once, the rest as before.
for sequence in 100000 100004; do
    picture=$(echo "$here"/data/*subject-01/*_$sequence/836212060125/color_000000.jpg)
    head -c 100 "$picture" >"$here/cut" && mv "$here/cut" "$picture"
done
./palmar train --config hocat-tiny --data "$here/data" --out "$here/run2" --set optim.epochs=2 --set optim.batch=8 \
    --set model.width=8 --set data.tolerate=0.2 2>"$here/log.txt"
[ "$(grep -c '_100000/.*color_000000.jpg' "$here/log.txt")" = 1 ]
[ "$(grep -c '_100004/.*color_000000.jpg' "$here/log.txt")" = 1 ]
[ -s "$here/run2/checkpoints/last.safetensors" ]
if ./palmar info --data "$here/data" --samples 0 >"$here/info.txt" 2>&1; then
    echo "a damaged dataset is said to be sound"
    exit 1
fi
grep -q 'unreadable of these *1$' "$here/info.txt"
