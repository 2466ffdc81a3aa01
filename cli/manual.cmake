# Man pages and the completion for bash, written by the program itself once it
# is built. The pages' date is that of the version.
set(manual_dir ${CMAKE_CURRENT_BINARY_DIR}/manual)
file(STRINGS CHANGELOG.md duet_date LIMIT_COUNT 1 REGEX "^## ${PROJECT_VERSION}, ")
string(REGEX REPLACE ".*, " "" duet_date "${duet_date}")
if(NOT duet_date)
  message(FATAL_ERROR "CHANGELOG.md has no heading '## ${PROJECT_VERSION}, YEAR-MONTH-DAY'")
endif()
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS CHANGELOG.md)
add_custom_command(
  OUTPUT ${manual_dir}/duet.bash
  COMMAND ${CMAKE_COMMAND} -E rm -rf ${manual_dir}
  COMMAND ${CMAKE_COMMAND} -E make_directory ${manual_dir}
  COMMAND duet lua --trust ${CMAKE_CURRENT_LIST_DIR}/manual.lua $<TARGET_FILE:duet>
          ${PROJECT_VERSION} ${duet_date} ${CMAKE_CURRENT_LIST_DIR}/examples.md ${manual_dir}
  COMMAND sh -c "gzip -9nk ${manual_dir}/*.1"
  DEPENDS duet ${CMAKE_CURRENT_LIST_DIR}/manual.lua ${CMAKE_CURRENT_LIST_DIR}/examples.md
  VERBATIM)
add_custom_target(duet_manual ALL DEPENDS ${manual_dir}/duet.bash)
install(DIRECTORY ${manual_dir}/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT program
  FILES_MATCHING PATTERN "*.1.gz")
install(FILES ${manual_dir}/duet.bash RENAME duet
  DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions COMPONENT program)
