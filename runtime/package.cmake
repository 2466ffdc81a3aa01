# `cpack -G DEB` makes one Debian package of what `cmake --install` installs. It
# needs dpkg-dev, which finds out what the package depends on.
set(CPACK_PACKAGE_NAME duet)
set(CPACK_PACKAGE_VENDOR "The Duet authors")
# Who builds a package answers for it: DEBFULLNAME and DEBEMAIL, as for Debian's
# own tools. Without them there is no address to give.
if(DEFINED ENV{DEBFULLNAME} AND DEFINED ENV{DEBEMAIL})
  set(CPACK_PACKAGE_CONTACT "$ENV{DEBFULLNAME} <$ENV{DEBEMAIL}>")
else()
  set(CPACK_PACKAGE_CONTACT "The Duet authors")
endif()
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION
  "A program, a C library and a module for Lua 5.4 that find every pair of
oriented or axis-aligned boxes that touch, in 2D and 3D, exactly, and find
out how two OpenCL devices share that work best.")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_GENERATOR DEB)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "pocl-opencl-icd | opencl-icd, gnuplot-nox")
include(CPack)
