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
    --set optim.steps=2 --set optim.batch=4 --set model.width=8 --set train.validate_samples=4 2>"$here/trained.txt"
grep -q 'no better than the mean of the training labels' "$here/trained.txt" || {
    echo 'train: does not say that two steps teach nothing'
    exit 1
}
leaves run/config.json run/log.jsonl run/checkpoints/last.safetensors
for key in version host cpu isa threads data data_crc32; do
    grep -q "\"$key\": *[^\", ]\|\"$key\": *\"[^\"]" "$here/run/env.json" || {
        echo "run/env.json does not say $key"
        exit 1
    }
done

./palmar eval "$here/run" --data "$here/data" --no-bench >"$here/tables.txt" 2>/dev/null
leaves run/eval/table.md run/eval/scores.json run/eval/per-sample.csv run/eval/per-joint.csv run/eval/pictures.png
grep -q '(synthetic)' "$here/tables.txt"

./palmar predict "$here/run" "$here"/data/evaluation/*/rgb --object mustard_bottle --out "$here/seen" 2>/dev/null
./palmar info "$here/run/checkpoints/last.safetensors" | grep -q hocat
set -- "$here"/seen/*.overlay.png
[ $# = 4 ]

# One image with boxes of its own; what is assumed of the others is said once.
set -- "$here"/data/evaluation/*/rgb
rgb=$1
set -- "$rgb"/*
image=$(basename "$1")
printf 'image,side,hand_x0,hand_y0,hand_x1,hand_y1\n%s,left,200,100,400,300\n' "$image" >"$here/boxes.csv"
./palmar predict "$here/run" "$rgb" --boxes "$here/boxes.csv" --out "$here/boxed" 2>"$here/boxed.txt"
grep -q '"listed"' "$here/boxed/${image%.*}.json"
grep -q '"left"' "$here/boxed/${image%.*}.json"
[ "$(grep -l '"listed"' "$here"/boxed/*.json | wc -l)" = 1 ]
[ $# -gt 1 ]
[ "$(grep -c 'boxes.csv: took the middle of the image' "$here/boxed.txt")" = 1 ]

# No boxes at all: a detector, which has learnt nothing yet, says so of each image, and needs no model beside it.
mkdir -p "$here/seen-by/annotations"
for split in train evaluation; do
    ln -s "../data/${rgb#"$here"/data/}" "$here/seen-by/$split"
    printf '{"images": [{"id": 1, "file_name": "%s", "width": 640, "height": 480}], "categories": [{"id": 1, "name": "hand"}],
        "annotations": [{"image_id": 1, "category_id": 1, "bbox": [200, 100, 200, 200]}]}' "$image" \
        >"$here/seen-by/annotations/instances_$split.json"
done
./palmar train --config detect-n --data "$here/seen-by" --out "$here/detector" --quiet --set model.classes=1 \
    --set model.image_size=64 --set optim.epochs=1 --set optim.batch=1 --set optim.warmup=0 2>/dev/null
leaves detector/checkpoints/last.safetensors
./palmar predict "$here/run" "$rgb" --detector "$here/detector" --out "$here/blind" 2>"$here/blind.txt"
[ "$(grep -c 'the detector found nothing' "$here/blind.txt")" = $# ]
./palmar predict "$rgb" --detector "$here/detector" --json 2>/dev/null >"$here/blind.jsonl"
[ "$(grep -c '"schema": "palmar.frame/1".*"hands": \[\], "objects": \[\], "people": \[\]' "$here/blind.jsonl")" = $# ]
./palmar predict "$here/detector" "$rgb" --json 2>/dev/null | cmp - "$here/blind.jsonl"
./palmar eval "$here/detector" --json >/dev/null 2>&1

# Who names no model gets the ones that come with palmar, of half the size, and reads which they are.
mkdir "$here/starter"
for role in detector hand-object; do
    ./palmar export "$here/$([ $role = detector ] && echo detector || echo run)" --half \
        -o "$here/starter/$role.safetensors" >/dev/null
    printf '{"name": "%s", "role": "%s", "licence": "Apache-2.0"}' $role $role >"$here/starter/$role.json"
done
mkdir "$here/finds-alone"
cp "$here/starter/detector.json" "$here/starter/detector.safetensors" "$here/finds-alone"
PALMAR_STARTER=$here/finds-alone ./palmar predict "$1" --out "$here/by-detector" 2>"$here/by-detector.txt"
grep -q 'no model is named: .*detector.safetensors looks for hands and objects' "$here/by-detector.txt"
leaves "by-detector/${image%.*}.json"
# what comes with palmar is what its cards say, and sees
for card in "${srcdir:-..}"/models/starter/*.json; do
    grep -q "\"sha256\": \"$(sha256sum "${card%.json}.safetensors" | cut -d' ' -f1)\"" "$card"
done
./palmar synth --preset detect --frames 3 --seed 2026 --out "$here/unseen" >/dev/null 2>&1
./palmar predict "$here/unseen/train/000001.jpg" --json 2>/dev/null >"$here/found.json"
[ "$(grep -o '"class": *"hand"' "$here/found.json" | wc -l)" -ge 2 ]
[ "$(PALMAR_STARTER=$here/starter ./palmar info starter --json | grep -o '"role"' | wc -l)" = 2 ]
PALMAR_STARTER=$here/starter ./palmar predict "$1" --out "$here/by-starter" 2>"$here/by-starter.txt"
grep -q 'no model is named: .*hand-object.safetensors and .*detector.safetensors look at it' "$here/by-starter.txt"
leaves "by-starter/${image%.*}.json"
./palmar report "$here/detector" >/dev/null
grep -q 'What is taken for what' "$here/detector/report.html"

# The weights alone are a checkpoint to whatever reads one, and those that are scored: here the average over the steps.
./palmar export "$here/run" -o "$here/weights.safetensors" >/dev/null
./palmar eval "$here/weights.safetensors" --data "$here/data" --no-bench --out "$here/weights" >/dev/null 2>&1
cmp "$here/run/eval/per-sample.csv" "$here/weights/per-sample.csv"
./palmar predict "$here/weights.safetensors" "$here"/data/evaluation/*/rgb --object mustard_bottle --out "$here/same" \
    2>/dev/null
