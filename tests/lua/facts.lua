-- SPDX-License-Identifier: MIT
-- What the tests of this folder share: a fact is a name and a function that
-- raises an error where it does not hold.

local facts = { root = assert(os.getenv "DUET_ROOT", "DUET_ROOT is not set; ctest sets it") }
local failed, n = 0, 0

-- facts.holds("a result holds until the next step", function() ... end)
function facts.holds(name, show)
  local ok, message = xpcall(show, debug.traceback)
  n = n + 1
  if not ok then
    failed = failed + 1
    print(("FAILED  %s\n        %s"):format(name, message))
  end
end

function facts.equal(a, b)
  if a ~= b then error(("%s, not %s"):format(tostring(a), tostring(b)), 2) end
end

-- The call raises an error with these words.
function facts.raises(words, call, ...)
  local ok, message = pcall(call, ...)
  if ok then error("raises nothing, for: " .. words, 2) end
  if not tostring(message):find(words, 1, true) then
    error(("raises '%s', not '%s'"):format(message, words), 2)
  end
end

-- The call gives nil, one line with these words, and the status.
function facts.refused(status, words, call, ...)
  local value, message, name = call(...)
  if value ~= nil then error("succeeds, where " .. status .. " was due", 2) end
  if name ~= status then error(("%s (%s), not %s"):format(name, message, status), 2) end
  if message:find "\n" or not message:find(words, 1, true) then
    error(("says '%s', not '%s'"):format(message, words), 2)
  end
end

function facts.read_file(path)
  local file <close> = assert(io.open(path, "rb"))
  return file:read "a"
end

function facts.finish()
  print(("%d facts, %d failed"):format(n, failed))
  os.exit(failed == 0, true)
end

return facts
