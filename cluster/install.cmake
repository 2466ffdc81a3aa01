# duet-cluster, libduet_cluster.so and what an application needs to find it, as one component:
# find_package(duet COMPONENTS cluster) and pkg-config.
if(NOT DUET_HAS_CLUSTER)
  return()
endif()
file(CREATE_LINK ${PROJECT_SOURCE_DIR}/cluster/duet_cluster.h ${duet_public}/duet/duet_cluster.h SYMBOLIC)
target_include_directories(duet_cluster_shared INTERFACE
  $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}> $<BUILD_INTERFACE:${duet_public}>)
add_library(duet::cluster ALIAS duet_cluster_shared)
configure_file(cluster/duet_cluster.pc.in duet_cluster.pc @ONLY)

install(TARGETS duet-cluster COMPONENT cluster)
install(TARGETS duet_cluster_shared EXPORT duet-cluster LIBRARY COMPONENT cluster
  NAMELINK_COMPONENT cluster)
install(EXPORT duet-cluster NAMESPACE duet:: FILE duet-cluster-targets.cmake
  DESTINATION ${config_dir} COMPONENT cluster)
install(FILES cluster/duet_cluster.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/duet
  COMPONENT cluster)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/duet_cluster.pc DESTINATION ${pc_dir} COMPONENT cluster)
