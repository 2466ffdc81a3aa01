#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Duet beside other engines: all rows of docs/performance.md in one run.
#
#   tests/bench/peers/table.sh DUET DIR OUT [PART]...
#
# DUET is the program, DIR holds the engines' (CMakeLists.txt beside this file). Appends to OUT/table.txt what each
# row's script prints, once it is done. Parts, all by default:
#
#   many   piles of Duet and Box3D on 16, 4 and 1 cores, one program at a time, the engines in turn; with other
#          parts to come, in no more than 0.55 of the time. The largest on one core takes so long that it is in `one`
#   one    still boxes, other piles, worlds and stacks; each program on one core, JOBS of them beside each other
#   gpu    still boxes on NVIDIA's GPU, if there is one
#   jolt   piles of Jolt on 16 and 4 cores
#
# What LIMIT seconds (265) do not suffice for is left out, and the table says so. LONG=1 takes the steps of the tables
# in docs; give it a LIMIT of 1200. JOBS is half of the cores and two more; THREADS are numbers of cores beside 1, and
# 4,16 by default; SCALE below 1 makes all but stacks smaller, to try the script.
set -u

if [ $# -lt 3 ]; then
    echo "give DUET DIR OUT [PART]..." >&2
    exit 2
fi
duet=$(realpath "$1") dir=$(realpath "$2") out=$3
shift 3
parts=${*:-many one gpu jolt}
here=$(cd "$(dirname "$0")" && pwd)
cores=$(nproc)
jobs=${JOBS:-$((cores / 2 + 2))} scale=${SCALE:-1} limit=${LIMIT:-265}
declare -A steps
if [ -n "${LONG:-}" ]; then
    steps=([1000]=1 [5000]=600 [20000]=420 [100000]=150) world_limit=120 runs=5
else
    steps=([1000]=1 [5000]=300 [20000]=150 [100000]=100) world_limit=45 runs=3
fi
threads=
for count in $(echo "${THREADS:-4,16}" | tr , ' '); do
    [ "$count" -gt "$cores" ] || threads="$count $threads"
done
mkdir -p "$out"
table=$(cd "$out" && pwd)/table.txt
work=$(mktemp -d)
trap 'rm -r "$work"' EXIT

scaled() { if [ "$scale" = 1 ]; then echo "$1"; else awk "BEGIN { print int($1 * $scale) }"; fi; }

# row NAME SCRIPT ARGUMENT...: runs one of the three below while time is left, and appends what it says to the table.
row() {
    local name=$1 left=$((limit - SECONDS)) begun=$SECONDS status said command
    shift
    "$@"
    if [ "$left" -lt 5 ]; then
        echo "== $name: left out, no time" >>"$table"
        return
    fi
    said=$(mktemp -p "$work")
    timeout -k 5 "$left" "${command[@]}" >"$said" 2>&1 </dev/null
    status=$?
    echo "== $name ($((SECONDS - begun)) s$([ $status = 0 ] || echo ", failed: $status"))" >"$said.row"
    cat "$said" >>"$said.row"
    cat "$said.row" >>"$table"
}

# aside NAME SCRIPT ARGUMENT...: a row on one core, once one of the places is free.
aside() {
    while [ "$(jobs -rp | wc -l)" -ge "$jobs" ]; do wait -n; done
    POCL_CPU_MAX_CU_COUNT=1 POCL_MAX_PTHREAD_COUNT=1 row "$@" &
}

script() { command=("$duet" lua --trust "$here/$1.lua" "${@:2}"); }

pile() { # ENGINES THREADS N
    script piles "$dir" "$(scaled "$3")" "${steps[$3]}" 1 "$1" "$2"
}

world() { script worlds "$dir" "$scale" "$1" "$world_limit" "$2"; } # ENGINE SCENES

part_many() {
    local n count all=$limit
    [ "$parts" = many ] || limit=$((limit * 55 / 100))
    for count in $threads 1; do
        aside "kernels for $count cores" pile duet "$count" 1000
    done
    wait
    for n in 20000 5000 100000; do
        for count in $threads 1; do # what takes least time first
            [ "$n $count" = "100000 1" ] || row "pile of $n on $count cores" pile duet,box3d "$count" $n
        done
    done
    limit=$all
}

# The longest first.
part_one() {
    local engine
    aside "pile of 20000, jolt" pile jolt 1 20000
    aside "worlds 4 to 8, duet" world duet 4,5,6,7,8
    aside "pile of 100000, bullet" pile bullet 1 100000
    aside "pile of 20000, bullet" pile bullet 1 20000
    aside "pile of 100000, jolt" pile jolt 1 100000
    aside "pile of 100000, box3d" pile box3d 1 100000
    aside "pile of 100000, duet" pile duet 1 100000
    aside "still, on one core" script still "$dir" "$(scaled 1000000)" $runs
    for engine in duet jolt box3d bullet; do
        aside "world 3, $engine" world $engine 3
        aside "world 1, $engine" world $engine 1
        aside "world 2, $engine" world $engine 2
        aside "stacks, $engine" script stacks "$dir" $engine
    done
    aside "pile of 5000, bullet" pile bullet 1 5000
    aside "pile of 5000, jolt" pile jolt 1 5000
    for engine in box3d jolt bullet; do
        aside "worlds 4 to 8, $engine" world $engine 4,5,6,7,8
    done
    wait
}

part_gpu() {
    if "$duet" devices 2>/dev/null | grep -q '^nvidia:0'; then
        row "still, on a GPU" script still "$dir" "$(scaled 1000000)" 9 gpu NVIDIA
    fi
}

part_jolt() {
    local n count
    for n in 20000 5000 100000; do
        for count in $threads; do
            row "pile of $n on $count cores, jolt" pile jolt "$count" $n
        done
    done
}

{
    "$duet" --version
    date -u
    grep -m 1 'model name' /proc/cpuinfo
    echo "$cores cores, $jobs programs beside each other, scale $scale"
} >>"$table"
for part in $parts; do "part_$part"; done
echo "== all: $SECONDS s" >>"$table"
