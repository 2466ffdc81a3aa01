# No file names a place of the machine that it was written on.
#
#   ROOT  the source tree
cmake_minimum_required(VERSION 3.22)
set(wrong "")
file(GLOB_RECURSE files LIST_DIRECTORIES false RELATIVE ${ROOT}
  ${ROOT}/.ci/* ${ROOT}/base/* ${ROOT}/cli/* ${ROOT}/runtime/* ${ROOT}/kernels/* ${ROOT}/gen/* ${ROOT}/tuner/* ${ROOT}/profiles/*
  ${ROOT}/lua/* ${ROOT}/tests/* ${ROOT}/docs/* ${ROOT}/examples/*)
file(GLOB top RELATIVE ${ROOT} ${ROOT}/*.md ${ROOT}/*.txt ${ROOT}/*.json)
foreach(file IN LISTS files top)
  file(STRINGS ${ROOT}/${file} lines REGEX "/(home|root|work|Users)/[a-z]")
  if(lines)
    string(APPEND wrong "${file} names a place of one machine: ${lines}\n")
  endif()
endforeach()

if(wrong)
  message(FATAL_ERROR "${wrong}")
endif()
