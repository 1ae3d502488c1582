#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# A drawn world through all of palmar watch, as the user guide shows it: records, recordings, replays, the page, scores.
set -eu
here=tests/cli/live.dir
rm -rf "$here"
mkdir -p "$here"

# value KEY FILE: of the last line
value()
{
    tail -n 1 "$2" | sed -n "s/.*\"$1\": \"\{0,1\}\([^,\"}]*\).*/\1/p"
}

./palmar synth --preset world --cameras 2 --frames 16 --seed 5 --export coco,bop --out "$here/world" 2>/dev/null
[ -s "$here/world/truth.ndjson" ]
[ -s "$here/world/bop/train_synt/000002/scene_gt.json" ]
./palmar info --data "$here/world/coco" | grep -q 'synthetic  *true'
./palmar synth --preset body --frames 12 --out "$here/persons" 2>/dev/null
./palmar train --config body-tiny --data "$here/persons" --out "$here/body" --quiet --set optim.steps=1 \
    --set optim.batch=2 --set train.validate_every=0 2>/dev/null
./palmar synth --preset actions --clips 100 --out "$here/actions" 2>/dev/null
./palmar train --config action-small --data "$here/actions" --out "$here/action" --quiet --set optim.steps=1 \
    --set optim.batch=2 --set train.validate_every=0 2>/dev/null

# without models it says how to make them, and does what it can
./palmar watch "$here/world" --pace fast --no-window --json --seconds 0.3 >"$here/blind.ndjson" 2>"$here/hints.txt"
grep -q 'no --body, so no skeletons; to train one: palmar synth --preset body' "$here/hints.txt"
grep -q '"class": "person"' "$here/blind.ndjson"

./palmar watch "$here/world" --pace fast --no-window --json -q --body "$here/body" --action "$here/action" \
    --record "$here/session" >"$here/seen.ndjson"
[ "$(grep -c '"schema": "palmar.set/1"' "$here/seen.ndjson")" -ge 14 ]
[ "$(value captured "$here/seen.ndjson")" = $(($(value taken "$here/seen.ndjson") + $(value dropped "$here/seen.ndjson"))) ]
grep -q '"people": \[{"id"' "$here/seen.ndjson"
cmp "$here/seen.ndjson" "$here/session/session.ndjson"
cmp "$here/world/truth.ndjson" "$here/session/truth.ndjson"

# two replays, with one thread and with three, say the same
for threads in 1 3; do
    ./palmar watch "$here/session" --pace fast --no-window --json -q --body "$here/body" --action "$here/action" \
        --threads $threads >"$here/replay-$threads.ndjson"
done
[ "$(value crc32 "$here/replay-1.ndjson")" = "$(value crc32 "$here/replay-3.ndjson")" ]

./palmar report "$here/session" >/dev/null
[ -s "$here/session/report.html" ]
./palmar eval "$here/action" --data "$here/world" --json 2>/dev/null | grep -q '"accuracy"'
# a body that has learnt nothing may stand where nobody is
{ ./palmar eval "$here/action" --data "$here/world" --set "data.seen=$here/seen.ndjson" --json 2>&1 || true; } |
    grep -q -e '"accuracy"' -e 'none is seen while doing one thing'
rm -rf "$here"
