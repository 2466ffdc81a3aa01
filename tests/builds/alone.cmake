# SPDX-License-Identifier: MIT
# Builds Duet by itself, with a generator or a compiler of its own.
#
#   TESTING  whether the tests are built, too
#   OPTIONS  of cmake, with commas between them
#   TARGETS  to build, with commas between them; all, if there are none
#   RUNS     whether the program is built and so can be run
#   CONFIGS  of a generator with several, with commas between them
include(${CMAKE_CURRENT_LIST_DIR}/common.cmake)
string(REPLACE "," ";" OPTIONS "${OPTIONS}")
string(REPLACE "," ";" TARGETS "${TARGETS}")
string(REPLACE "," ";" CONFIGS "${CONFIGS}")

configure(${SOURCE} -DDUET_WERROR=ON -DBUILD_TESTING=${TESTING} ${OPTIONS})
if(TARGETS)
  list(PREPEND TARGETS --target)
endif()
if(NOT CONFIGS)
  run(${CMAKE_COMMAND} --build ${build} ${TARGETS} -j4)
  if(RUNS)
    run_says("^duet 0" ${build}/duet --version)
  endif()
  if(TESTING)
    run_tests()
  endif()
endif()
foreach(config IN LISTS CONFIGS)
  run(${CMAKE_COMMAND} --build ${build} --config ${config} ${TARGETS} -j4)
  if(RUNS)
    run_says("^duet 0" ${build}/${config}/duet --version)
    run(${CMAKE_COMMAND} --install ${build} --config ${config} --prefix ${FOLDER}/${config})
    run_says("^duet 0" ${FOLDER}/${config}/bin/duet --version)
  endif()
  if(TESTING)
    run_tests(-C ${config})
  endif()
endforeach()
