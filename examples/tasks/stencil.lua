-- SPDX-License-Identifier: MIT
return {
  about = "a step of heat on a grid, from a cell and its four neighbours",
  params = {
    { "WG", values = { 1, 16, 64, 256 }, about = "work-items a group",
      default = function(limits) return limits.cpu and 16 or 256 end },
    { "PER_ITEM", values = { 1, 4, 16 }, default = 1, about = "cells a work-item" },
  },
  args = {
    stencil = [[
      ulong first
      ulong last
      uint width
      uint rows
      float rate
      const float *before
      float *after
    ]],
  },
  launch = function(p) return { group = p.WG, per_item = p.PER_ITEM } end,
}
