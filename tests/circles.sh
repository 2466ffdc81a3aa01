#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# No files of a module call each other in a circle. A file is x.c with its x.h: object files say who
# calls what, and the sources who calls an inline function of a header.
#
#   circles.sh SOURCES MODULES
#
# MODULES has a line for each module: its name and its objects, these with commas.
set -euo pipefail
export LC_ALL=C
cd "$1"
modules=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# Lines "USER MAKER NAME", with files without their end. Objects lie at NAME.dir/SOURCE.o.
called_by_objects() { # OBJECT ...
  nm -A "$@" | awk '{
    file = $0; sub(/\.c\.o:.*/, "", file); sub(/.*\.dir\/(\.\/)?/, "", file)
    if ($(NF - 1) ~ /^[TDBRC]$/) maker[$NF] = file
    if ($(NF - 1) == "U") { user[++n] = file; name[n] = $NF }
  } END {
    for (i = 1; i <= n; ++i)
      if (name[i] in maker) print user[i], maker[name[i]], name[i]
  }'
}

called_of_headers() { # FILE ...
  awk '{ sub(/\/\/.*/, ""); gsub(/"([^"\\]|\\.)*"/, ""); gsub(/(->|\.) *[A-Za-z_][A-Za-z_0-9]*/, "")
    file = FILENAME; sub(/\.[ch]$/, "", file)
    while (match($0, /[A-Za-z_][A-Za-z_0-9]*\(/)) {
      called = substr($0, RSTART, RLENGTH - 1)
      if (/^static inline /) maker[called] = file
      else { user[++n] = file; name[n] = called }
      $0 = substr($0, RSTART + RLENGTH)
    }
  } END {
    for (i = 1; i <= n; ++i)
      if (name[i] in maker && user[i] != maker[name[i]]) print user[i], maker[name[i]], name[i]
  }' "$@"
}

# The files of the first circle that tsort tells of, and what ties them.
say_circle() { # CALLS
  awk '/loop:/ { if (seen++) exit; next } { print $NF }' "$work/says" >"$work/circle"
  awk 'FNR == NR { in_circle[$1] = 1; next }
    $1 in in_circle && $2 in in_circle && $1 != $2 { print "  " $1 " -> " $2 ": " $3 }' \
    "$work/circle" "$1" | sort -u
}

while IFS='|' read -r name objects; do
  IFS=, read -ra own <<<"$objects"
  mapfile -t files < <(printf '%s\n' "${own[@]}" | sed -E 's|.*\.dir/(\./)?||; s|/[^/]*$||' | sort -u |
    xargs -I {} find {} -maxdepth 1 -name '*.[ch]' 2>/dev/null)
  { called_by_objects "${own[@]}" && called_of_headers "${files[@]}"; } >"$work/calls"
  if ! awk '{ print $1, $2 }' "$work/calls" | tsort >"$work/order" 2>"$work/says"; then
    echo "files of $name call each other in a circle:" && say_circle "$work/calls"
    exit 1
  fi
done <"$modules"
