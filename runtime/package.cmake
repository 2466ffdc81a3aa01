# Debian packages of what `cmake --install` installs: duet, libduet0.9, libduet-dev, lua-duet,
# and duet-cluster where MPI is there. The preset `package` makes them:
#
#   cmake --preset package && cmake --build --preset package
#
# dpkg-dev finds out which libraries they depend on.
set(CPACK_PACKAGE_NAME duet)
set(CPACK_PACKAGE_VENDOR "The Duet authors")
# Who builds a package answers for it: DEBFULLNAME and DEBEMAIL, as for Debian's
# own tools. Without them there is no address to give.
if(DEFINED ENV{DEBFULLNAME} AND DEFINED ENV{DEBEMAIL})
  set(CPACK_PACKAGE_CONTACT "$ENV{DEBFULLNAME} <$ENV{DEBEMAIL}>")
else()
  set(CPACK_PACKAGE_CONTACT "The Duet authors <root@localhost>")
endif()
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE
  GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL program library development lua)
if(DUET_HAS_CLUSTER)
  list(APPEND CPACK_COMPONENTS_ALL cluster)
endif()
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "") # each package has its own

set(changelog_debian ${CMAKE_CURRENT_BINARY_DIR}/changelog.Debian)
execute_process(COMMAND date -uRd ${duet_date} OUTPUT_VARIABLE package_date
  OUTPUT_STRIP_TRAILING_WHITESPACE)
file(WRITE ${changelog_debian} "duet (${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE}) unstable; urgency=medium

  * Duet ${PROJECT_VERSION}. The file changelog.gz beside this one says what is new in it.

 -- ${CPACK_PACKAGE_CONTACT}  ${package_date}
")
execute_process(COMMAND gzip -9nc ${changelog_debian} OUTPUT_FILE ${changelog_debian}.gz)
execute_process(COMMAND gzip -9nc ${PROJECT_SOURCE_DIR}/CHANGELOG.md
  OUTPUT_FILE ${CMAKE_CURRENT_BINARY_DIR}/changelog.gz)

# A component as a package; the first line of `about` is its title. Each has the
# licence and the changelogs in its own folder, which a plain install has once.
set(box_words "Duet finds every pair of oriented or axis-aligned boxes that touch, in 2D
and 3D, exactly, and finds out how two OpenCL devices share that work best.")
function(duet_package component name section about)
  string(TOUPPER ${component} upper)
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${name} PARENT_SCOPE)
  set(CPACK_DEBIAN_${upper}_PACKAGE_SECTION ${section} PARENT_SCOPE)
  set(CPACK_COMPONENT_${upper}_DESCRIPTION "${about}" PARENT_SCOPE)
  install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${name} RENAME copyright
    COMPONENT ${component} EXCLUDE_FROM_ALL)
  install(FILES ${CMAKE_CURRENT_BINARY_DIR}/changelog.Debian.gz ${CMAKE_CURRENT_BINARY_DIR}/changelog.gz
    DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${name} COMPONENT ${component} EXCLUDE_FROM_ALL)
endfunction()
duet_package(program duet science "collisions among millions of boxes, by two OpenCL devices
${box_words}
.
This package has the program, which measures, tunes, draws and runs scripts,
with example scenes and experiments.")
duet_package(library libduet${duet_abi} libs "collisions among millions of boxes - shared library
${box_words}
.
This package has the library that applications load.")
duet_package(development libduet-dev libdevel "collisions among millions of boxes - development files
${box_words}
.
This package has what one needs to build applications: headers, the static
library, the files of CMake and pkg-config, and examples.")
duet_package(lua lua-duet interpreters "collisions among millions of boxes - module for Lua 5.4
${box_words}
.
This package has the module that a stock Lua 5.4 finds by require.")
if(DUET_HAS_CLUSTER)
  duet_package(cluster duet-cluster science "collisions among millions of boxes - several machines by MPI
${box_words}
.
This package has what 'duet cluster' runs on each rank of an MPI job, and the
library for applications that do the same.")
endif()

set(opencl_driver "pocl-opencl-icd | opencl-icd")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS "${opencl_driver}, gnuplot-nox")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS "libduet-dev, lua-duet, duet-cluster")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_RECOMMENDS "${opencl_driver}")
file(WRITE ${CMAKE_CURRENT_BINARY_DIR}/triggers "activate-noawait ldconfig\n")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_CONTROL_EXTRA ${CMAKE_CURRENT_BINARY_DIR}/triggers)
set(CPACK_DEBIAN_CLUSTER_PACKAGE_CONTROL_EXTRA ${CMAKE_CURRENT_BINARY_DIR}/triggers)
set(CPACK_DEBIAN_CLUSTER_PACKAGE_DEPENDS
  "duet (= ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE}), openmpi-bin")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS
  "libduet${duet_abi} (= ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})")
# What the static library needs, and duet_opencl.h of the first.
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SUGGESTS
  "ocl-icd-opencl-dev, liblua5.4-dev, libsqlite3-dev, libcjson-dev, libmd-dev, libgmp-dev")
set(CPACK_DEBIAN_LUA_PACKAGE_RECOMMENDS "lua5.4, ${opencl_driver}")
include(CPack)
