# Turns text files into one C file that holds their bytes.
#   cmake -DOUT=blobs.c "-DFILES=a.cl;b.lua" -DROOT=<source dir> -P embed.cmake
set(table "")
set(n 0)
set(arrays "")
foreach(path IN LISTS FILES)
  file(READ "${ROOT}/${path}" hex HEX)
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "'\\\\x\\1'," bytes "${hex}")
  string(REPLACE "x0a'," "x0a',\n  " bytes "${bytes}") # a row for each line of the file
  string(APPEND arrays "static const char blob_${n}[] = {\n  ${bytes}0};\n")
  file(SHA256 "${ROOT}/${path}" sha256)
  string(APPEND table "  {\"${path}\", blob_${n}, sizeof blob_${n} - 1, \"${sha256}\"},\n")
  math(EXPR n "${n} + 1")
endforeach()
file(WRITE "${OUT}" "// Written by gen/embed.cmake; do not edit.\n#include \"base/blob.h\"\n\n${arrays}
const blob blobs[] = {\n${table}  {0, 0, 0, 0},\n};\n")
