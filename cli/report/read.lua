-- SPDX-License-Identifier: MIT
-- How pages and reports read results, which are untrusted: what is not the number or the name that
-- it should be counts as 0 and "". Returns the table in which each part finds what those before it
-- have.
local report = {}

local function text(o, name)
  local value = type(o) == "table" and o[name]
  return type(value) == "string" and value or ""
end

local function number(o, name)
  local value = type(o) == "table" and o[name]
  return type(value) == "number" and math.abs(value) <= 2 ^ 53 and value or 0
end

local function list(o, name)
  local value = type(o) == "table" and o[name]
  return type(value) == "table" and value or {}
end

-- One device alone is named as A and as B, and is the B that works.
local function is_one_device(a, b) return text(a, "selector") ~= "" and text(a, "selector") == text(b, "selector") end

local function is_of_one(p) return p.one_device == true end

-- Whether two have the same mode and kernels.
local function same_plan(a, b)
  return text(a, "mode") == text(b, "mode") and text(a, "variant_a") == text(b, "variant_a")
    and text(a, "variant_b") == text(b, "variant_b")
end

local function greatest(rows, value)
  local most = 0
  for _, row in ipairs(rows) do most = math.max(most, value(row)) end
  return most
end

-- "1 234 567"
local function count(n)
  local digits, groups = ("%.0f"):format(math.floor(n)), {}
  for last = #digits, 1, -3 do table.insert(groups, 1, digits:sub(math.max(last - 2, 1), last)) end
  return table.concat(groups, " ")
end

-- What the longest bar or the axis stands for: the greatest value, or the greatest but a
-- few (at most a fifth) that lie far above all others and would make these flat.
local function most_shown(values)
  table.sort(values)
  local n = #values
  local bound = 3 * (values[math.ceil(0.75 * n)] or 0)
  for i = n, math.max(1, n - n // 5), -1 do
    if bound == 0 or values[i] <= bound then return values[i] end
  end
  return values[n] or 0
end

local function most_shown_of(rows, value)
  local values = {}
  for i, row in ipairs(rows) do values[i] = value(row) end
  return most_shown(values)
end

-- At most so many bytes, and no part of a character.
local function cut(s, most)
  if #s <= most then return s end
  while most > 0 and s:byte(most + 1) & 0xc0 == 0x80 do most = most - 1 end
  return s:sub(1, most)
end

local function scene_words(one)
  return ("%s, %s objects"):format(cut(text(one, "scene"), 60), count(number(one, "objects")))
end

-- A device of a profile.
local function device_words(d)
  return ("%s%s, driver %s"):format(d.name, d.part ~= "" and (" [%s]"):format(d.part) or "", d.driver)
end

report.device_words = device_words
report.text = text
report.number = number
report.list = list
report.is_one_device = is_one_device
report.is_of_one = is_of_one
report.same_plan = same_plan
report.greatest = greatest
report.count = count
report.most_shown = most_shown
report.most_shown_of = most_shown_of
report.cut = cut
report.scene_words = scene_words
return report
