#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Scenes that move over 1, 2, 3, 4, 5 and 8 ranks: the state hash of `duet run`, checkpoints of the same bytes, and
# what 3 ranks saved half way gone on with by 5 and by 1. Prints a table, and fails at the first that differs.
#
#   same_bits.sh DUET [--all]    with --all as many bodies and steps as a pile needs to fall
set -euo pipefail
duet=$1
all=${2:-}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"

write_scenes() {
  cat >giant.lua <<'LUA'
-- A heap below a box as wide as the world, which touches all of it.
for i = 0, 99 do
  add { centre = { i % 10, i // 10, 0.45 }, half_extents = { 0.4, 0.4, 0.4 } }
end
add { centre = { 4.5, 4.5, 1.9 }, half_extents = { 5.5, 5.5, 1 }, mass = 40 }
return {
  dims = 3, gravity = { 0, 0, -9.81 }, boundary = "walls", body = { friction = 0.5, restitution = 0.3 },
  world = { lower = { -2, -2, 0 }, upper = { 12, 12, 20 } },
}
LUA
  cat >masses.lua <<'LUA'
-- Light and heavy bodies of unequal sizes, 1 to 1000.
local p = parameters { n = 300 }
for i = 0, p.n - 1 do
  local h = 0.2 + 0.25 * (i * 7 % 5) / 4
  add { centre = { 1.05 * (i % 8), 1.05 * (i // 8 % 6), 0.6 + 1.1 * (i // 48) }, half_extents = { h, h, 0.5 * h + 0.1 },
        mass = 10 ^ (i * 5 % 4), velocity = { 0.3 * (i % 3), 0, 0 } }
end
return {
  dims = 3, gravity = { 0, 0, -9.81 }, boundary = "walls", body = { friction = 0.4, restitution = 0.2 },
  world = { lower = { -1, -1, 0 }, upper = { 9, 7, 60 } },
}
LUA
  cat >skin.lua <<'LUA'
-- Piles that fall asleep, with a skin, and are hit by one that is late.
local p = parameters { n = 120 }
for i = 0, p.n - 1 do
  add { centre = { 1.5 * (i % 10), 1.5 * (i // 10 % 4), 0.5 + 1.01 * (i // 40) }, half_extents = { 0.5, 0.5, 0.5 } }
end
add { centre = { 3, 1.5, 30 }, half_extents = { 0.6, 0.6, 0.6 }, mass = 5 }
return {
  dims = 3, gravity = { 0, 0, -9.81 }, boundary = "walls", body = { friction = 0.6 }, skin = 0.1,
  wants = { "contact_response", "sleep" }, world = { lower = { -2, -2, 0 }, upper = { 16, 8, 40 } },
}
LUA
}

fail() {
  echo "$1" >&2
  cat says >&2 2>/dev/null || true
  exit 1
}

hash_of() { # what `duet ARGUMENTS --json` says
  "$duet" "$@" --json >out 2>says || fail "duet $*: exit status $?"
  sed -n 's/.*"hash":[[:space:]]*"\([0-9a-f]*\)".*/\1/p' out | head -n 1
}

must_be() { # HASH HASH WHAT
  [ -n "$1" ] && [ "$1" = "$2" ] || fail "$3: state hash $1, and one motion's is $2"
}

compare() { # NAME STEPS ARGUMENTS...: a row of the table
  local name=$1 steps=$2 one half=$(($2 / 2)) ranks
  shift 2
  one=$(hash_of run "$@" --steps "$steps")
  for ranks in 1 2 3 4 5 8; do
    must_be "$(hash_of cluster --ranks $ranks "$@" --steps "$steps" --checkpoint $ranks.ck)" "$one" "$name on $ranks ranks"
    cmp 1.ck $ranks.ck || fail "$name: another checkpoint on $ranks ranks"
  done
  hash_of cluster --ranks 3 "$@" --steps $half --checkpoint half.ck >half
  for ranks in 5 1; do
    must_be "$(hash_of cluster --ranks $ranks "$@" --steps "$steps" --resume half.ck)" "$one" \
      "$name, saved on 3 and gone on with on $ranks ranks"
  done
  printf '%-16s %6s steps  %s  same on 1 2 3 4 5 8, checkpoints equal, 3 to 5 and to 1\n' "$name" "$steps" "$one"
}

write_scenes
compare orbit2d 40 orbit2d -n 500
compare bullets 60 bullets
compare 'mixed masses' 60 masses.lua
compare 'sleep and skin' "$([ "$all" ] && echo 400 || echo 40)" skin.lua
compare giant 40 giant.lua
[ -z "$all" ] || compare 'falling 20 000' 200 falling -n 20000
