#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Files of weights and of hands as people bring them (scripts/vectors/field_weights.py made ours): read as they are
# meant, or refused by a line that says what they are. What is in ../shared/field is tried too where that is there.
set -eu
here=tests/field/weights.dir
own=${srcdir:?}/tests/field/weights
rm -rf "$here"
mkdir -p "$here"

# says CODE WORDS ARGUMENTS: the command ends with the code, and one line that it prints has the words
says()
{
    code=$1 words=$2
    shift 2
    got=0
    ./palmar "$@" >"$here/said.txt" 2>&1 || got=$?
    if [ "$got" != "$code" ] || ! grep -q -e "$words" "$here/said.txt"; then
        echo "palmar $*: code $got, want $code and \"$words\":"
        cat "$here/said.txt"
        exit 1
    fi
}

# loads N FROM FILE: of FILE so many parameters of a ResNet-50, from behind these words
loads()
{
    ./palmar info --model resnet50 --init "$3" --json >"$here/init.json" 2>"$here/said.txt" || {
        cat "$here/said.txt"
        exit 1
    }
    grep -q "\"taken from\": \"$2\".*\"loaded\": $1," "$here/init.json" || {
        echo "$3: want $1 loaded from behind \"$2\":"
        grep -o '"init": {.*"not in it"' "$here/init.json"
        exit 1
    }
}

# refuses WORDS FILE: as initial weights
refuses()
{
    says 1 "$1" info --model resnet50 --init "$2"
}

# ---- whatever stands around the weights

loads 1 state_dict.net.encoder. "$own/lightning.ckpt"
loads 1 state_dict.module.encoder_q. "$own/two_encoders.pth.tar"
grep -q '"fits as well": \["state_dict.module.encoder_k."\]' "$here/init.json"
loads 4 trunk. "$own/whole_network.pt"
loads 1 1.ema.module._orig_mod. "$own/tuple.pth"
loads 1 bert. "$own/model.safetensors.index.json"
refuses 'none of its 2 arrays has the name of a parameter of resnet50; it has layer.kernel, layer.scale, and wanted' \
    "$own/of_another_network.pth"
refuses '"bn1.weight", which "bn1.weight" wants: dtype "F8_E4M3" is not read' "$own/wanted_in_8_bits.safetensors"
refuses 'cut short, copy or download it again' "$own/cut.pth"
mkdir "$here/alone"
cp "$own/model.safetensors.index.json" "$here/alone"
refuses 'an index, whose files lie in its folder: .*model-00001-of-00002.safetensors: No such file' \
    "$here/alone/model.safetensors.index.json"

# ---- by what a file is, not by its ending

cp "$own/lightning.ckpt" "$here/called.npz"
says 0 'called .npz, and is a checkpoint of PyTorch' info "$here/called.npz"
says 0 '"hyper_parameters": an object of my.training.Plan, which stays closed' info "$own/lightning.ckpt"
./palmar info --json "$own/lightning.ckpt" | grep -q '"notes": \[{"code": "object_closed", "text": '
says 0 'state_dict.net.encoder.bn1.weight *(64) f4' info "$here/called.npz"
says 0 'bert.scale *not read' info "$own/model.safetensors.index.json"
printf '<!DOCTYPE html><html>sign in</html>' >"$here/resnet50.pth"
for reads in "info $here/resnet50.pth" "predict $here/resnet50.pth x.png" "eval $here/resnet50.pth --data x"; do
    # shellcheck disable=SC2086 # words
    says 1 'an HTML page in the place of a file, want .*; download it again' $reads
done
says 1 'a checkpoint of PyTorch, want one of palmar train; palmar train --init' predict "$own/tuple.pth" x.png
says 1 'a checkpoint of PyTorch, want one of palmar train' eval "$own/whole_network.pt" --data x
says 1 'has weights, but is no checkpoint of palmar train' predict "$own/model-00001-of-00002.safetensors" x.png
says 1 'not safetensors, .npz, .npy, a pickle' info "${srcdir:?}/configure.ac"

# ---- what was handed out with these situations

field=${srcdir:?}/../shared/field
[ -d "$field" ] || exit 0
for file in plain class_config class_anakin_utils_config rng under_ema_state_dict under_model_ema under_weights \
    prefix__orig_mod- prefix_model- prefix_backbone-; do
    loads 1 "[a-z_.]*" "$field/D_$file.pth"
done
loads 1 '' "$field/D_f8_extra.safetensors"
refuses 'an index, whose files lie in its folder' "$field/D_model.safetensors.index.json"
refuses 'cut short' "$field/D_truncated.pth"
says 0 'array *(778, 3) f8' info "$field/E_array.npy"
command -v xz >/dev/null || exit 0
for file in npmatrix.pkl savez_of_dict.npz npz_named.pkl millimetres.pkl; do
    xz -dc "$field/E_$file.xz" >"$here/$file"
done
for file in npmatrix.pkl savez_of_dict.npz npz_named.pkl; do
    says 0 'hand model *complete' info "$here/$file"
done
says 0 '"v_template" spans 184, and a hand some 0.2 metres: in millimetres?' info "$here/millimetres.pkl"
says 1 '"v_template" spans 184, and a hand some 0.2 metres: in millimetres?' info --data "$here" \
    --hand "$here/millimetres.pkl"
