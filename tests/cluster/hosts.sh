#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Four machines that are network namespaces of this one, on a switch that is a fifth: a cluster
# finds one machine's pairs, tells of a rank that is stopped, and ends with a line where a rank is
# killed or a cable is pulled.
# Skipped (77) where that is not permitted.
#
#   hosts.sh DUET [--all]    with --all a cable is pulled, too, which takes some seconds to be noticed
set -euo pipefail
duet=$1
tag=duet-$$
names=(one two three four)
work=$(mktemp -d)

pull_down() {
  for name in "${names[@]}" switch; do
    ip netns pids "$tag-$name" 2>/dev/null | xargs -r kill -9 2>/dev/null || true
    ip netns del "$tag-$name" 2>/dev/null || true
  done
  rm -rf "$work"
}
trap pull_down EXIT

put_up() {
  ip netns add "$tag-switch" || return
  ip -n "$tag-switch" link add name lan type bridge || return
  ip -n "$tag-switch" link set lan up || return
  local n=0
  for name in "${names[@]}"; do
    n=$((n + 1))
    ip netns add "$tag-$name" || return
    ip link add name eth0 netns "$tag-$name" type veth peer name "$name" netns "$tag-switch" || return
    ip -n "$tag-switch" link set "$name" master lan up || return
    ip -n "$tag-$name" addr add "10.77.0.$n/24" dev eth0 || return
    ip -n "$tag-$name" link set eth0 up || return
    ip -n "$tag-$name" link set lo up || return
  done
  # What mpirun calls in the place of ssh: HOST COMMAND...
  # shellcheck disable=SC2016
  printf '%s\n' '#!/bin/sh' 'host=$1' 'shift' \
    "exec ip netns exec $tag-\$host unshare --uts sh -c \"hostname \$host; \$*\"" >"$work/enter"
  chmod +x "$work/enter"
  "$work/enter" two true
}

if ! command -v ip >/dev/null; then
  echo "skipped: network namespaces need root, iproute2 and CAP_NET_ADMIN; there is no command ip"
  exit 77
elif ! put_up >/dev/null 2>"$work/says"; then
  echo "skipped: network namespaces need root, iproute2 and CAP_NET_ADMIN; $(head -n 1 "$work/says")"
  exit 77
fi
export OMPI_MCA_plm_rsh_agent=$work/enter PRTE_MCA_plm_ssh_agent=$work/enter # of Open MPI 4 and 5
scene=(paper -n 2000 --set world=25 --plain)

fail() {
  echo "$1"
  cat "$work/out" "$work/err"
  exit 1
}

cluster() { # ARGUMENTS: from machine one
  timeout -k 1 60 "$work/enter" one "$duet cluster --ranks 4 --hosts one,two,three,four ${scene[*]} $*"
}

pairs_are_those_of_one_machine() {
  $duet cluster "${scene[@]}" --repeat 1 --pairs "$work/one.npy" --sorted >"$work/out" 2>"$work/err"
  cluster --repeat 1 --pairs "$work/four.npy" --sorted --json >"$work/out" 2>"$work/err" ||
    fail "four machines fail"
  cmp "$work/one.npy" "$work/four.npy" || fail "other pairs"
  for name in "${names[@]}"; do
    grep -q "\"host\":.*\"$name\"" "$work/out" || fail "no rank on $name"
  done
}

rank_on() { # NAME
  for pid in $(ip netns pids "$tag-$1"); do
    if [ "$(cat "/proc/$pid/comm" 2>/dev/null)" = duet-cluster ]; then echo "$pid"; fi
  done
}

processor_ticks() { # PID: hundredths of a second
  awk '{ print $14 + $15 }' "/proc/$1/stat" 2>/dev/null || true
}

# Starting takes less than half a second of its processor time.
wait_for_steps() {
  local rank ticks
  for _ in $(seq 600); do
    rank=$(rank_on three)
    ticks=$([ -z "$rank" ] || processor_ticks "$rank")
    [ "${ticks:-0}" -lt 50 ] || return 0
    sleep 0.05
  done
}

# A job that would go on for long ends by itself once ACTION is done to machine three.
ends_with_a_line() { # ACTION WORDS
  rm -f "$work"/cut.npy*
  (
    wait_for_steps
    $1
  ) &
  local code=0
  cluster --repeat 100000 --pairs "$work/cut.npy" >"$work/out" 2>"$work/err" || code=$?
  wait
  [ "$code" = 1 ] || fail "exit status $code"
  tail -n 1 "$work/err" | grep -q "$2" || fail "other words than '$2'" # Open MPI's lines come before
  [ ! -s "$work/out" ] || fail "something on stdout"
  ! ls "$work"/cut.npy* >"$work/out" 2>/dev/null || fail "a file is left"
}

says() { # RANK WORDS: within half a minute
  for _ in $(seq 300); do
    ! grep -q "rank [0-3] of 4 (host [a-z]*, pid $1) $2" "$work/err" || return 0
    sleep 0.1
  done
  echo "nobody says '$2' of the rank with pid $1" >>"$work/err"
}

kill_a_rank() {
  kill -9 "$(rank_on three)"
}

# Each is alone on its machine, and the first is rank 0. Then the job is ended.
stop_two_ranks() {
  local rank
  for rank in $(rank_on one) $(rank_on three); do
    kill -STOP "$rank"
    says "$rank" 'has not answered for 2 s'
    kill -CONT "$rank"
    says "$rank" 'answers again'
  done
  kill_a_rank
}

pull_the_cable() {
  ip -n "$tag-switch" link set three down
}

export DUET_RANK_SILENCE=2
pairs_are_those_of_one_machine
# With Open MPI 5 another rank may end the job before the dead one is noticed.
ends_with_a_line kill_a_rank 'a rank was ended by signal 9 (Killed), and with it the job\|a machine may be out of reach'
ends_with_a_line stop_two_ranks 'a rank was ended by signal 9 (Killed), and with it the job\|a machine may be out of reach'
! grep 'nobody says' "$work/err" || fail "a rank that stopped was not told of"
[ "${2:-}" != --all ] || ends_with_a_line pull_the_cable 'a machine may be out of reach'
echo "four machines find the pairs of one, and none outlives another"
