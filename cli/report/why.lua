-- SPDX-License-Identifier: MIT
-- `duet profiles why` tells this, of the object that --json prints.
local report = ...
local line, number = report.line, report.number

local function tell_subject(o)
  local row = report.columns("ll", "workload", o.workload)
  if not o.one_device then row("A", report.device_words(o.a)) end
  row(o.one_device and "device" or "B", report.device_words(o.b))
end

-- Whether it is "  exact        yes: ...": the grade's end, and where its words begin.
local function split_grade(why, grades)
  local from = 1
  while why:sub(from, from) == " " do from = from + 1 end
  for _, grade in ipairs(grades) do
    if from > 1 and why:sub(from, from + #grade - 1) == grade then
      local words = from + #grade
      while why:sub(words, words) == " " do words = words + 1 end
      return from + #grade - 1, words
    end
  end
end

-- Lines that begin with a grade become rows of a table.
local function tell_grades(o)
  local row
  for _, why in ipairs(o.why) do
    local grade, words = split_grade(why, o.grades)
    if grade then
      row = row or report.columns("ll")
      row(why:sub(1, grade), why:sub(words))
    else
      row = nil
      line("%s", why)
    end
  end
end

local function plan_words(o)
  if o.one_device then return "kernels " .. o.variant_b end
  return ("share %.4f, mode %s, A %s, B %s"):format(o.share, o.mode, o.variant_a, o.variant_b)
end

local function tell_found(o)
  line("%s: %s, level %s", o.grade, plan_words(o), o.level)
  if not o.verdict then
    return line("the plan of another workload: what a step takes and gains here is not known")
  end
  line("a step of %.4g ms%s", o.ms, o.one_device and "" or ", " .. report.gain(o))
  if o.whole_ms then line("%s", report.whole(o.a.name, o.whole, o)) end
  if number(o, "true_pairs") > 0 then line("%s", report.wrong_words(o)) end
end

return function(o)
  tell_subject(o)
  line("")
  tell_grades(o)
  line("")
  if o.level then tell_found(o) else line("%s: %s, of which nothing is known", o.grade, plan_words(o)) end
  return report.told
end
