#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# What bash offers, as a person presses Tab; and that man reads every page.
#
#   FOLDER  with the man pages and duet.bash
set -uo pipefail
folder=$1
wrong=0
source "$folder/duet.bash"

# offers WORD... -- EXPECTED: the last WORD is the one that is being typed.
offers() {
  COMP_WORDS=()
  while [ "$1" != -- ]; do COMP_WORDS+=("$1"); shift; done
  COMP_CWORD=$((${#COMP_WORDS[@]} - 1))
  COMPREPLY=()
  _duet
  [ "${COMPREPLY[*]}" = "$2" ] && return
  echo "'${COMP_WORDS[*]}' offers '${COMPREPLY[*]}', not '$2'" >&2
  wrong=1
}
offers duet tu -- tune
offers duet run --sha -- --share
offers duet run scene.lua --pairs out.csv --mo -- --mode
offers duet run sce -- ""
offers duet profiles ex -- export
offers duet profiles list --de -- --dead
offers duet abacus --x -- ""

for page in "$folder"/*.1; do
  if command -v groff >/dev/null; then
    said=$(groff -man -ww -z "$page" 2>&1)
    [ -z "$said" ] || { echo "$page: $said" >&2; wrong=1; }
  fi
done
for command in run tune report profiles-why; do
  grep -q '^\.SH SYNOPSIS' "$folder/duet-$command.1" || wrong=1
done
grep -q 'DUET_PROFILE' "$folder/duet.1" || wrong=1
exit $wrong
