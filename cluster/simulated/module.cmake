# The program duet-simulate, where SimGrid is there: the module cluster once more, with SimGrid's
# MPI in the place of a real one. All of its ranks are in one process.
set(DUET_HAS_SIMULATE OFF)
if(DUET_SIMULATE STREQUAL "OFF" OR DUET_SANITIZE)
  return()
endif()

find_library(SIMGRID_LIBRARY simgrid)
find_path(SMPI_INCLUDE_DIR smpi/mpi.h)
if(NOT SIMGRID_LIBRARY OR NOT SMPI_INCLUDE_DIR)
  if(DUET_SIMULATE STREQUAL "ON")
    message(FATAL_ERROR "DUET_SIMULATE is ON, and SimGrid is missing; on Debian: apt install "
      "libsimgrid-dev")
  endif()
  message(STATUS "without duet-simulate: SimGrid is missing")
  return()
endif()
set(DUET_HAS_SIMULATE ON)

add_library(duet_simgrid INTERFACE)
target_include_directories(duet_simgrid SYSTEM INTERFACE ${SMPI_INCLUDE_DIR}/smpi ${SMPI_INCLUDE_DIR})
target_link_libraries(duet_simgrid INTERFACE ${SIMGRID_LIBRARY})
target_compile_definitions(duet_simgrid INTERFACE _DEFAULT_SOURCE) # useconds_t, which they take for granted

set(arrows "${duet_arrows}")
set(objects "${duet_module_objects}")
duet_module(simulated FOLDER cluster KNOWS selection commands LINKS duet_simgrid)
set(duet_arrows "${arrows}")
set(duet_module_objects "${objects}")

add_executable(duet-simulate cli/cluster/simulate.c cli/cluster/rank.c cli/cluster/rank_motion.c
  cli/cluster/rank_frames.c cli/cluster/rank_tune.c cli/cluster/rank_picture.c cli/cluster/rank_check.c cli/cluster/rank_replay.c
  $<TARGET_OBJECTS:duet_cli> $<TARGET_OBJECTS:duet_simulated> ${duet_objects})
target_link_libraries(duet-simulate PRIVATE duet_cli duet_simulated duet_options)
add_dependencies(duet duet-simulate)
install(TARGETS duet-simulate COMPONENT simulate)
