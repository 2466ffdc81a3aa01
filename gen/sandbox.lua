-- SPDX-License-Identifier: MIT
-- What makes a script give the same result on every run: pairs in order (Lua's
-- own order changes from run to run), a sort that does not look at the clock
-- for its pivots, and random numbers from a fixed seed. Whatever is written in Lua
-- here is also held to a script's limits like the script itself.

local key_before = ...
local any_order = next
local error, min, type = error, math.min, type
local math_integer, math_most = math.tointeger, math.maxinteger
next = nil

local ordered = { number = true, string = true, boolean = true }

local comparable = { number = true, string = true }

-- Merges the runs lower .. middle - 1 and middle .. upper - 1; of equals the
-- first stays first. Numbers and strings need no `before`.
local function merge(from, to, lower, middle, upper, before)
  local i, j = lower, middle
  for k = lower, upper - 1 do
    local a, b = from[i], from[j]
    local first = i < middle
    if first and j < upper then
      if before then first = not before(b, a) else first = not (b < a) end
    end
    if first then
      to[k], i = a, i + 1
    else
      to[k], j = b, j + 1
    end
  end
end

-- Gives the n values of a list in order: that list, or another one.
local function sort(values, n, before)
  local from, to, width = values, {}, 1
  while width < n do
    for lower = 1, n, 2 * width do
      merge(from, to, lower, min(lower + width, n + 1), min(lower + 2 * width, n + 1), before)
    end
    from, to, width = to, from, 2 * width
  end
  return from
end

local function want(value, kind, place, name)
  if type(value) ~= kind then
    error(("bad argument #%d to '%s' (%s expected, got %s)"):format(place, name, kind, type(value)), 3)
  end
end

-- Equal values stay in their order, whatever function compares.
function table.sort(t, before)
  want(t, "table", 1, "sort")
  if before ~= nil then want(before, "function", 2, "sort") end
  local values, n = {}, #t
  for i = 1, n do
    values[i] = t[i]
    if not before and (type(t[i]) ~= type(t[1]) or not comparable[type(t[1])]) then
      error(("sort: value %d is a %s, and the first a %s: they have no order"):format(i, type(t[i]), type(t[1])), 2)
    end
  end
  local sorted = sort(values, n, before)
  for i = 1, n do t[i] = sorted[i] end
end

local function want_integer(value, place, name)
  local whole = math_integer(value)
  if not whole then
    local what = type(value) == "number" and "number has no integer representation"
      or "number expected, got " .. type(value)
    error(("bad argument #%d to '%s' (%s)"):format(place, name, what), 3)
  end
  return whole
end

-- A range can be longer than any time: Lua's own moves it at one go.
function table.move(from, first, last, at, to)
  to = to == nil and from or to
  want(from, "table", 1, "move")
  first, last = want_integer(first, 2, "move"), want_integer(last, 3, "move")
  at = want_integer(at, 4, "move")
  want(to, "table", 5, "move")
  if last >= first then
    if first <= 0 and last >= math_most + first then error("bad argument #3 to 'move' (too many elements to move)", 2) end
    if at > math_most - (last - first) then error("bad argument #4 to 'move' (destination wrap around)", 2) end
    if at > last or at <= first or to ~= from then
      for i = 0, last - first do to[at + i] = from[first + i] end
    else
      for i = last - first, 0, -1 do to[at + i] = from[first + i] end
    end
  end
  return to
end

-- Numbers, then strings, then false and true.
function pairs(t)
  want(t, "table", 1, "pairs")
  local keys, n = {}, 0
  for key in any_order, t do
    if not ordered[type(key)] then
      error("pairs: a key is a " .. type(key) .. ", which has no order", 2)
    end
    n = n + 1
    keys[n] = key
  end
  keys = sort(keys, n, key_before)
  local i = 0
  return function()
    i = i + 1
    if i <= n then return keys[i], t[keys[i]] end
  end
end

math.randomseed(0)
