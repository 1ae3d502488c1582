#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# bench measures whatever it says it can, and refuses the rest with one line. Times are not looked at.
set -eu

# bench ARGS: as little of it as there is
bench()
{
    ./palmar bench --runs 3 --seconds 0 --threads 1 "$@"
}

# refuses CODE PATTERN ARGS
refuses()
{
    want=$1 pattern=$2
    shift 2
    line=$(bench "$@" 2>&1 >/dev/null) && code=0 || code=$?
    [ "$code" = "$want" ] && printf '%s\n' "$line" | grep -q -e "$pattern" && return
    echo "bench $*: exit $code: $line"
    exit 1
}

layers=$(./palmar bench --help | sed -n '/^Layers/,$s/^  \([a-z0-9_]*\)\(:.*\)*$/\1/p')
[ -n "$layers" ]
for layer in $layers; do
    case $layer in
    conv2d) keys=c=64,o=64,k=3,stride=2,groups=64,hw=8 ;;
    linear) keys=c=128,o=128,rows=2 ;;
    attention) keys=tokens=5,c=6,heads=2 ;;
    layer_norm) keys=c=16,rows=3 ;;
    batch_norm) keys=c=16,hw=4 ;;
    roi_align) keys=c=3,hw=8,out=4 ;;
    *) keys= ;;
    esac
    bench --layer "$layer:$keys" --mode both --batch 2 --json >/dev/null
done

bench --layer linear:c=512,o=512,rows=1 --compare generic | grep -q '[1-9][0-9.]* times as fast as generic'
bench --layer linear:c=512,o=512,rows=1 --compare generic --json | grep -q '"with": "generic", "ratio_of_medians": [0-9]'
bench --model resnet50 --set model.image_size=32 --set model.width=8 --mode both | grep -q '^| resnet50 '
bench --model efficientnet_b0 --set model.image_size=32 --mode both | grep -q '^| efficientnet_b0 '
bench --model pointnet2 --set model.points=64 --mode both | grep -q '^| pointnet2 | sa1 '
bench --model gpm --variant cpu --set model.points=64 --mode both | grep -q '^| gpm | cpu '
bench --model vit --variant tiny --mode both | grep -q '^| vit | tiny '
bench --model csp_seg --set model.image_size=64 --batch 2 --mode both | grep -q '^| csp_seg | n '
bench --model csp_seg --set model.image_size=64 --post --json | grep -q '"post_ms": [0-9.e-]*, "with_post_ms"'
bench --model reid --set model.identities=5 --batch 3 --mode both | grep -q '^| reid | cosine '
bench --model reid --post | grep -q '^bookkeeping of 20 tracks: [0-9.]* ms more'
bench --model lpips --set model.image_size=40 --batch 2 --mode both | grep -q '^| lpips '

# One image or three; training draws what inference does. NumPy's known scene has so many instances.
for sets in false true; do
    splat=$(bench --model splat --set model.gaussians=1000 --set model.sets=$sets --mode both --json)
    [ "$(echo "$splat" | sed 's/.*"crc32": "\([0-9a-f]*\)".*/\1/' | sort -u | wc -l)" = 1 ]
done
bench --model splat --json | grep -q '"instances": 32430, "crc32": "[0-9a-f]\{8\}"}'

refuses 2 'no such layer "conv2"; did you mean "conv2d"' --layer conv2
refuses 2 'conv2d.kk: no such key; did you mean "k"' --layer conv2d:kk=3
refuses 2 'conv2d.hw: ' --layer conv2d:hw=0
refuses 1 'input has 3 channels' --layer conv2d:c=3,groups=2
refuses 2 'found "hw", want key=value' --layer conv2d:hw
refuses 2 '--layer: found "=3", want key=value' --layer conv2d:=3
refuses 2 '--compare: ' --layer hand --compare sse
refuses 2 'are for models' --layer hand --model hocat
int8=$(bench --model resnet50 --set model.image_size=64 --set model.width=32 --int8 --profile)
echo "$int8" | grep -q '^53 of 53 layers read 8-bit integers'
echo "$int8" | grep -q 'forward conv2d .* int8 '
