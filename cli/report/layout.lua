-- SPDX-License-Identifier: MIT
-- Lays out what a report tells: lines as they are, and tables in columns as wide as their widest cell. Columns of words
-- are folded if rows are wider than the terminal that shows them (terminal_width; nil: none does, and rows stay whole,
-- as grep wants them).
local tell = ...

local gap <const>, folded_least <const> = 2, 12

-- In characters.
local function width_of(cell) return utf8.len(cell) or #cell end

-- Whether a line may end after that byte of a cell.
local function is_break(cell, i)
  local c, after = cell:sub(i, i), cell:sub(i + 1, i + 1):lower()
  return c == " " or c == "," or c == "." and after >= "a" and after <= "z"
end

local function longest_word(cell)
  local longest, length = 0, 0
  for i = 1, #cell do
    length = length + 1
    longest = math.max(longest, length)
    if is_break(cell, i) then length = 0 end
  end
  return longest
end

-- The greatest size of each column's cells.
local function measure(rows, size_of)
  local greatest = {}
  for _, row in ipairs(rows) do
    for i, cell in ipairs(row) do greatest[i] = math.max(greatest[i] or 0, size_of(cell)) end
  end
  return greatest
end

-- The widest columns of words become narrower, each down to its least width at most, until a row fits.
local function fit(align, widths, least)
  local all = -gap
  for _, width in ipairs(widths) do all = all + width + gap end
  while all > terminal_width do
    local widest
    for i, width in ipairs(widths) do
      local is_wider = not widest or width > widths[widest]
      if is_wider and align:sub(i, i) == "l" and width > least[i] then widest = i end
    end
    if not widest then return end
    widths[widest], all = widths[widest] - 1, all - 1
  end
end

-- Between words if that does, else through them.
local function fold(align, rows, widths)
  local least = {}
  for i in ipairs(widths) do least[i] = folded_least end
  fit(align, widths, measure(rows, longest_word))
  fit(align, widths, least)
end

-- The bytes of a cell that fill a line of its column: up to where a word ends, or else as many characters as fit.
local function line_length(cell, width)
  if width_of(cell) <= width then return #cell end
  local n, whole = (utf8.offset(cell, width + 1) or #cell + 1) - 1, nil
  for i = 1, n do
    if is_break(cell, i) then whole = i end
  end
  return cell:sub(n + 1, n + 1) ~= " " and whole or n
end

-- Without blanks at either end.
local function trim(words)
  local first, last = 1, #words
  while words:byte(last) == 32 do last = last - 1 end
  while words:byte(first) == 32 do first = first + 1 end
  return words:sub(first, last)
end

-- Cells that are wider than their column go on in the lines below.
local function add_row(lines, align, widths, rests)
  local more = true
  while more do
    local cells, last = {}, #rests
    while last > 1 and trim(rests[last]) == "" do last = last - 1 end
    more = false
    for i = 1, last do
      local n = line_length(rests[i], widths[i])
      local words = rests[i]:sub(1, n)
      while words:byte(-1) == 32 do words = words:sub(1, -2) end
      local pad = (" "):rep(widths[i] - width_of(words))
      cells[i] = align:sub(i, i) == "r" and pad .. words or words .. (i < last and pad or "")
      rests[i] = trim(rests[i]:sub(n + 1))
      more = more or rests[i] ~= ""
    end
    lines[#lines + 1] = table.concat(cells, (" "):rep(gap))
  end
end

-- A list of the alignment of columns, l or r each, and cells.
local function add_table(lines, told)
  local align, rows = told[1], {}
  for from = 2, #told - #align + 1, #align do rows[#rows + 1] = table.move(told, from, from + #align - 1, 1, {}) end
  local widths = measure(rows, width_of)
  if terminal_width then fold(align, rows, widths) end
  for _, row in ipairs(rows) do add_row(lines, align, widths, row) end
end

return function(o)
  local lines = {}
  for _, told in ipairs(tell(o)) do
    if type(told) == "string" then lines[#lines + 1] = told else add_table(lines, told) end
  end
  return #lines > 0 and table.concat(lines, "\n") .. "\n" or ""
end
