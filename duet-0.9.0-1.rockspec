-- SPDX-License-Identifier: MIT
-- For LuaRocks, in a checkout: luarocks --lua-version 5.4 make
rockspec_format = "3.0"
package = "duet"
version = "0.9.0-1"
source = { url = "file://." } -- built from the checkout that it lies in
description = {
  summary = "Collisions among millions of boxes, shared between two OpenCL devices",
  detailed = "Finds every collision among oriented and axis-aligned boxes in 2D and 3D, " ..
    "on two OpenCL devices together, and finds out how they share the work best.",
  license = "MIT",
}
supported_platforms = { "linux" }
dependencies = { "lua >= 5.4, < 5.5" }
external_dependencies = {
  OPENCL = { header = "CL/cl.h" },
  SQLITE = { header = "sqlite3.h" },
}
build = {
  type = "cmake",
  variables = { CMAKE_BUILD_TYPE = "RelWithDebInfo", BUILD_TESTING = "OFF" },
  install_pass = false, -- a rock has the module and the program, not the C library
  install = {
    lib = { duet = "build.luarocks/lua/duet.so" },
    bin = { duet = "build.luarocks/duet" },
  },
}
