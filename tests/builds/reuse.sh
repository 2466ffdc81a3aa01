#!/bin/sh
# SPDX-License-Identifier: MIT
# A compiler launcher that copies an object which the build tree $DUET_BUILT has already, so
# that a test can build Duet by other rules without compiling all of it again. Everything
# else is compiled.
object= depfile= previous=
for word; do
  case $previous in -o) object=$word ;; -MF) depfile=$word ;; esac
  previous=$word
done
built=$DUET_BUILT/CMakeFiles/$(echo "${object##*CMakeFiles/}" | sed 's,\.dir/[A-Z][A-Za-z]*/,.dir/,')
case $object in
*CMakeFiles/duet*.c.o)
  if [ -e "$built" ]; then
    [ -z "$depfile" ] || : >"$depfile"
    exec cp "$built" "$object"
  fi
  ;;
esac
exec "$@"
