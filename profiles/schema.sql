-- SPDX-License-Identifier: MIT
-- The profile store, schema 8. Needs SQLite 3.37 for STRICT.
-- Times end in _ns and are nanoseconds: INTEGER for moments since 1970 and for
-- single launches, REAL for statistics. Shares are integers out of 65536.

-- What a device is. Two specimens of one model are one device.
CREATE TABLE device (
  id           INTEGER PRIMARY KEY,
  key          TEXT NOT NULL UNIQUE,     -- sha256 of the fields below
  kind         TEXT NOT NULL CHECK (kind IN ('cpu', 'gpu', 'accel')),
  vendor       TEXT NOT NULL,
  name         TEXT NOT NULL,
  arch         TEXT,
  units        INTEGER NOT NULL CHECK (units > 0),
  max_group    INTEGER NOT NULL,
  local_bytes  INTEGER NOT NULL,
  global_bytes INTEGER NOT NULL
) STRICT;

-- A device with the software that drives it and the limits set on it.
CREATE TABLE env (
  id               INTEGER PRIMARY KEY,
  key              TEXT NOT NULL UNIQUE, -- sha256 of the fields below
  seat             TEXT NOT NULL,        -- the same without versions
  device_id        INTEGER NOT NULL REFERENCES device (id),
  platform         TEXT NOT NULL,
  platform_version TEXT NOT NULL,
  driver           TEXT NOT NULL,
  cl_version       TEXT NOT NULL,
  part             TEXT,                 -- '0-0' for a part of a CPU
  part_units       INTEGER NOT NULL,
  limits           TEXT                  -- clock lock, power cap, affinity, governor
) STRICT;
CREATE INDEX env_seat ON env (seat);

-- Ordered: A takes the share, B the rest.
CREATE TABLE pair (
  id    INTEGER PRIMARY KEY,
  env_a INTEGER NOT NULL REFERENCES env (id),
  env_b INTEGER NOT NULL REFERENCES env (id),
  UNIQUE (env_a, env_b)
) STRICT;

-- A class of scenes, or of what a tree is asked.
CREATE TABLE workload (
  id         INTEGER PRIMARY KEY,
  key        TEXT NOT NULL UNIQUE,       -- sha256 of the fields below but the name
  family     TEXT NOT NULL,              -- what neighbours of other sizes share
  name       TEXT,                       -- the scene's, for people
  dims       INTEGER NOT NULL CHECK (dims IN (2, 3)),
  n          INTEGER NOT NULL CHECK (n > 0),
  cells_x    INTEGER NOT NULL,
  cells_y    INTEGER NOT NULL,
  cells_z    INTEGER NOT NULL,
  cell       REAL NOT NULL,
  occ_mean   REAL NOT NULL,
  occ_p99    REAL NOT NULL,
  size_ratio REAL NOT NULL,
  shape      TEXT NOT NULL,
  rotated    INTEGER NOT NULL CHECK (rotated IN (0, 1)),
  effects    TEXT NOT NULL,              -- words, sorted
  level      TEXT NOT NULL,
  query      TEXT,                       -- 'rays closest'; n are its items. NULL: steps of a world
  boxes      INTEGER NOT NULL DEFAULT 0  -- in the tree that is asked; 0: there is none
) STRICT;
CREATE INDEX workload_near ON workload (family, n);

-- The text of a tune.lua, once for all its sessions.
CREATE TABLE script (
  id   INTEGER PRIMARY KEY,
  key  TEXT NOT NULL UNIQUE,             -- sha256 of the text
  body TEXT NOT NULL
) STRICT;

-- One search for one workload on one pair.
CREATE TABLE session (
  id           TEXT PRIMARY KEY,         -- random, the same in every store
  state        TEXT NOT NULL CHECK (state IN ('running', 'complete', 'stopped', 'failed')),
  pair_id      INTEGER NOT NULL REFERENCES pair (id),
  workload_id  INTEGER NOT NULL REFERENCES workload (id),
  kernels      TEXT NOT NULL,            -- sha256 of all kernel text
  strategy     TEXT NOT NULL,
  objective    TEXT NOT NULL,
  options      TEXT NOT NULL CHECK (options GLOB '{*}'),
  seed         INTEGER NOT NULL,         -- as a signed number
  script       TEXT REFERENCES script (key),
  tool_version TEXT NOT NULL,
  host         TEXT NOT NULL,            -- sha256 of the machine's id
  pid          INTEGER NOT NULL,
  pid_start    INTEGER NOT NULL,         -- tells a process from a later one of that number
  resumed      INTEGER NOT NULL DEFAULT 0,
  load         REAL,
  timer_ns     REAL,
  started_ns   INTEGER NOT NULL,
  heartbeat_ns INTEGER NOT NULL,
  ended_ns     INTEGER
) STRICT, WITHOUT ROWID;
CREATE INDEX session_search ON session (workload_id, pair_id, kernels, started_ns);

