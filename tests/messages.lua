-- SPDX-License-Identifier: MIT
-- Checks that each message in a document's headings is still in the sources:
--
--   duet lua --trust messages.lua DOCUMENT SOURCE...
--
-- "…" stands for what differs.

-- All strings of a C file, those side by side joined, with each conversion and
-- each name between strings as "…".
local function strings(path)
  local text = assert(io.open(path)):read("a")
  text = text:gsub('\\"', "'"):gsub('"%s*"', "")
  text = text:gsub('"%s+PRI%w+%s+"', ""):gsub('"%s*[A-Z_]+%s*"', "")
  return text
end

local sources = {}
for i = 2, #arg do sources[#sources + 1] = strings(arg[i]) end
local all = table.concat(sources, "\n"):gsub("%%[-+.%d]*[lzj]*[a-zA-Z*]", "…")

local n, wrong = 0, 0
for line in io.lines(arg[1]) do
  for message in line:match("^###") and line:gmatch("`([^`]+)`") or function() end do
    n = n + 1
    for piece in (message:gsub("…", "\0") .. "\0"):gmatch("([^%z]*)%z") do
      piece = piece:match("^[ :,;']*(.-)[ :,;']*$")
      if #piece > 3 and not all:find(piece, 1, true) then
        wrong = wrong + 1
        io.stderr:write(("%s: no source says '%s'\n"):format(arg[1], piece))
      end
    end
  end
end
print(n .. " messages")
if wrong > 0 or n == 0 then os.exit(1) end
