#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Tunings of two halves of a CPU while 0, 1 and 2 other programs burn a core each:
#
#   busy.sh DUET [TUNINGS] [WAIT]
#
# Each must find a share of .50 +- .03 in mode slab, or say `ambiguous` and the cause: other
# programs, both parts on one core, or times that vary. A tuning on the busy machine must leave the
# profile of the quiet one in use. All runs on two cores. If these are not quiet at the start,
# tunings at real-time priority, which no program disturbs, stand for the quiet machine. Exit 77 if
# the system allows none, or there is one core.
set -euo pipefail

duet=$1 tunings=${2:-20} wait=${3:-10}
folder=$(mktemp -d)
burners=()
priority=()
failed=0
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
  ${priority[@]+"${priority[@]}"} taskset -c 0,1 "$duet" tune paper -n 100000 --pair halves \
    --profile "$store" --json "$@"
}

field() { # NAME FILE
  grep -o "\"$1\":[^,}]*" "$2" | head -n 1 | cut -d: -f2 | tr -d ' "\t'
}

live() { # STORE
  "$duet" profiles list --profile "$1" --json | grep -o '"uid":[^,]*' | sort
}

is_right() { # FILE
  [ "$(field verdict "$1")" = faster ] && [ "$(field mode "$1")" = slab ] &&
    awk -v s="$(field share "$1")" 'BEGIN { exit !(s >= .47 && s <= .53) }'
}

is_ambiguous() { # FILE
  local unused
  unused=$(field unused "$1")
  [ "$(field verdict "$1")" = ambiguous ] && [[ $unused == otherprograms* ||
    $unused == bothpartswere* || $unused == timesvary* ]]
}

check_tunings() { # BESIDE: sets `right`
  local k ambiguous=0
  right=0
  for ((k = 0; k < tunings; ++k)); do
    rm -f "$folder"/a.db*
    tune "$folder/a.db" --wait "$wait" >"$folder/out" 2>"$folder/err"
    if is_right "$folder/out"; then
      right=$((right + 1))
    elif is_ambiguous "$folder/out"; then
      ambiguous=$((ambiguous + 1))
    else
      failed=1
      echo "wrong beside $1: $(tr -d '\n\t' <"$folder/out")"
    fi
  done
  echo "$1: $right of $tunings right, $ambiguous ambiguous with the cause"
}

check_tunings "0 programs"
if [ "$right" -eq 0 ]; then
  priority=(chrt -f 1)
  "${priority[@]}" true 2>/dev/null || { echo "skipped: the machine is not quiet"; exit 77; }
  check_tunings "0 programs, at real-time priority"
  [ "$right" -gt 0 ] || exit 1
fi
until tune "$folder/quiet.db" --wait "$wait" >"$folder/out" 2>&1 && is_right "$folder/out"; do sleep 1; done
quiet=$(live "$folder/quiet.db")
priority=()

for n in 1 2; do
  burners=()
  for ((i = 0; i < n; ++i)); do
    taskset -c 0,1 bash -c 'while :; do :; done' &
    burners+=($!)
  done
  check_tunings "$n programs"
  tune "$folder/quiet.db" --wait 1 --fresh >/dev/null 2>&1
  tune "$folder/quiet.db" --wait 0 --fresh >/dev/null 2>&1
  [ "$(live "$folder/quiet.db")" = "$quiet" ] || {
    failed=1
    echo "beside $n programs the quiet profile was replaced"
  }
  kill "${burners[@]}"
  wait "${burners[@]}" 2>/dev/null || true
done
exit "$failed"