-- What each level of accuracy finds on a workload, and what a step takes at it.
CREATE TABLE level_cost (
  pair_id     INTEGER NOT NULL REFERENCES pair (id),
  workload_id INTEGER NOT NULL REFERENCES workload (id), -- of level 'auto'
  kernels     TEXT NOT NULL,
  level       TEXT NOT NULL,
  step_ns     REAL NOT NULL CHECK (step_ns > 0),
  true_pairs  INTEGER NOT NULL CHECK (true_pairs >= 0),
  missed      INTEGER NOT NULL CHECK (missed BETWEEN 0 AND true_pairs),
  invented    INTEGER NOT NULL CHECK (invented >= 0),
  created_ns  INTEGER NOT NULL,
  PRIMARY KEY (pair_id, workload_id, kernels, level)
) STRICT, WITHOUT ROWID;

-- One plan, measured.
CREATE TABLE trial (
  id         INTEGER PRIMARY KEY,
  session_id TEXT NOT NULL REFERENCES session (id) ON DELETE CASCADE,
  number     INTEGER NOT NULL,           -- from 0 in its session
  share      INTEGER NOT NULL CHECK (share BETWEEN 0 AND 65536),
  mode       TEXT NOT NULL CHECK (mode IN ('shared', 'own', 'slab')),
  level      TEXT NOT NULL,
  variant_a  TEXT NOT NULL,
  variant_b  TEXT NOT NULL,
  outcome    TEXT NOT NULL
             CHECK (outcome IN ('ok', 'build', 'launch', 'wrong', 'timeout', 'pruned')),
  reason     TEXT,
  build_ms   REAL NOT NULL,
  launches   INTEGER NOT NULL,           -- measured; prune leaves it as it was
  outliers   INTEGER NOT NULL,
  median_ns  REAL,
  mad_ns     REAL,
  low_ns     REAL,                       -- the median's interval
  high_ns    REAL,
  a_ns       REAL,                       -- median of A's part
  b_ns       REAL,
  terms      TEXT CHECK (terms GLOB '{*}'),
  created_ns INTEGER NOT NULL,
  disturbed  INTEGER NOT NULL DEFAULT 0, -- launches that count although other programs disturbed them
  focus_ns   INTEGER NOT NULL DEFAULT 0, -- the typical launch's in the stages whose kernel was varied
  spent_ns   INTEGER NOT NULL DEFAULT 0, -- on the trial by the clock, builds included
  scope      INTEGER NOT NULL            -- how much of the work its launches did; below 0: on the
             DEFAULT 65536               -- device that A and B are parts of
             CHECK (abs(scope) BETWEEN 1 AND 65536),
  UNIQUE (session_id, number),
  CHECK (outcome <> 'ok' OR (launches > 0 AND low_ns <= median_ns AND median_ns <= high_ns))
) STRICT;

-- Every launch.
CREATE TABLE sample (
  trial_id    INTEGER NOT NULL REFERENCES trial (id) ON DELETE CASCADE,
  number      INTEGER NOT NULL,
  total_ns    INTEGER NOT NULL,
  a_ns        INTEGER NOT NULL,
  b_ns        INTEGER NOT NULL,
  transfer_ns INTEGER NOT NULL,
  merge_ns    INTEGER NOT NULL,
  flags       INTEGER NOT NULL,          -- 1: warm-up, 2: outlier, 4: disturbed, and repeated
  at_ns       INTEGER NOT NULL,
  cpu_ns      INTEGER NOT NULL DEFAULT 0, -- processor time of the calling thread and the busiest other
  wait_ns     INTEGER NOT NULL DEFAULT 0, -- the longest that a thread waited for a core
  PRIMARY KEY (trial_id, number)
) STRICT, WITHOUT ROWID;

-- What an application loads. Rows that were replaced, or have too little evidence
-- to be loaded, stay, dead, with the reason.
CREATE TABLE profile (
  id          INTEGER PRIMARY KEY,
  uid         TEXT NOT NULL UNIQUE,      -- random, the same in every store
  pair_id     INTEGER NOT NULL REFERENCES pair (id),
  workload_id INTEGER NOT NULL REFERENCES workload (id),
  kernels     TEXT NOT NULL,
  objective   TEXT NOT NULL,
  level       TEXT NOT NULL,
  share       INTEGER NOT NULL CHECK (share BETWEEN 0 AND 65536),
  mode        TEXT NOT NULL CHECK (mode IN ('shared', 'own', 'slab')),
  variant_a   TEXT NOT NULL,
  variant_b   TEXT NOT NULL,
  median_ns   REAL NOT NULL CHECK (low_ns <= median_ns AND median_ns <= high_ns),
  low_ns      REAL NOT NULL,
  high_ns     REAL NOT NULL,
  gain        REAL NOT NULL,             -- over the best single device
  gain_low    REAL NOT NULL,
  gain_high   REAL NOT NULL,
  verdict     TEXT NOT NULL
              CHECK (verdict IN ('faster', 'same', 'slower', 'ambiguous')),
  missed_rate REAL NOT NULL,             -- pairs missed, by true pairs
  false_rate  REAL NOT NULL,             -- pairs in excess, by true pairs
  origin      TEXT NOT NULL CHECK (origin IN ('measured', 'online', 'manual')),
  session_id  TEXT REFERENCES session (id),
  trial       INTEGER,                   -- that session's trial by number
  created_ns  INTEGER NOT NULL,
  live        INTEGER NOT NULL CHECK (live IN (0, 1)),
  dead_reason TEXT,
  true_pairs  INTEGER,                   -- that the rates are of; NULL: they were not measured
  single_ns   REAL,                      -- a step by the best single device
  best_share  INTEGER CHECK (best_share BETWEEN 0 AND 65536), -- of the plan that the gain is of
  best_mode   TEXT CHECK (best_mode IN ('shared', 'own', 'slab')),
  terms       TEXT CHECK (terms GLOB '{*}'),                  -- and its equations 4 to 6
  rounds      INTEGER,                   -- of the race that the gain is of; NULL: not known
  whole_ns    REAL,                      -- a step by the device that A and B are parts of;
  whole_gain  REAL,                      -- NULL: they are of none, or it was not raced.
  whole_gain_low  REAL,                  -- What the plan gains over it
  whole_gain_high REAL,
  watched     INTEGER NOT NULL DEFAULT 0, -- launches whose threads were watched
  disturbed   INTEGER NOT NULL DEFAULT 0, -- and those of them that waited for a core
  CHECK (disturbed <= watched),
  CHECK (origin = 'manual' OR session_id IS NOT NULL),
  CHECK ((live = 1) = (dead_reason IS NULL))
) STRICT;
CREATE UNIQUE INDEX profile_live ON profile (workload_id, pair_id, objective, kernels, level)
  WHERE live = 1;

