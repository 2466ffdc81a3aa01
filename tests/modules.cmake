# Checks the include lines of every file against the modules: what a module may
# know lies in the rows below, and nothing points up. Also that no file names
# a place of the machine that it was written on.
#
#   ROOT  the source tree
cmake_minimum_required(VERSION 3.22)
set(modules runtime/base gen profiles runtime tuner tuner/cli lua examples)
set(runtime/base_knows runtime/base)
set(gen_knows runtime/base gen)
set(profiles_knows runtime/base profiles)
set(runtime_knows runtime/base gen profiles runtime)
set(tuner_knows ${runtime_knows} tuner)
set(tuner/cli_knows ${tuner_knows} tuner/cli lua)
set(lua_knows ${tuner_knows} lua)
set(examples_knows duet)

set(wrong "")

# The module of an included header, by its folder; a public header may be named
# without one.
function(find_room header result)
  get_filename_component(folder ${header} DIRECTORY)
  if(folder STREQUAL "")
    file(GLOB places ${ROOT}/runtime/base/${header} ${ROOT}/runtime/${header}
      ${ROOT}/tuner/${header} ${ROOT}/lua/${header} ${ROOT}/profiles/${header})
    list(GET places 0 place)
    get_filename_component(folder ${place} DIRECTORY)
    file(RELATIVE_PATH folder ${ROOT} ${folder})
  endif()
  set(${result} ${folder} PARENT_SCOPE)
endfunction()

foreach(module IN LISTS modules)
  file(GLOB files RELATIVE ${ROOT} ${ROOT}/${module}/*.c ${ROOT}/${module}/*.h)
  foreach(file IN LISTS files)
    file(STRINGS ${ROOT}/${file} lines REGEX "^ *# *include *\"")
    foreach(line IN LISTS lines)
      string(REGEX REPLACE "^.*\"(.*)\".*$" "\\1" header "${line}")
      find_room(${header} knows)
      if(NOT knows IN_LIST ${module}_knows)
        string(APPEND wrong "${file} includes ${header}: ${module} may know ${${module}_knows}\n")
      endif()
    endforeach()
  endforeach()
endforeach()

file(GLOB_RECURSE files LIST_DIRECTORIES false RELATIVE ${ROOT}
  ${ROOT}/.ci/* ${ROOT}/runtime/* ${ROOT}/kernels/* ${ROOT}/gen/* ${ROOT}/tuner/* ${ROOT}/profiles/*
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