for picture in "$here"/seen/*.overlay.png; do
    cmp "$picture" "$here/same/$(basename "$picture")"
done
./palmar bench --config "$here/weights.safetensors" --runs 3 --seconds 0 >/dev/null
[ "$(wc -c <"$here/weights.safetensors")" -lt "$(($(wc -c <"$here/run/checkpoints/last.safetensors") / 3))" ]

# Tables and claims of the runs in a folder.
./palmar eval --tables="$here" >"$here/filled.txt"
grep -q '^HOCAT, Table 5' "$here/filled.txt"
grep -q '^run: hocat full (synthetic)  *synthetic ' "$here/filled.txt"
if grep -e '(synthetic) - ' "$here/filled.txt"; then
    echo "a difference from a paper's row of other data"
    exit 1
fi
./palmar eval --tables="$here" --json | grep -q '"key":  *"pa_mpjpe_mm"\|"key":"pa_mpjpe_mm"'

# With 8-bit integers: a checkpoint like the others. Ranges of two samples are enough to see that it runs.
./palmar export "$here/run" --int8 --calibration "$here/data" --calibration-samples 2 -o "$here/int8.safetensors" \
    >"$here/int8.txt" 2>/dev/null
grep -q ' layers read 8-bit integers' "$here/int8.txt"
grep -q '^ *int8 *[0-9.]* *[0-9.]*$' "$here/int8.txt"
grep -q '^PA-MPJPE [+-][0-9.]* % on 4 samples; [0-9.]* times as fast' "$here/int8.txt"
./palmar eval "$here/int8.safetensors" --data "$here/data" --no-bench --out "$here/int8" >/dev/null 2>&1
leaves int8/per-sample.csv
if cmp -s "$here/run/eval/per-sample.csv" "$here/int8/per-sample.csv"; then
    echo "the same scores with integers as without"
    exit 1
fi

# A run's folder is not written over, and the line says what to do.
if ./palmar train --config hocat-tiny --data "$here/data" --out "$here/run" 2>"$here/refused.txt"; then
    echo "trained over an old run"
    exit 1
fi
grep -q -e --resume "$here/refused.txt"

# says CODE WORDS COMMAND...: the command ends with the code, and what it complains of has the words
says()
{
    code=$1 words=$2
    shift 2
    got=0
    "$@" >/dev/null 2>"$here/said.txt" || got=$?
    if [ "$got" != "$code" ] || ! grep -q -e "$words" "$here/said.txt"; then
        echo "$*: code $got, want $code and \"$words\":"
        cat "$here/said.txt"
        exit 1
    fi
}

says 2 'is named by --out' ./palmar train --resume "$here/run"
says 2 'give one of them' ./palmar train --resume --init "$here/int8.safetensors" --out "$here/run"
says 2 'no config "hocat-tin"' ./palmar train --config hocat-tin --data "$here/data" --out "$here/none"
says 1 'a dataset goes behind --data' ./palmar info "$here/data"
says 1 'No such file' ./palmar info "$here/nothing"
mkfifo "$here/pipe"
says 1 'not a regular file' ./palmar eval --pred "$here/pipe" --data "$here/data"
says 4 'File too large' sh -c "ulimit -f 100; exec ./palmar export '$here/run' -o '$here/large.onnx'"
says 4 'standard output' sh -c 'exec ./palmar info --model hocat >/dev/full'
says 2 'no --limit' ./palmar eval "$here/run" --data "$here/data" --submit "$here/p.zip" --limit 2
says 2 'frames without a hand' ./palmar eval "$here/run" --data "$here/data" --filter every
says 2 'the whole file is scored' ./palmar eval --pred "$here/p.zip" --data "$here/data" --max-pa-mpjpe 1
says 2 'the whole file is scored' ./palmar eval --pred "$here/p.zip" --data "$here/data" --require 'pa_auc>=0'
says 2 'draws no pictures for --lpips' ./palmar eval "$here/run" --data "$here/data" --lpips "$here/l.pth"
says 2 'choose among' ./palmar eval "$here/run" --data "$here/data" --setup s1
says 1 'a .json, or a .zip' ./palmar eval "$here/run" --data "$here/data" --submit "$here/p.txt"
says 2 'go with ONNX' ./palmar export "$here/run" -o "$here/w.safetensors" --samples "$here/s.npz"
says 2 'takes no checkpoint' ./palmar eval "$here/run" --claims="$here"
says 2 'tables reads scored runs: it takes no checkpoint' ./palmar eval "$here/run" --tables="$here"
says 2 'not both' ./palmar eval --claims --tables="$here"
says 1 'no scored run in it' ./palmar eval --tables="$here/run"
says 1 'want at most 0.00' ./palmar eval "$here/run" --data "$here/data" --no-bench --max-pa-mpjpe 0
says 1 'PA-MPJPE is .* mm, want at most 0.00; AUC of ADD-S is .*, want at least 2.00$' ./palmar eval "$here/run" \
    --data "$here/data" --no-bench --require 'adds_auc<=1' --max-pa-mpjpe 0 --require 'adds_auc>=2'
says 0 '' ./palmar eval "$here/run" --data "$here/data" --no-bench --require 'pa_mpjpe_mm >= 0' --require 'adds_auc<=1'
says 1 'run/config.json' ./palmar eval "$here/run" --data "$here/data" --no-bench --out "$here/run/config.json"
printf 'image,hand_x0,hand_y0,hand_x1,hand_y1\nnowhere.jpg,1,2,3,4\n' >"$here/boxes.csv"
says 1 'boxes.csv:2: there is no image nowhere.jpg' ./palmar predict "$here/run" "$rgb" --boxes "$here/boxes.csv"
says 1 'has no starter models; scripts/train-starter trains them' \
    env PALMAR_STARTER="$here/nowhere" ./palmar predict "$1"
says 2 '--half is for safetensors' ./palmar export "$here/run" --half -o "$here/w.onnx"
says 2 'finds where they are' ./palmar predict "$rgb" --detector "$here/detector" --hand-box 1,2,3,4
says 2 'goes with --detector' ./palmar predict "$here/run" "$rgb" --track byte
says 2 'goes by looks; want --reid' ./palmar predict "$rgb" --detector "$here/detector" --track deepsort
says 2 'goes with a model' ./palmar predict "$rgb" --detector "$here/detector" --boxes "$here/boxes.csv"
says 1 'want a model for detect' ./palmar predict "$rgb" --detector "$here/run"
says 2 'want a whole number' ./palmar synth --seed 1.5 --out "$here/half"
./palmar eval "$here/run" --data "$here/data" --submit "$here/p.zip" 2>/dev/null
./palmar eval --pred "$here/p.zip" --data "$here/data" 2>&1 >/dev/null | grep -q 'Protocol: SYNTHETIC'
./palmar gradcheck --help | grep -q 'double precision'
./palmar train -h | grep -q 'Usage: palmar train'
./palmar info "$here/run" | grep -q hocat
if ls "$here"/*.tmp 2>/dev/null; then
    echo "left behind"
    exit 1
fi

# Another instruction set gives other bits, which a run that goes on says.
if ! ./palmar info --system | grep -q 'in use  *generic'; then
    PALMAR_ISA=generic ./palmar train --resume --out "$here/run" --set optim.steps=3 2>"$here/resumed.txt"
    grep -q 'instructions and goes on with generic, so not to the same bits' "$here/resumed.txt"
fi

# Data without their manifest are no less synthetic.
rm "$here/data/manifest.json"
./palmar info --data "$here/data" --samples 1 | grep -q 'synthetic  *true'
echo '[[' >"$here/data/manifest.json"
says 1 'manifest.json' ./palmar info --data "$here/data"
