# Builds the Debian packages, unpacks them, and uses what is in them from there: the
# program, the experiments, the module, the library in C and in C++.
#
#   SOURCE    the source tree of Duet
#   FOLDER    to work in; the build tree in it is kept
#   LAUNCHER  of the compiler, or nothing
#   LUA       a stock Lua
#   LINTIAN   Debian's checker of packages, or nothing
cmake_minimum_required(VERSION 3.22)
set(root ${FOLDER}/root)
set(away ${FOLDER}/away) # where a person happens to be

function(run)
  execute_process(COMMAND ${ARGV} WORKING_DIRECTORY ${away} RESULT_VARIABLE status
    OUTPUT_VARIABLE out ERROR_VARIABLE error)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${ARGV}: ${status}\n${out}${error}")
  endif()
  set(out "${out}" PARENT_SCOPE)
endfunction()

function(run_says expected)
  run(${ARGN})
  if(NOT out MATCHES "${expected}")
    message(FATAL_ERROR "${ARGN} says '${out}', not '${expected}'")
  endif()
endfunction()

function(must_exist pattern)
  file(GLOB found ${root}/${pattern})
  if(NOT found)
    message(FATAL_ERROR "no package has ${pattern}")
  endif()
  list(GET found 0 found)
  set(found ${found} PARENT_SCOPE)
endfunction()

file(REMOVE_RECURSE ${root} ${away})
file(MAKE_DIRECTORY ${away})
set(ENV{DEBFULLNAME} "A Builder")
set(ENV{DEBEMAIL} builder@duet.invalid)
run(${CMAKE_COMMAND} -S ${SOURCE} -B ${FOLDER}/build -G Ninja -DCMAKE_INSTALL_PREFIX=/usr
  -DBUILD_TESTING=OFF "-DCMAKE_C_COMPILER_LAUNCHER=${LAUNCHER}")
run(${CMAKE_COMMAND} --build ${FOLDER}/build --target package)

set(packages duet libduet0.9 libduet-dev lua-duet)
file(GLOB cluster ${FOLDER}/build/duet-cluster)
if(cluster)
  list(APPEND packages duet-cluster)
endif()
foreach(package IN LISTS packages)
  file(GLOB deb ${FOLDER}/build/${package}_*.deb)
  run(dpkg-deb -x ${deb} ${root})
  run_says("Package: ${package}\n" dpkg-deb -f ${deb} Package Depends)
  foreach(file copyright changelog.gz changelog.Debian.gz)
    must_exist(usr/share/doc/${package}/${file})
  endforeach()
  if(LINTIAN)
    run(${LINTIAN} --allow-root --fail-on error ${deb})
  endif()
endforeach()
file(GLOB deb ${FOLDER}/build/libduet-dev_*.deb)
run_says("^libduet0.9 \\(= 0" dpkg-deb -f ${deb} Depends)
foreach(file share/doc/duet/README.md share/doc/duet/docs/guide.md share/doc/duet/examples/hello.c
    share/man/man1/duet.1.gz share/man/man1/duet-run.1.gz share/bash-completion/completions/duet
    share/duet/lua/scenes/paper.lua share/duet/lua/definitions/duet.lua)
  must_exist(usr/${file})
endforeach()

set(duet ${root}/usr/bin/duet)
set(experiments ${root}/usr/share/duet/lua/experiments)
run_says("^duet 0" ${duet} --version)
if(cluster)
  must_exist(usr/bin/duet-cluster)
  must_exist(usr/include/duet/duet_cluster.h)
  run_says("3 axis|3 boxes|3 rotated" ${duet} cluster --plain still -n 3)
endif()
run_says("100" ${duet} lua --trust ${experiments}/cell_flaw.lua --sizes 100)
must_exist(usr/lib/*/lua/5.4/duet.so)
get_filename_component(modules ${found} DIRECTORY)
set(ENV{LUA_CPATH} ${modules}/?.so)
run_says("100" ${LUA} ${experiments}/cell_flaw.lua --sizes 100)

must_exist(usr/lib/*/pkgconfig/duet.pc)
get_filename_component(libraries ${found} DIRECTORY)
set(ENV{PKG_CONFIG_PATH} ${libraries})
set(ENV{LD_LIBRARY_PATH} ${libraries}/..)
run(pkg-config --cflags --libs duet)
separate_arguments(flags UNIX_COMMAND "${out}")
foreach(compiler "cc" "g++;-x;c++")
  run(${compiler} ${root}/usr/share/doc/duet/examples/hello.c -x none -o hello ${flags})
  run_says("^0 and 1 collide\n$" ./hello)
endforeach()
