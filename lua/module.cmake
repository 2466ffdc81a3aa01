# duet.so, which `require "duet"` of a stock Lua 5.4 finds in package.cpath. It
# holds the whole library and uses the Lua that loads it.
set(DUET_LUA_DIR ${CMAKE_INSTALL_LIBDIR}/lua/5.4 CACHE STRING "Where duet.so is installed")

add_library(duet_lua MODULE ${duet_objects})
set_target_properties(duet_lua PROPERTIES PREFIX "" OUTPUT_NAME duet
  LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/lua)
target_link_libraries(duet_lua PRIVATE ${duet_needs} duet_options)
install(TARGETS duet_lua LIBRARY DESTINATION ${DUET_LUA_DIR} COMPONENT lua)

# What an editor knows of the API, made from its list.
set(definitions ${PROJECT_BINARY_DIR}/lua/definitions/duet.lua)
file(MAKE_DIRECTORY ${PROJECT_BINARY_DIR}/lua/definitions)
add_custom_command(OUTPUT ${definitions}
  COMMAND duet lua --trust ${CMAKE_CURRENT_LIST_DIR}/define.lua ${CMAKE_CURRENT_LIST_DIR}/api.lua
          > ${definitions}
  DEPENDS duet ${CMAKE_CURRENT_LIST_DIR}/define.lua ${CMAKE_CURRENT_LIST_DIR}/api.lua VERBATIM)
add_custom_target(duet_definitions ALL DEPENDS ${definitions})
install(FILES ${definitions} DESTINATION ${CMAKE_INSTALL_DATADIR}/duet/lua/definitions
  COMPONENT lua)
