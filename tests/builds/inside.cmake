# SPDX-License-Identifier: MIT
# Builds a game that has Duet's source in its own build (game/), and looks that it gets the
# library and nothing else; or all of Duet, if it asks for that.
#
#   FETCH  by FetchContent, otherwise by add_subdirectory
#   ALL    all of Duet is asked for
include(${CMAKE_CURRENT_LIST_DIR}/common.cmake)

function(must_be what expected found)
  if(NOT "${found}" STREQUAL "${expected}")
    message(FATAL_ERROR "${what}: '${found}', not '${expected}'")
  endif()
endfunction()

configure(${CMAKE_CURRENT_LIST_DIR}/game -G Ninja -DDUET=${SOURCE} -DFETCH=${FETCH} -DDUET_ALL=${ALL})
run(${CMAKE_COMMAND} --build ${build})
foreach(way duet static)
  run_says("^0 and 1 collide\n$" ${build}/bin/with_${way})
endforeach()
# Objects are copied where ALL is off, so the commands are looked at.
file(STRINGS ${build}/compile_commands.json commands REGEX " -o [^ ]*/CMakeFiles/duet[a-z_]*[.]dir/")
list(LENGTH commands n_commands)
list(FILTER commands EXCLUDE REGEX " -flto.* -ffast-math .*-fno-fast-math .*-fno-lto ")
if(n_commands EQUAL 0 OR commands)
  message(FATAL_ERROR "${n_commands} commands; these keep what the game compiles with: ${commands}")
endif()

run(${CMAKE_COMMAND} --install ${build} --prefix ${FOLDER}/installed)
run(${CMAKE_CTEST_COMMAND} --test-dir ${build} -N)

if(ALL)
  run_says("^duet 0" ${FOLDER}/installed/bin/duet --version)
  run_tests()
else()
  if(NOT out MATCHES "Total Tests: 1\n")
    message(FATAL_ERROR "the game has tests of Duet:\n${out}")
  endif()
  file(GLOB programs RELATIVE ${build}/bin ${build}/bin/*)
  list(FILTER programs EXCLUDE REGEX "^libduet[.]so")
  must_be("what was built" "with_duet;with_static" "${programs}")
  file(GLOB_RECURSE installed RELATIVE ${FOLDER}/installed ${FOLDER}/installed/*)
  must_be("what is installed" "bin/with_duet;bin/with_static" "${installed}")
endif()
file(GLOB packages ${build}/CPack*)
must_be("rules of packages" "" "${packages}")
