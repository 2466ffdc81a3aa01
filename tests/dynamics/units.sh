#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# A motion on 1, 2, 3, 8 and 19 units of a CPU, most of them more than there are cores: the hash of
# its state is the same, step by step where boxes crash, bounce and roll.
#
#   units.sh DUET
#
# Units are threads of PoCL. Exit 77 without it.
set -euo pipefail

duet=$1
"$duet" devices --json | grep -q '"pocl:0"' || { echo "skipped: no PoCL"; exit 77; }

state() { # UNITS SCENE...
  local units=$1
  shift
  POCL_CPU_MAX_CU_COUNT=$units POCL_MAX_PTHREAD_COUNT=$units \
    "$duet" run "$@" --pair pocl:0 --json | grep '"hash"'
}

for scene in 'falling -n 1500 --steps 90' 'marbles -n 1000 --steps 60' 'grains -n 800 --steps 40'; do
  read -ra words <<<"$scene"
  expected=$(state 1 "${words[@]}")
  for units in 2 3 8 19; do
    got=$(state "$units" "${words[@]}")
    [ "$got" = "$expected" ] || { echo "$scene: $units units:$got; expected$expected"; exit 1; }
  done
done
