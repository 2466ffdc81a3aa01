-- SPDX-License-Identifier: MIT
-- `duet query` tells this, of the object that --json prints, and `name` of the file, `one_device` and the selectors
-- `a` and `b`.
local report = ...
local line, count = report.line, report.count

return function(o)
  line("%s: %s in %.0fD, level %s", o.name, report.things(o.n, "pair", "pairs"), o.dims, o.level)
  line("%s colliding, %s separated, %s left undecided by float", count(o.colliding), count(o.n - o.colliding),
    count(o.undecided))
  if o.one_device then
    line("%.3f ms on %s", 1e3 * o.seconds, o.b)
  else
    line("%.3f ms, A %s %.1f %%, B %s %.1f %%", 1e3 * o.seconds, o.a, 100 * o.share, o.b, 100 * (1 - o.share))
  end
  return report.told
end
