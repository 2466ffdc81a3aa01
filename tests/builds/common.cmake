# SPDX-License-Identifier: MIT
# What the scripts beside this one share. They are given by -D:
#
#   SOURCE    the source tree of Duet
#   FOLDER    to work in; made anew
#   LAUNCHER  of the compiler, or nothing
cmake_minimum_required(VERSION 3.22)
include(${CMAKE_CURRENT_LIST_DIR}/../support/run.cmake)
set(build ${FOLDER}/build)

# Runs those of Duet's tests that look for files of the build, by options of ctest.
function(run_tests)
  run(${CMAKE_CTEST_COMMAND} --test-dir ${build} ${ARGN} --output-on-failure --no-tests=error
    -R "^(cluster_lua_[0-9]|consumer|lua_(api|source)|manual|modules|modules_figure)$")
endfunction()

# Configures a source tree in ${build}, by options that each test adds.
function(configure source)
  file(REMOVE_RECURSE ${FOLDER})
  run(${CMAKE_COMMAND} -S ${source} -B ${build} "-DCMAKE_C_COMPILER_LAUNCHER=${LAUNCHER}"
    ${ARGN})
endfunction()
