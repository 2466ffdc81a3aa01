# duet-cluster, libduet_cluster.so and what an application needs to find it, as one component:
# find_package(duet COMPONENTS cluster) and pkg-config.
if(NOT DUET_HAS_CLUSTER)
  return()
endif()
target_include_directories(duet_cluster_shared INTERFACE
  $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
configure_file(cluster/duet_cluster.pc.in duet_cluster.pc @ONLY)

install(TARGETS duet-cluster COMPONENT cluster)
install(TARGETS duet_cluster_shared EXPORT duet-cluster LIBRARY COMPONENT cluster
  NAMELINK_COMPONENT cluster)
install(EXPORT duet-cluster NAMESPACE duet:: FILE duet-cluster-targets.cmake
  DESTINATION ${config_dir} COMPONENT cluster)
install(FILES cluster/duet_cluster.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/duet
  COMPONENT cluster)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/duet_cluster.pc DESTINATION ${pc_dir} COMPONENT cluster)
