-- SPDX-License-Identifier: MIT
-- How pages and reports read results, which are untrusted: what is not the number or the name that
-- it should be counts as 0 and "". Returns the table in which each part finds what those before it
-- have.
local report = {}

function report.text(o, name)
  local value = type(o) == "table" and o[name]
  return type(value) == "string" and value or ""
end

function report.number(o, name)
  local value = type(o) == "table" and o[name]
  return type(value) == "number" and math.abs(value) <= 2 ^ 53 and value or 0
end

function report.list(o, name)
  local value = type(o) == "table" and o[name]
  return type(value) == "table" and value or {}
end

-- One device alone is named as A and as B, and is the B that works.
function report.is_one_device(a, b)
  local selector = report.text(a, "selector")
  return selector ~= "" and selector == report.text(b, "selector")
end

function report.is_of_one(p) return p.one_device == true end

-- Whether two have the same mode and kernels.
function report.same_plan(a, b)
  for _, name in ipairs { "mode", "variant_a", "variant_b" } do
    if report.text(a, name) ~= report.text(b, name) then return false end
  end
  return true
end

function report.greatest(rows, value)
  local most = 0
  for _, row in ipairs(rows) do most = math.max(most, value(row)) end
  return most
end

-- "1 234 567"
function report.count(n)
  local digits, groups = ("%.0f"):format(math.floor(n)), {}
  for last = #digits, 1, -3 do table.insert(groups, 1, digits:sub(math.max(last - 2, 1), last)) end
  return table.concat(groups, " ")
end

-- The value of the longest bar or the end of the axis: the greatest value, or the greatest but a
-- few (at most a fifth) that lie far above all others and would make these flat.
function report.most_shown(values)
  table.sort(values)
  local n = #values
  local bound = 3 * (values[math.ceil(0.75 * n)] or 0)
  for i = n, math.max(1, n - n // 5), -1 do
    if bound == 0 or values[i] <= bound then return values[i] end
  end
  return values[n] or 0
end

function report.most_shown_of(rows, value)
  local values = {}
  for i, row in ipairs(rows) do values[i] = value(row) end
  return report.most_shown(values)
end

-- At most so many bytes, and no part of a character.
function report.cut(s, most)
  if #s <= most then return s end
  while most > 0 and s:byte(most + 1) & 0xc0 == 0x80 do most = most - 1 end
  return s:sub(1, most)
end

-- A profile is for a scene and its size, for instance "paper, 100 000", "falling, 2 000, moving", "gravity, 1 000, task
-- gravity" or "paper, 9: 50 rays".
function report.workload_words(p)
  local scene = report.cut(p.scene ~= "" and p.scene or "-", 60)
  if not p.query then return ("%s, %s%s"):format(scene, report.count(p.objects), p.moving and ", moving" or "") end
  return p.objects == 0 and ("%s, %s, %s"):format(scene, report.count(p.items), p.query)
    or ("%s, %s: %s %s"):format(scene, report.count(p.objects), report.count(p.items), p.query)
end

function report.scene_words(one)
  local objects = report.count(report.number(one, "objects"))
  return ("%s, %s objects"):format(report.cut(report.text(one, "scene"), 60), objects)
end

-- A device of a profile.
function report.device_words(d)
  return ("%s%s, driver %s"):format(d.name, d.part ~= "" and (" [%s]"):format(d.part) or "", d.driver)
end

return report