-- Every measured time of one device's part, or of a device that did it all, unless other programs
-- disturbed it.
CREATE VIEW part AS
  SELECT pair.env_a AS env_id, w.family, s.kernels, s.host,
         CASE t.mode WHEN 'shared' THEN 'a' ELSE 'part' END AS role,
         t.mode, t.level, t.variant_a AS variant,
         w.n, w.n * (t.share / 65536.0) AS own, w.occ_mean AS occupancy, t.a_ns AS time_ns
    FROM workload w JOIN session s ON s.workload_id = w.id
    JOIN pair ON pair.id = s.pair_id JOIN trial t ON t.session_id = s.id
   WHERE t.outcome = 'ok' AND t.scope = 65536 AND t.disturbed = 0 AND t.share BETWEEN 1 AND 65535 AND t.a_ns > 0
  UNION ALL
  SELECT pair.env_b, w.family, s.kernels, s.host,
         CASE t.mode WHEN 'shared' THEN 'b' ELSE 'part' END,
         t.mode, t.level, t.variant_b,
         w.n, w.n * (1 - t.share / 65536.0), w.occ_mean, t.b_ns
    FROM workload w JOIN session s ON s.workload_id = w.id
    JOIN pair ON pair.id = s.pair_id JOIN trial t ON t.session_id = s.id
   WHERE t.outcome = 'ok' AND t.scope = 65536 AND t.disturbed = 0 AND t.share BETWEEN 1 AND 65535 AND t.b_ns > 0
  UNION ALL
  SELECT iif(t.share = 0, pair.env_b, pair.env_a), w.family, s.kernels, s.host, 'alone',
         '', t.level, iif(t.share = 0, t.variant_b, t.variant_a),
         w.n, w.n, w.occ_mean, t.median_ns
    FROM workload w JOIN session s ON s.workload_id = w.id
    JOIN pair ON pair.id = s.pair_id JOIN trial t ON t.session_id = s.id
   WHERE t.outcome = 'ok' AND t.scope = 65536 AND t.disturbed = 0 AND t.share IN (0, 65536);

-- What the parts' times follow, so that sizes never measured can be told:
-- time = base + each * n + own * w + crowd * w * occupancy, in ns, for a device
-- that does w of n objects.
CREATE TABLE fit (
  env_id     INTEGER NOT NULL REFERENCES env (id),
  family     TEXT NOT NULL,
  kernels    TEXT NOT NULL,
  host       TEXT NOT NULL,              -- never of two machines at once
  role       TEXT NOT NULL CHECK (role IN ('a', 'b', 'part', 'alone')),
  mode       TEXT NOT NULL,
  level      TEXT NOT NULL,
  variant    TEXT NOT NULL,
  base       REAL NOT NULL,
  each       REAL NOT NULL,
  own        REAL NOT NULL,
  crowd      REAL NOT NULL,
  covariance TEXT NOT NULL,              -- of these four, by rows, 16 numbers
  residual   REAL NOT NULL,              -- relative, one standard deviation
  points     INTEGER NOT NULL,
  n_min      INTEGER NOT NULL,           -- sizes measured
  n_max      INTEGER NOT NULL,
  fitted_ns  INTEGER NOT NULL,
  PRIMARY KEY (env_id, family, kernels, host, role, mode, level, variant)
) STRICT, WITHOUT ROWID;

-- Imports, merges, prunings and upgrades.
CREATE TABLE audit (
  id     INTEGER PRIMARY KEY,
  at_ns  INTEGER NOT NULL,
  what   TEXT NOT NULL,
  detail TEXT NOT NULL
) STRICT;
