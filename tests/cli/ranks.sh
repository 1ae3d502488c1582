#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Processes that train together: the same bits as one alone; found before they begin, where they cannot. Without Open MPI
# or MPICH only the line that says so.
set -eu
here=tests/cli/ranks.dir
rm -rf "$here"
mkdir "$here"

if [ ! -f ranks-mpi.so ] || ! command -v mpirun >/dev/null; then
    line=$(PMI_SIZE=2 ./palmar train --config hocat-tiny --data "$here" --out "$here/run" 2>&1) && code=0 || code=$?
    [ "$code" = 1 ] && printf '%s' "$line" | grep -q '2 processes were started together, and MPI is not there' && exit 0
    echo "without MPI: exit $code: $line"
    exit 1
fi
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
export OMPI_MCA_rmaps_base_oversubscribe=1 OMPI_MCA_mpi_yield_when_idle=1

# trains N NAME OPTIONS: so many processes, in a run of this name
trains()
{
    n=$1 name=$2
    shift 2
    mpirun -n "$n" ./palmar train --config hocat-tiny --data "$here/data" --out "$here/$name" --threads 1 -q \
        --set optim.steps=8 --set optim.shards=4 "$@" >"$here/said.txt" 2>&1
}

./palmar synth --preset tiny --out "$here/data" >/dev/null 2>&1
for n in 1 2 3; do
    trains "$n" "run$n" || { cat "$here/said.txt"; exit 1; }
    cmp "$here/run1/checkpoints/last.safetensors" "$here/run$n/checkpoints/last.safetensors"
done
grep -q '"ranks":[[:space:]]*3' "$here/run3/env.json"
if trains 3 few --set optim.shards=2; then
    echo "three processes trained on two shards"
    exit 1
fi
grep -q 'palmar: \[rank [0-2]\] 3 ranks, and optim.shards is 2: some ranks would have nothing to do' "$here/said.txt"
[ ! -e "$here/few" ]
rm -r "$here"
