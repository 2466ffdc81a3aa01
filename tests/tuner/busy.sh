#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Tunings of two halves of a CPU while 0, 1 and 2 other programs burn a core each:
#
#   busy.sh DUET [TUNINGS] [WAIT]
#
# Each must find a share of .50 +- .03 in mode slab, or say `ambiguous` and the cause: other
# programs, both parts on one core, or times that vary. A tuning on the busy machine must leave the profile of the quiet one in use. All
# runs on two cores. Exit 77 if these are not there, or not quiet at the start.
set -euo pipefail

duet=$1 tunings=${2:-20} wait=${3:-10}
folder=$(mktemp -d)
burners=()
finish() {
  [ "${#burners[@]}" -eq 0 ] || kill "${burners[@]}" 2>/dev/null || true
  rm -rf "$folder"
}
trap finish EXIT
[ "$(nproc)" -ge 2 ] || { echo "skipped: one core"; exit 77; }
export POCL_CPU_MAX_CU_COUNT=2 # PoCL from 5 on; before, it has as many threads as the machine has cores
unset DUET_WAIT

tune() { # STORE [OPTION...]
  local store=$1
  shift
  taskset -c 0,1 "$duet" tune paper -n 100000 --pair halves --profile "$store" --json "$@"
}

field() { # NAME FILE
  grep -o "\"$1\":[^,}]*" "$2" | head -n 1 | cut -d: -f2 | tr -d ' "\t'
}

live() { # STORE
  "$duet" profiles list --profile "$1" --json | grep -o '"uid":[^,]*' | sort
}

failed=0
for n in 0 1 2; do
  burners=()
  for ((i = 0; i < n; ++i)); do
    taskset -c 0,1 bash -c 'while :; do :; done' &
    burners+=($!)
  done
  right=0 ambiguous=0
  for ((k = 0; k < tunings; ++k)); do
    rm -f "$folder"/a.db*
    tune "$folder/a.db" --wait "$wait" >"$folder/out" 2>"$folder/err"
    verdict=$(field verdict "$folder/out") unused=$(field unused "$folder/out")
    if [ "$verdict" = faster ] && [ "$(field mode "$folder/out")" = slab ] &&
      awk -v s="$(field share "$folder/out")" 'BEGIN { exit !(s >= .47 && s <= .53) }'; then
      right=$((right + 1))
    elif [ "$verdict" = ambiguous ] && [[ $unused == otherprograms* || $unused == bothpartswere* ||
      $unused == timesvary* ]]; then
      ambiguous=$((ambiguous + 1))
    else
      failed=1
      echo "wrong beside $n programs: $(tr -d '\n\t' <"$folder/out")"
    fi
  done
  echo "$n programs: $right of $tunings right, $ambiguous ambiguous with the cause"
  if [ "$n" -eq 0 ]; then
    [ "$right" -gt 0 ] || { echo "skipped: the machine is not quiet"; exit 77; }
    until tune "$folder/quiet.db" --wait "$wait" >"$folder/out" 2>&1 &&
      [ "$(field verdict "$folder/out")" = faster ]; do sleep 1; done
    quiet=$(live "$folder/quiet.db")
  else
    tune "$folder/quiet.db" --wait 1 --fresh >/dev/null 2>&1
    tune "$folder/quiet.db" --wait 0 --fresh >/dev/null 2>&1
    [ "$(live "$folder/quiet.db")" = "$quiet" ] || {
      failed=1
      echo "beside $n programs the quiet profile was replaced"
    }
  fi
  [ "$n" -eq 0 ] || kill "${burners[@]}"
  [ "$n" -eq 0 ] || wait "${burners[@]}" 2>/dev/null || true
done
exit "$failed"
