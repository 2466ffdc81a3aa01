# Installs the library into a folder of the build tree, builds the consumer
# against it, and runs it.
#
#   BUILD     the build tree of Duet
#   CONFIG    which of its builds
#   CONSUMER  this folder
#   HELLO     the program's text
include(${CMAKE_CURRENT_LIST_DIR}/../support/run.cmake)
set(prefix ${BUILD}/consumer/installed)
set(built ${BUILD}/consumer/built)

file(REMOVE_RECURSE ${prefix} ${built})
run(${CMAKE_COMMAND} --install ${BUILD} --config ${CONFIG} --prefix ${prefix})

file(GLOB_RECURSE pc ${prefix}/duet.pc)
get_filename_component(pc_dir ${pc} DIRECTORY)
set(ENV{PKG_CONFIG_PATH} ${pc_dir})
run(${CMAKE_COMMAND} -S ${CONSUMER} -B ${built} -G Ninja -DCMAKE_PREFIX_PATH=${prefix}
  -DHELLO=${HELLO} -DCMAKE_C_FLAGS=-Werror -DCMAKE_CXX_FLAGS=-Werror)
run(${CMAKE_COMMAND} --build ${built})

# CMake looks beside the programs in PATH, too. The build tree, where the README has the program, is
# no place from which a project can take the library.
set(path $ENV{PATH})
set(ENV{PATH} ${BUILD}:${path})
file(WRITE ${built}/beside/CMakeLists.txt
  "cmake_minimum_required(VERSION 3.22)\nproject(beside NONE)\nfind_package(duet QUIET)\n")
run(${CMAKE_COMMAND} -S ${built}/beside -B ${built}/beside/built)
set(ENV{PATH} ${path})

set(ENV{LD_LIBRARY_PATH} ${pc_dir}/..)
foreach(way with_shared with_static with_own_names with_cxx with_pkg_config)
  run_says("^0 and 1 collide\n$" ${built}/${way})
endforeach()
run_says("^plan: [a-z ]+, share [0-9.]+\n300 frames, [0-9.]+ ms each, [1-9][0-9]* collisions\n$"
  ${built}/game_loop)
# A line of input cancels the menu at its first plan. The game then loads what a whole tuning
# kept, and the default plan until then and if nothing was kept.
function(game_has grade)
  run_says("^plan: ${grade}, " ${built}/game_loop)
endfunction()
set(users_store $ENV{DUET_PROFILE})
set(ENV{DUET_PROFILE} ${built}/menu.db)
file(WRITE ${built}/enter "\n")
run_says("^\r *[0-9]+ %  1 plans tried, Enter cancels \ncancelled; the next time goes on from here\n$"
  ${built}/options_menu 600 INPUT_FILE ${built}/enter)
game_has(default)
run(${built}/options_menu 600 INPUT_FILE /dev/null)
if(out MATCHES "\nthe game uses a share of [01][.][0-9]+ from its next start: [0-9.]+ ms a frame\n$")
  game_has(exact)
elseif(out MATCHES "\nnothing changes: [^\n]+\n$")
  game_has(default)
else()
  message(FATAL_ERROR "options_menu says '${out}'")
endif()
set(ENV{DUET_PROFILE} ${users_store})
run_says("^after 1[.]00 s the cube is at height 0[.]50\n$" ${built}/fall)
run_says("^(cube [0-9]+ hit the floor [1-9] times\n)+the hardest was cube 10, at 1[0-9][.][0-9] m/s\n$"
  ${built}/hits)
run(${built}/join)
string(REGEX MATCHALL "region [0-9] has box [0-9]+\n" regions "${out}")
list(LENGTH regions n_regions)
if(NOT n_regions EQUAL 13 OR NOT out MATCHES "^region 0 has box 0\n.*region 2 has box 559\n$")
  message(FATAL_ERROR "join says '${out}'")
endif()
run_says("^after 0.00 s\n  ray 0 sees box 3 at 6.5\n  ray 3 .*after 2.00 s\n  ray 0 sees box 1 at 2.5\n  ray 3 sees box 0 at 0.5\n$"
  ${built}/range_sensor)
run_says("^10 balls in 5 places; the wall is broken\n$" ${built}/thrower)
run_says("^the fork is at 3[.]00 2[.]10, and the crate on it at 3[.]0 2[.]7\n$" ${built}/crane)
run_says("^[1-9][0-9]+ pairs; the kernel met each twice: yes; no box has more than [1-9] neighbours\n$"
  ${built}/own_opencl)
get_filename_component(examples ${HELLO} DIRECTORY)
run_says("^plan: default, share [01][.][0-9]+\n20 steps of 512 bodies; momentum is kept: yes\n$"
  ${built}/own_kernel ${examples}/tasks/nbody.task.lua ${built}/no_store.db)
run(${prefix}/bin/duet --version)

# They are C++ too. {0} is how C begins an empty struct, of which g++ warns.
file(GLOB examples ${examples}/*.c)
foreach(example IN LISTS examples)
  run(c++ -x c++ -std=c++17 -Wall -Wextra -pedantic -Werror -Wno-missing-field-initializers
    -I${prefix}/include -fsyntax-only ${example})
endforeach()

# pkg-config looks for what is required in private even for the shared library,
# whose users need not have it.
run(pkg-config --print-requires-private duet)
if(NOT out STREQUAL "")
  message(FATAL_ERROR "duet.pc asks every user for ${out}")
endif()
execute_process(COMMAND pkg-config --cflags --libs --static duet OUTPUT_VARIABLE flags)
separate_arguments(flags UNIX_COMMAND "${flags}")
run(cc ${HELLO} -o ${built}/with_static_flags ${flags})
run(${built}/with_static_flags)

# Only the API can be seen from outside.
file(GLOB libraries ${pc_dir}/../libduet*.so)
foreach(library IN LISTS libraries)
  run(nm -D --defined-only ${library})
  string(REGEX MATCHALL "[A-Za-z_][A-Za-z0-9_]*\n" symbols "${out}")
  foreach(symbol IN LISTS symbols)
    if(NOT symbol MATCHES "^(duet_|luaopen_duet)")
      message(FATAL_ERROR "${library} shows '${symbol}', which is not of the API")
    endif()
  endforeach()
endforeach()

# MPI is asked of those alone who ask for clusters.
foreach(file ${prefix}/bin/duet ${pc_dir}/../libduet.so)
  run(ldd ${file})
  if(out MATCHES "libmpi")
    message(FATAL_ERROR "${file} needs MPI:\n${out}")
  endif()
endforeach()
