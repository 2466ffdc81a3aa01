-- SPDX-License-Identifier: MIT
-- A strategy: bisection on which device finished last.
--
--   duet tune lua/scenes/paper.lua --strategy-lua lua/experiments/bisect.lua
--
-- A's time rises with the share and B's falls, so their difference has one
-- root, and the root is where the longer of the two is least. Each launch
-- halves the interval with certainty, as long as no time is disturbed. Share
-- 0 is measured first, since it is another path: no second device at all.

local launches <const>, quantum <const> = 13, 8 / 65536

-- The ends of the interval that holds the best share.
local function bracket(history)
  local low, high = 0, 1
  for i = 2, #history do
    local at = history[i]
    if at.a <= at.b then low = at.share end
    if at.a >= at.b then high = at.share end
  end
  return low, high
end

local function strategy(history)
  if #history == 0 then return 0 end
  local low, high = bracket(history)
  if #history < launches and high - low > quantum then return (low + high) / 2 end
end

return { strategy = strategy, bracket = bracket }
