# libduet.a, libduet.so, and what an application needs to find them: find_package(duet) and
# pkg-config, or duet::duet and duet::static in the build that has Duet's source. Installed paths are relative to where the
# files lie, so that an installed tree may be moved.
include(CMakePackageConfigHelpers)

# As they are installed, for those who build Duet with their own program.
set(duet_public ${CMAKE_CURRENT_BINARY_DIR}/include/public)
file(GLOB public_headers CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/runtime/duet*.h
  ${PROJECT_SOURCE_DIR}/base/duet_*.h ${PROJECT_SOURCE_DIR}/profiles/duet_*.h
  ${PROJECT_SOURCE_DIR}/tuner/duet_*.h ${PROJECT_SOURCE_DIR}/lua/duet_*.h)
file(MAKE_DIRECTORY ${duet_public}/duet)
foreach(path IN LISTS public_headers)
  get_filename_component(header ${path} NAME)
  file(CREATE_LINK ${path} ${duet_public}/duet/${header} SYMBOLIC)
endforeach()

# One object of them all, in which only what the public headers declare is visible:
# an application may have a text_free() of its own.
add_custom_command(
  OUTPUT duet-$<CONFIG>.o
  COMMAND ${CMAKE_C_COMPILER} -nostdlib -r -o duet-$<CONFIG>.o ${duet_objects}
  COMMAND ${CMAKE_OBJCOPY} --localize-hidden duet-$<CONFIG>.o
  DEPENDS ${duet_objects}
  COMMAND_EXPAND_LISTS VERBATIM)
add_library(duet_static STATIC ${CMAKE_CURRENT_BINARY_DIR}/duet-$<CONFIG>.o)
add_dependencies(duet_static ${duet_library}) # make knows how objects are made only in their own targets
set_target_properties(duet_static PROPERTIES LINKER_LANGUAGE C)
add_library(duet_shared SHARED ${duet_objects})
set_target_properties(duet_shared PROPERTIES OUTPUT_NAME duet EXPORT_NAME duet
  VERSION ${PROJECT_VERSION} SOVERSION ${duet_abi})
set_target_properties(duet_static PROPERTIES OUTPUT_NAME duet EXPORT_NAME static)
foreach(library duet_static duet_shared)
  target_link_libraries(${library} PRIVATE ${duet_needs} $<BUILD_INTERFACE:duet_options>)
  target_include_directories(${library} INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>
    $<BUILD_INTERFACE:${duet_public}>)
endforeach()
add_library(duet::duet ALIAS duet_shared)
add_library(duet::static ALIAS duet_static)

set(config_dir ${CMAKE_INSTALL_LIBDIR}/cmake/duet)
set(pc_dir ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
file(RELATIVE_PATH pc_to_prefix /${pc_dir} /)
# CMake would find them in the build tree itself, if that is in PATH; trees of before had them there.
file(REMOVE ${CMAKE_CURRENT_BINARY_DIR}/duet-config.cmake ${CMAKE_CURRENT_BINARY_DIR}/duet-config-version.cmake)
set(packaged ${CMAKE_CURRENT_BINARY_DIR}/packaged/config)
configure_package_config_file(runtime/duet-config.cmake.in ${packaged}/duet-config.cmake
  INSTALL_DESTINATION ${config_dir})
write_basic_package_version_file(${packaged}/duet-config-version.cmake COMPATIBILITY SameMinorVersion)
configure_file(runtime/duet.pc.in duet.pc @ONLY)

install(TARGETS duet COMPONENT program)
install(TARGETS duet_shared EXPORT duet LIBRARY COMPONENT library NAMELINK_COMPONENT development)
install(TARGETS duet_static EXPORT duet-static ARCHIVE COMPONENT development)
install(FILES ${public_headers} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/duet COMPONENT development)
install(EXPORT duet NAMESPACE duet:: FILE duet-targets.cmake DESTINATION ${config_dir}
  COMPONENT development)
install(EXPORT duet-static NAMESPACE duet:: FILE duet-static-targets.cmake
  DESTINATION ${config_dir} COMPONENT development)
install(FILES ${packaged}/duet-config.cmake ${packaged}/duet-config-version.cmake
  DESTINATION ${config_dir} COMPONENT development)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/duet.pc DESTINATION ${pc_dir} COMPONENT development)

# Scenes and experiments lie beside each other, as in the source.
install(DIRECTORY lua/scenes lua/experiments DESTINATION ${CMAKE_INSTALL_DATADIR}/duet/lua
  COMPONENT program)
install(FILES README.md DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program)
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program
  PATTERN "*.dot" EXCLUDE)
install(FILES CHANGELOG.md LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT plain)
install(DIRECTORY examples DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT development)
