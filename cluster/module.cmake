# The module cluster, the program duet-cluster and libduet_cluster.so, where MPI is there. README.md says why they are apart from duet and libduet.so.
set(DUET_HAS_CLUSTER OFF)
set(duet_arrows "${duet_arrows}  cluster -> selection\n  cluster -> commands\n")
if(DUET_CLUSTER STREQUAL "OFF" OR DUET_SANITIZE MATCHES "thread|fuzzer")
  return()
endif()

find_package(MPI COMPONENTS C QUIET)
if(NOT MPI_C_FOUND)
  if(DUET_CLUSTER STREQUAL "ON")
    message(FATAL_ERROR "DUET_CLUSTER is ON, and MPI is missing; on Debian: apt install "
      "libopenmpi-dev openmpi-bin")
  endif()
  message(STATUS "without duet-cluster: MPI is missing")
  return()
endif()
set(DUET_HAS_CLUSTER ON)

set(arrows "${duet_arrows}")
set(objects "${duet_module_objects}")
duet_module(cluster FOLDER cluster WITHOUT cluster/simulated KNOWS selection commands LINKS MPI::MPI_C)
set(duet_arrows "${arrows}")
set(duet_module_objects "${objects}")
set(duet_cluster_needs MPI::MPI_C)

add_executable(duet-cluster cli/cluster/main.c cli/cluster/rank.c cli/cluster/rank_motion.c
  cli/cluster/rank_frames.c cli/cluster/rank_tune.c cli/cluster/rank_picture.c cli/cluster/rank_check.c cli/cluster/rank_replay.c
  $<TARGET_OBJECTS:duet_cli> $<TARGET_OBJECTS:duet_cluster> ${duet_objects})
target_link_libraries(duet-cluster PRIVATE duet_cli duet_cluster duet_options ${duet_cluster_needs})
add_dependencies(duet duet-cluster)

add_library(duet_cluster_shared SHARED $<TARGET_OBJECTS:duet_cluster> ${duet_objects})
set_target_properties(duet_cluster_shared PROPERTIES OUTPUT_NAME duet_cluster EXPORT_NAME cluster
  VERSION ${PROJECT_VERSION} SOVERSION ${duet_abi})
# An application, or a Lua that loads it, may have a copy of Duet besides.
target_link_options(duet_cluster_shared PRIVATE -Wl,-Bsymbolic)
target_link_libraries(duet_cluster_shared PRIVATE ${duet_needs} ${duet_cluster_needs}
  $<BUILD_INTERFACE:duet_options>)
