# libduet.a, libduet.so, and what an application needs to find them:
# find_package(duet) and pkg-config. Installed paths are relative to where the
# files lie, so that an installed tree may be moved.
include(CMakePackageConfigHelpers)

# One object of them all, in which only what the public headers declare is visible:
# an application may have a text_free() of its own.
add_custom_command(
  OUTPUT duet.o
  COMMAND ${CMAKE_C_COMPILER} -nostdlib -r -o duet.o ${duet_objects}
  COMMAND ${CMAKE_OBJCOPY} --localize-hidden duet.o
  DEPENDS ${duet_objects}
  COMMAND_EXPAND_LISTS VERBATIM)
add_library(duet_static STATIC ${CMAKE_CURRENT_BINARY_DIR}/duet.o)
set_target_properties(duet_static PROPERTIES LINKER_LANGUAGE C)
add_library(duet_shared SHARED ${duet_objects})
set_target_properties(duet_shared PROPERTIES OUTPUT_NAME duet EXPORT_NAME duet
  VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR})
set_target_properties(duet_static PROPERTIES OUTPUT_NAME duet EXPORT_NAME static)
foreach(library duet_static duet_shared)
  target_link_libraries(${library} PRIVATE ${duet_needs} $<BUILD_INTERFACE:duet_options>)
  target_include_directories(${library} INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
endforeach()

set(config_dir ${CMAKE_INSTALL_LIBDIR}/cmake/duet)
set(pc_dir ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
file(RELATIVE_PATH pc_to_prefix /${pc_dir} /)
configure_package_config_file(runtime/duet-config.cmake.in duet-config.cmake
  INSTALL_DESTINATION ${config_dir})
write_basic_package_version_file(duet-config-version.cmake COMPATIBILITY SameMajorVersion)
configure_file(runtime/duet.pc.in duet.pc @ONLY)

file(GLOB public_headers CONFIGURE_DEPENDS runtime/duet*.h base/duet_*.h
  profiles/duet_*.h tuner/duet_*.h lua/duet_*.h)
install(TARGETS duet COMPONENT program)
install(TARGETS duet_shared EXPORT duet LIBRARY COMPONENT library NAMELINK_COMPONENT development)
install(TARGETS duet_static EXPORT duet-static ARCHIVE COMPONENT development)
install(FILES ${public_headers} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/duet COMPONENT development)
install(EXPORT duet NAMESPACE duet:: FILE duet-targets.cmake DESTINATION ${config_dir}
  COMPONENT development)
install(EXPORT duet-static NAMESPACE duet:: FILE duet-static-targets.cmake
  DESTINATION ${config_dir} COMPONENT development)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/duet-config.cmake
  ${CMAKE_CURRENT_BINARY_DIR}/duet-config-version.cmake DESTINATION ${config_dir}
  COMPONENT development)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/duet.pc DESTINATION ${pc_dir} COMPONENT development)

# Scenes and experiments lie beside each other, as in the source.
install(DIRECTORY lua/scenes lua/experiments DESTINATION ${CMAKE_INSTALL_DATADIR}/duet/lua
  COMPONENT program)
install(FILES README.md DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program)
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program
  PATTERN "*.dot" EXCLUDE)
install(FILES CHANGELOG.md LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT plain)
install(DIRECTORY examples DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT development)
