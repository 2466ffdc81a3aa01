# Small motions whose state and contacts are kept by Oclgrind's simulator. Each
# ends in the very state that the machine's own device gives, and together they
# launch every kernel that motions have.
#
#   PROGRAM  duet
#   KERNELS  kernels
#   DIMS     2 or 3
#   CLUSTER  whether duet has the command cluster
#   and those of begin.cmake
cmake_minimum_required(VERSION 3.22)
include(${CMAKE_CURRENT_LIST_DIR}/begin.cmake)
if(NOT ICD)
  return()
endif()
set(ENV{OCLGRIND_INST_COUNTS} 1) # tells the kernels that were launched

# Runs the case on a pair by a command of duet and gives the line with the state's hash.
function(state_by command case steps pair result)
  separate_arguments(arguments UNIX_COMMAND "${case}")
  execute_process(COMMAND ${PROGRAM} ${command} ${CMAKE_CURRENT_LIST_DIR}/boxes.lua ${arguments}
    --steps ${steps} --pair ${pair}
    RESULT_VARIABLE status OUTPUT_VARIABLE out ERROR_VARIABLE err)
  if(NOT status EQUAL 0 OR NOT err STREQUAL "" OR NOT out MATCHES "state hash ([0-9a-f]+)")
    message(FATAL_ERROR "${case} on ${pair}: ${status}\n${err}\n${out}")
  endif()
  set(${result} ${CMAKE_MATCH_1} PARENT_SCOPE)
  string(REGEX MATCHALL "kernel '[a-z_]+'" names "${out}")
  set(launched ${launched} ${names} PARENT_SCOPE)
endfunction()

# B = device
macro(state_of case steps device result)
  state_by(run "${case}" ${steps} pocl:0,${device} ${result})
endmacro()

set(launched "")
set(cases_3 # a ground is three-dimensional
  "2 --set hills=true --variant 'auto contact_graph.WG=64'" "2 --set mesh=true"
  "2 --set carried=true --set rounded=true --set rolling=true --set belt=true"
  "2 --set mesh=true --set materials=true --set deep=true --set continuous=true")
foreach(case ${cases_${DIMS}}
    "2 --set shocks=true"
    "3 --set sleep=true --set events=true"
    "2 --set skin=0.3 --set continuous=true --set boundary=none"
    "2 --set sleep=true --variant 'auto solve_contacts.WG=64 graph_colour.WG=64 contact_graph.WG=64'"
    "2 --set turned=false --set filtered=true --set doubles=true"
    "2 --set origin=true --set boundary=none"
    "2 --set falling=false --set boundary=periodic"
    "2 --set falling=false --set attraction=5.0 --set integrator=yoshida")
  string(REGEX MATCH "^[0-9]+" steps "${case}")
  string(REGEX REPLACE "^[0-9]+ " "--set dims=${DIMS} " case "${case}")
  state_of("${case}" ${steps} oclgrind:0 simulated)
  state_of("${case}" ${steps} pocl:0 right)
  if(NOT simulated STREQUAL right)
    message(FATAL_ERROR "${case}: the state is ${simulated}, not ${right}")
  endif()
endforeach()

# Two domains send each other rows, and bodies at each checkpoint, if this build has duet cluster. Ranks first ask for where a
# device is, by properties that Oclgrind reports as wrong calls.
if(CLUSTER)
  set(checks $ENV{OCLGRIND_CHECK_API})
  unset(ENV{OCLGRIND_CHECK_API})
  state_by(cluster "--set dims=${DIMS} --parts 2 --every 1 --checkpoint ${FOLDER}/two.ck" 3 oclgrind:0 simulated)
  set(ENV{OCLGRIND_CHECK_API} ${checks})
  state_of("--set dims=${DIMS}" 3 pocl:0 right)
  if(NOT simulated STREQUAL right)
    message(FATAL_ERROR "two domains: the state is ${simulated}, not ${right}")
  endif()
else()
  foreach(name IN ITEMS pack_rows unpack_rows mark_border choose_inner count_border list_border used_colours
      list_near list_meeting make_far_boxes keep_contacts begin_ghosts note_kept note_lacks take_needed take_own
      end_contacts end_ghosts read_asked take_asked)
    list(APPEND launched "kernel '${name}'")
  endforeach()
endif()

# Ghosts that come less often than after each colour, and contacts that are asked for, take more steps than a simulator
# has time for; cluster_motion compares what these kernels find with sweeps.
foreach(name IN ITEMS note_lacks take_needed read_asked take_asked)
  list(APPEND launched "kernel '${name}'")
endforeach()

# Groups of this kernel wait for each other, and a simulator runs one after the other.
list(APPEND launched "kernel 'colour_contacts'")

# Reads and contact queries, which no run of a scene makes.
function(numbers_of device result)
  execute_process(
    COMMAND ${PROGRAM} lua --trust ${CMAKE_CURRENT_LIST_DIR}/reads.lua ${DIMS} ${device}
    RESULT_VARIABLE status OUTPUT_VARIABLE out ERROR_VARIABLE err)
  string(REGEX MATCHALL "[^\n]*0x[^\n]*\n" numbers "${out}")
  if(NOT status EQUAL 0 OR NOT err STREQUAL "" OR numbers STREQUAL "")
    message(FATAL_ERROR "reads on ${device}: ${status}\n${err}\n${out}")
  endif()
  set(${result} ${numbers} PARENT_SCOPE)
  string(REGEX MATCHALL "kernel '[a-z_]+'" names "${out}")
  set(launched ${launched} ${names} PARENT_SCOPE)
endfunction()

numbers_of(oclgrind:0 simulated)
numbers_of(pocl:0 right)
if(NOT simulated STREQUAL right)
  message(FATAL_ERROR "reads: ${simulated}, not ${right}")
endif()

set(lacking "")
file(GLOB paths ${KERNELS}/dynamics/*.cl ${KERNELS}/dynamics/*.cl.in)
foreach(path IN LISTS paths)
  file(STRINGS ${path} heads REGEX "^__kernel void ")
  foreach(head IN LISTS heads)
    string(REGEX REPLACE "^__kernel void ([a-z_]+).*" "\\1" name "${head}")
    if(NOT "kernel '${name}'" IN_LIST launched)
      list(APPEND lacking ${name})
    endif()
  endforeach()
endforeach()
if(lacking)
  message(FATAL_ERROR "no case launches ${lacking}")
endif()
