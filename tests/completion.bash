#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# What bash offers, as a person presses Tab; and that man reads every page.
#
#   FOLDER  with the man pages and duet.bash
set -uo pipefail
folder=$1
wrong=0
source "$folder/duet.bash"

# What these two say here; the devices and profiles of a machine differ.
duet() {
  case "$1" in
    devices) printf 'pocl:0  a CPU\n   kind  CPU\nnvidia:0  a GPU\n\nwithout --pair: pocl:0,nvidia:0\n' ;;
    profiles) printf 'profile   scene\nf13c9469  paper\nA: a CPU\n' ;;
  esac
}

# offers LINE -- EXPECTED: the last word of the line is the one that is being typed.
offers() {
  COMP_LINE=$1
  COMP_POINT=${#COMP_LINE}
  COMPREPLY=()
  _duet
  [ "${COMPREPLY[*]}" = "$3" ] && return
  echo "'$1' offers '${COMPREPLY[*]}', not '$3'" >&2
  wrong=1
}
offers 'duet tu' -- tune
offers 'duet --v' -- --version
offers 'duet run --sha' -- --share
offers 'duet run scene.lua --pairs out.csv --mo' -- --mode
offers 'duet run --pairs out' -- ''
offers 'duet run no/such/fi' -- ''
offers 'duet profiles ex' -- export
offers 'duet profiles list --de' -- --dead
offers 'duet abacus --x' -- ''

# Values: of the help texts, of the program, of the machine.
offers 'duet run x.lua --mode s' -- 'shared slab'
offers 'duet run x.lua --level sat' -- 'sat6 sat15'
offers 'duet run x.lua --level=sat1' -- 'sat15'
offers 'duet run x.lua --variant-b s' -- simd
offers 'duet tune x.lua --level certified,sat' -- 'certified,sat6 certified,sat15'
offers 'duet tune --strategy f' -- fig12
offers 'duet bench --scene pl' -- planes
offers 'duet run x.lua --pair n' -- 'nvidia:0'
offers 'duet run x.lua --pair h' -- 'halves'
offers 'duet verify x.lua --other-pair h' -- 'halves'
offers 'duet verify x.lua --other-mode s' -- 'shared slab'
offers 'duet run x.lua --pair pocl:0,n' -- '0,nvidia:0'
offers 'duet query --device nvidia:' -- '0'
offers 'duet run pape' -- 'paper paper2d'
offers 'duet source radi' -- radix
offers 'duet profiles show f' -- f13c9469

for page in "$folder"/*.1; do
  said=
  command -v groff >/dev/null && said+=$(groff -man -ww -z "$page" 2>&1)
  command -v mandoc >/dev/null && said+=$(mandoc -Tlint -Wwarning "$page" 2>&1)
  [ -z "$said" ] || { echo "$page: $said" >&2; wrong=1; }
  for section in NAME SYNOPSIS DESCRIPTION ENVIRONMENT 'EXIT STATUS' 'SEE ALSO'; do
    grep -q "^\.SH $section" "$page" || { echo "$page has no $section" >&2; wrong=1; }
  done
done
# has PAGE TEXT: in what man shows, in which a space may be a line's end.
has() {
  local shown
  shown=$(sed -e 's/\\f[BIR]//g; s/\\-/-/g; s/\\(aq/'"'"'/g' "$folder/$1.1" | tr '\n' ' ')
  [[ $shown == *"$2"* ]] || { echo "$1.1 lacks '$2'" >&2; wrong=1; }
}
has duet '.SH SYNOPSIS duet SUBCOMMAND [arguments]'
has duet '.TP DUET_PROFILE the profile file'
has duet '.BR duet-tune (1)'
has duet-run '.SH SYNOPSIS duet run [SCENE|FILE] [options]'
has duet-run '.TP --share R'
has duet-run 'duet run lua/scenes/mixed.lua --pair halves --share 1/4 --check'
has duet-profiles-why '.BR duet-profiles (1)'
has duet-lua 'lua_history'
exit $wrong
