-- SPDX-License-Identifier: MIT
-- A strategy: golden section search on the total time (Kiefer 1953).
--
--   duet tune lua/scenes/paper.lua --strategy-lua lua/experiments/golden.lua
--
-- Needs no device times, and is the best there is for a function with one
-- minimum and no noise. Share 0 is measured first, since it is another path.

local launches <const>, one <const>, quantum <const> = 13, 65536, 8

-- How far each inner point of an interval lies from its end.
local function step(low, high)
  return math.floor((high - low) * 0.3819660112501051 + 0.5)
end

-- The interval and its two inner points; a point without a total is still to
-- be measured. Shares are out of `one`.
local function play(history)
  local low, high = 0, one
  local left, right = { share = step(low, high) }, { share = high - step(low, high) }
  for i = 2, #history do
    local at = { share = history[i].share * one, total = history[i].total }
    if left.total then right = at else left = at end
    if left.total and right.total then
      -- Drops the part beyond the worse inner point; the better one stays inner.
      if left.total <= right.total then
        high, right = right.share, left
        left = { share = low + step(low, high) }
      else
        low, left = left.share, right
        right = { share = high - step(low, high) }
      end
    end
  end
  return low, high, left.total and right or left
end

return function(history)
  if #history == 0 then return 0 end
  local low, high, next_point = play(history)
  if #history < launches and high - low > 2 * quantum then return next_point.share / one end
end
