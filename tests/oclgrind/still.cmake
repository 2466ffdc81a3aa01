# Small scenes on a device pair of two platforms: one is Oclgrind's simulator.
#
#   PROGRAM  duet
#   SCENES   lua/scenes
#   and those of begin.cmake
cmake_minimum_required(VERSION 3.22)
include(${CMAKE_CURRENT_LIST_DIR}/begin.cmake)
if(NOT ICD)
  return()
endif()

set(small -n 150 --repeat 1 --check)
# Pairs alone: seven, so that a group is not full.
file(WRITE ${FOLDER}/pairs.txt "")
foreach(at 0 0.5 0.9 1 1.1 2 3)
  file(APPEND ${FOLDER}/pairs.txt "0 0 0 .5 .5 .5 0 0 0 1  ${at} 0 0 .5 .5 .5 1 2 3 4\n")
endforeach()
foreach(level certified sat15 double)
  execute_process(COMMAND ${PROGRAM} query ${FOLDER}/pairs.txt --level ${level}
    --pair oclgrind:0,pocl:0 --share 0.8
    RESULT_VARIABLE status OUTPUT_VARIABLE out ERROR_VARIABLE err)
  if(NOT status EQUAL 0 OR NOT err STREQUAL "" OR NOT out MATCHES "5 colliding, 2 separated")
    message(FATAL_ERROR "query --level ${level}: ${status}\n${err}\n${out}")
  endif()
endforeach()

foreach(case
    "paper.lua --set world=9 --pair pocl:0,oclgrind:0 --share 0.5"
    "paper.lua --set world=9 --pair pocl:0,oclgrind:0 --share 0.3 --mode shared --set rotated=false"
    "paper.lua --set world=9 --pair oclgrind:0,pocl:0 --share 0.6 --mode shared"
    "paper.lua --set world=9 --pair oclgrind:0,pocl:0 --share 0.5 --mode slab"
    "paper.lua --set world=9 --pair pocl:0,oclgrind:0 --share 0.5 --mode slab --ordered"
    "paper.lua --set world=9 --pair pocl:0,oclgrind:0 --share 0.5 --mode shared --variant paper"
    "paper2d.lua --set world=9 --pair pocl:0,oclgrind:0 --share 0.5"
    "paper2d.lua --set world=9 --pair oclgrind:0,pocl:0 --share 0.5 --variant paper"
    "mixed.lua --pair pocl:0,oclgrind:0 --share 0.2")
  separate_arguments(arguments UNIX_COMMAND "${case}")
  execute_process(COMMAND ${PROGRAM} run ${SCENES}/${arguments} ${small}
    RESULT_VARIABLE status OUTPUT_VARIABLE out ERROR_VARIABLE err)
  if(NOT status EQUAL 0 OR NOT err STREQUAL "" OR NOT out MATCHES "as the plain C reference")
    message(FATAL_ERROR "${case}: ${status}\n${err}\n${out}")
  endif()
endforeach()
