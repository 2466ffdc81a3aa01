#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# What makes a folder a module: a wrong include does not compile, and each module links with
# those below it alone, so that none calls upward.
#
#   modules.sh COMPILER MODULES LIBRARY ...
#
# MODULES has a line for each module, from the lowest up: its name, its include
# folders and its objects, each list with commas.
set -euo pipefail
export LC_ALL=C # the compiler's words are looked at
compiler=$1
modules=$2
shift 2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

includes_of() { # MODULE
  awk -F '|' -v name="$1" '$1 == name { gsub(",", " -I", $2); print "-I" $2 }' "$modules"
}

try_include() { # MODULE HEADER
  echo "#include \"$2\"" >"$work/try.c"
  # shellcheck disable=SC2046 # a list
  "$compiler" -std=c17 -DCL_TARGET_OPENCL_VERSION=120 -fsyntax-only $(includes_of "$1") \
    $(pkg-config --cflags lua5.4 sqlite3 libcjson) "$work/try.c" 2>"$work/says"
}

must_not_know() { # MODULE HEADER
  if try_include "$1" "$2" || ! grep -q 'No such file' "$work/says"; then
    echo "$1 may include $2" && cat "$work/says" && exit 1
  fi
}

try_include profiles profiles/lookup.h || { cat "$work/says" && exit 1; }
try_include broadphase runtime/narrowphase/level.h || { cat "$work/says" && exit 1; }
must_not_know profiles runtime/opencl/device.h
must_not_know broadphase runtime/dynamics/motion.h
must_not_know queries runtime/dynamics/motion.h
must_not_know scene runtime/dynamics/motion.h
must_not_know base runtime/duet.h
must_not_know tuner cli/say.h

below=()
while IFS='|' read -r name _ objects; do
  IFS=, read -ra own <<<"$objects"
  [ -n "$objects" ] || continue
  below+=("${own[@]}")
  if ! "$compiler" -shared -Wl,-z,defs -o "$work/all.so" "${below[@]}" "$@" 2>"$work/says"; then
    echo "$name needs what lies above it:"
    grep -o 'undefined reference to .*' "$work/says" | sort -u | head -20
    exit 1
  fi
done <"$modules"
