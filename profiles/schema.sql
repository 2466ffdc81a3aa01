-- SPDX-License-Identifier: MIT
-- The profile store, schema 1. Needs SQLite 3.37 for STRICT.
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

-- A class of scenes.
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
  level      TEXT NOT NULL
) STRICT;
CREATE INDEX workload_near ON workload (family, n);

-- The text of a tune.lua, once for all its sessions.
CREATE TABLE script (
  key  TEXT PRIMARY KEY,                 -- sha256 of the text
  body TEXT NOT NULL
) STRICT, WITHOUT ROWID;

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
  search_state TEXT CHECK (search_state GLOB '{*}'),
  started_ns   INTEGER NOT NULL,
  heartbeat_ns INTEGER NOT NULL,
  ended_ns     INTEGER
) STRICT, WITHOUT ROWID;
CREATE INDEX session_search ON session (workload_id, pair_id, kernels, started_ns);

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
  flags       INTEGER NOT NULL,          -- 1: warm-up, 2: outlier
  at_ns       INTEGER NOT NULL,
  PRIMARY KEY (trial_id, number)
) STRICT, WITHOUT ROWID;

-- What an application loads. Replaced rows stay, dead, with the reason.
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
  verdict     TEXT NOT NULL CHECK (verdict IN ('faster', 'same', 'slower')),
  missed_rate REAL NOT NULL,             -- pairs missed, by true pairs
  false_rate  REAL NOT NULL,             -- pairs in excess, by true pairs
  origin      TEXT NOT NULL CHECK (origin IN ('measured', 'online', 'manual')),
  session_id  TEXT REFERENCES session (id),
  trial       INTEGER,                   -- that session's trial by number
  created_ns  INTEGER NOT NULL,
  live        INTEGER NOT NULL CHECK (live IN (0, 1)),
  dead_reason TEXT,
  CHECK (origin = 'manual' OR session_id IS NOT NULL),
  CHECK ((live = 1) = (dead_reason IS NULL))
) STRICT;
CREATE UNIQUE INDEX profile_live ON profile (workload_id, pair_id, objective, kernels, level)
  WHERE live = 1;

-- The time of one device's part: what sizes never measured are told from.
-- Its form is in fit.h.
CREATE TABLE fit (
  env_id    INTEGER NOT NULL REFERENCES env (id),
  family    TEXT NOT NULL,
  kernels   TEXT NOT NULL,
  host      TEXT NOT NULL,               -- never of two machines at once
  role      TEXT NOT NULL CHECK (role IN ('a', 'b', 'alone')),
  mode      TEXT NOT NULL,
  level     TEXT NOT NULL,
  variant   TEXT NOT NULL,
  model     BLOB NOT NULL,               -- coefficients and their covariance
  n_points  INTEGER NOT NULL,
  n_min     INTEGER NOT NULL,            -- workload sizes measured
  n_max     INTEGER NOT NULL,
  residual  REAL NOT NULL,               -- relative
  fitted_ns INTEGER NOT NULL,
  PRIMARY KEY (env_id, family, kernels, host, role, mode, level, variant)
) STRICT, WITHOUT ROWID;

-- How the steps of an application compare with its profile.
CREATE TABLE drift (
  profile_id INTEGER PRIMARY KEY REFERENCES profile (id) ON DELETE CASCADE,
  n          INTEGER NOT NULL,
  mean       REAL NOT NULL,
  variance   REAL NOT NULL,
  up         REAL NOT NULL,
  down       REAL NOT NULL,
  at_ns      INTEGER NOT NULL
) STRICT;

-- Imports, merges, prunings and upgrades.
CREATE TABLE audit (
  id     INTEGER PRIMARY KEY,
  at_ns  INTEGER NOT NULL,
  what   TEXT NOT NULL,
  detail TEXT NOT NULL
) STRICT;
