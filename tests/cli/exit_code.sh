#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# What the exit code says: 2 when the command's words are wrong, 1 when what they name is.
set -eu

# ends CODE PATTERN COMMAND ARGS: with that code, one line of error that has PATTERN, and nothing on stdout
ends()
{
    want=$1 pattern=$2
    shift 2
    out=$(./palmar "$@" 2>exit_code.err) && code=0 || code=$?
    line=$(cat exit_code.err)
    rm exit_code.err
    [ "$code" = "$want" ] && [ -z "$out" ] && printf '%s\n' "$line" | head -n 1 | grep -q -e "$pattern" && return
    echo "palmar $*: exit $code, wanted $want: $out$line"
    exit 1
}

# trains CODE PATTERN ARGS: a training that ends so before it begins
trains()
{
    code=$1 pattern=$2
    shift 2
    ends "$code" "$pattern" train --config hocat-tiny --out exit_code.dir --dry-run "$@"
}

ends 2 'no such command "trian"; did you mean "train"' trian
ends 2 '--export: found "coco,yolo", want coco, bop or coco,bop' synth --preset world --export coco,yolo --out d
ends 2 '--seconds and --export are for --preset world' synth --export coco --out d
trains 2 '--set optim.lrr: no such key; did you mean "lr"' --set optim.lrr=1
trains 2 '--set optim.lr: found "fast"' --set optim.lr=fast
trains 2 '--set optm: no such group' --set optm.lr=1
trains 2 '--set optim: want key=value' --set optim
trains 2 'data.dir: no dataset given'
trains 1 'nowhere' --data nowhere
ends 2 '--set model.widht: no such key; did you mean "width"' info --model hocat --set model.widht=3
ends 2 '--set model.width: -3 is not between' info --model hocat --set model.width=-3
ends 2 '--set model.name: no such model "hokat"; did you mean "hocat"' bench --config hocat-tiny --set model.name=hokat
ends 2 '--set optim.lr=3: want model.KEY=VALUE' info --model hocat --set optim.lr=3
ends 2 '--set model.variant: no such choice "fulll"' info --model hocat --variant fulll
ends 2 '--model: no such model "resnet51"; did you mean "resnet50"' info --model resnet51
ends 2 'a config of hocat, but --model is unified' bench --config hocat-tiny --model unified
ends 1 'nowhere' info nowhere
ends 1 'nowhere' eval nowhere --data nowhere
ends 1 'nowhere' report nowhere
ends 2 '--require pa_mpjp_mm: no such key; did you mean "pa_mpjpe_mm"' eval nowhere --require 'pa_mpjp_mm<=9'
ends 2 '--require bop_ar: is not scored here' eval nowhere \
    --require 'bop_ar<=9'
ends 2 'want KEY>=X or KEY<=X' eval nowhere --require 'pa_mpjpe_mm<9'

# What reads a crop takes no other model.
rm -rf exit_code.points
./palmar train --config points-cpu --out exit_code.points --quiet --set optim.steps=1 --set optim.batch=2 \
    --set data.shapes=0 --set data.held_out=2
other='points is trained for point-pairs, want a model for hand-object'
ends 1 "$other" eval exit_code.points --data nowhere
ends 1 'no ONNX form of "farthest_point_sampling"' export exit_code.points --out nowhere.onnx
ends 1 "$other" predict exit_code.points nowhere
rm -r exit_code.points
