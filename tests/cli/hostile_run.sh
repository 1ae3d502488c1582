#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# A run's folder that somebody else has prepared: nothing is written through its links, and no pipe holds a run for ever.
# And what a killed run left half written is swept, a full disk keeps its name, and a signal ends any command.
set -eu
here=tests/cli/hostile_run.dir
rm -rf "$here"
mkdir -p "$here/outside"
data=$here/data
./palmar synth --preset tiny --frames 12 --out "$data" >/dev/null 2>&1

# trains OUT OPTION...: three steps of a small model, a checkpoint behind each
trains()
{
    out=$1
    shift
    timeout 60 ./palmar train --config hocat-tiny --data "$data" --out "$out" --quiet --set optim.steps=3 \
        --set optim.batch=4 --set model.width=8 --set train.validate_samples=4 --set train.checkpoint_steps=1 "$@"
}

# refuses WORDS COMMAND...: with exit 1, and a line that has these words
refuses()
{
    words=$1
    shift
    "$@" 2>"$here/err" && code=0 || code=$?
    [ "$code" = 1 ] && grep -q "$words" "$here/err" && return
    echo "$*: exit $code, wanted 1 and \"$words\":"
    cat "$here/err"
    exit 1
}

echo theirs >"$here/outside/file"
for name in log.jsonl metrics.csv stderr.log; do
    mkdir "$here/run"
    ln -s ../outside/file "$here/run/$name"
    refuses "$name: a link to another place" trains "$here/run"
    rm "$here/run/$name"
    mkfifo "$here/run/$name"
    refuses "$name: a pipe" trains "$here/run"
    rm -r "$here/run"
done
for name in tb checkpoints; do
    mkdir "$here/run"
    ln -s ../outside "$here/run/$name"
    refuses "$name: a link to another place" trains "$here/run"
    rm -r "$here/run"
done
[ "$(cat "$here/outside/file")" = theirs ]
[ "$(ls "$here/outside")" = file ]

# What a killed run left, of a process that is no more
mkdir -p "$here/run/checkpoints"
sh -c 'echo $$' >"$here/pid"
gone=$(cat "$here/pid")
touch "$here/run/config.json.$gone-3.tmp" "$here/run/checkpoints/step-000001.safetensors.$gone-4.tmp"
trains "$here/run"
[ -z "$(find "$here/run" -name '*.tmp')" ]

ln -s ../outside "$here/run/eval"
refuses 'eval: a link to another place' ./palmar eval "$here/run" --data "$data" --no-bench
rm "$here/run/eval"

# Another run is at work there: said before anything is read.
cp -r "$here/run" "$here/busy"
rm "$here/busy/config.json"
refuses 'another palmar train is at work' flock "$here/busy" \
    ./palmar train --config hocat-tiny --out "$here/busy" --resume --quiet

# A disk without room ends with 4 and says so, and its lines are written once there is room: the file may grow no further.
trains "$here/full" --set optim.steps=1
(
    ulimit -f 1
    trains "$here/full" --resume --set optim.steps=40 --set train.checkpoint_steps=0 2>"$here/err" && code=0 || code=$?
    if [ "$code" != 4 ] || ! grep -q 'File too large' "$here/err"; then
        echo "full disk: exit $code, wanted 4:"
        cat "$here/err"
        exit 1
    fi
)

# ends COMMAND...: with 143, soon after SIGTERM, and nothing half written
ends()
{
    "$@" >/dev/null 2>&1 &
    pid=$!
    sleep 1
    kill -TERM $pid
    (sleep 20 && kill -KILL $pid 2>/dev/null) &
    wait $pid && code=0 || code=$?
    kill $! 2>/dev/null || true
    [ "$code" = 143 ] || {
        echo "$*: exit $code after SIGTERM, wanted 143"
        exit 1
    }
    [ -z "$(find "$here" -name '*.tmp')" ] || {
        echo "$* left $(find "$here" -name '*.tmp')"
        exit 1
    }
}

ends ./palmar synth --preset default --out "$here/large"
ends ./palmar bench --model hocat --variant full --runs 10000
ends ./palmar train --config hocat-tiny --data "$data" --out "$here/long" --quiet
rm -rf "$here"
