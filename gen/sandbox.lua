-- SPDX-License-Identifier: MIT
-- What makes a script give the same result on every run: pairs in order (Lua's
-- own order changes from run to run) and random numbers from a fixed seed.

local any_order = next
next = nil

local kinds = { number = 1, string = 2, boolean = 3 }

local function comes_before(a, b)
  local kind_a, kind_b = kinds[type(a)], kinds[type(b)]
  if kind_a ~= kind_b then return kind_a < kind_b end
  if kind_a == 3 then return b and not a end
  return a < b
end

-- Numbers, then strings, then false and true.
function pairs(t)
  if type(t) ~= "table" then
    error("bad argument #1 to 'pairs' (table expected, got " .. type(t) .. ")", 2)
  end
  local keys, n = {}, 0
  for key in any_order, t do
    if not kinds[type(key)] then
      error("pairs: a key is a " .. type(key) .. ", which has no order", 2)
    end
    n = n + 1
    keys[n] = key
  end
  table.sort(keys, comes_before)
  local i = 0
  return function()
    i = i + 1
    if i <= n then return keys[i], t[keys[i]] end
  end
end

math.randomseed(0)
