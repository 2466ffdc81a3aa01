-- SPDX-License-Identifier: MIT
-- A profile store as the sixth version of its schema made it: the rows of store_v4.sql.
PRAGMA application_id = 1146438996;
PRAGMA user_version = 6;
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
  search_state TEXT CHECK (search_state GLOB '{*}'),
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

-- What an application loads. Rows that were replaced, or are not founded well
-- enough to be loaded, stay, dead, with the reason.
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
  CHECK (origin = 'manual' OR session_id IS NOT NULL),
  CHECK ((live = 1) = (dead_reason IS NULL))
) STRICT;
CREATE UNIQUE INDEX profile_live ON profile (workload_id, pair_id, objective, kernels, level)
  WHERE live = 1;

-- Every measured time of one device's part, or of a device that did it all.
CREATE VIEW part AS
  SELECT pair.env_a AS env_id, w.family, s.kernels, s.host,
         CASE t.mode WHEN 'shared' THEN 'a' ELSE 'part' END AS role,
         t.mode, t.level, t.variant_a AS variant,
         w.n, w.n * (t.share / 65536.0) AS own, w.occ_mean AS occupancy, t.a_ns AS time_ns
    FROM workload w JOIN session s ON s.workload_id = w.id
    JOIN pair ON pair.id = s.pair_id JOIN trial t ON t.session_id = s.id
   WHERE t.outcome = 'ok' AND t.share BETWEEN 1 AND 65535 AND t.a_ns > 0
  UNION ALL
  SELECT pair.env_b, w.family, s.kernels, s.host,
         CASE t.mode WHEN 'shared' THEN 'b' ELSE 'part' END,
         t.mode, t.level, t.variant_b,
         w.n, w.n * (1 - t.share / 65536.0), w.occ_mean, t.b_ns
    FROM workload w JOIN session s ON s.workload_id = w.id
    JOIN pair ON pair.id = s.pair_id JOIN trial t ON t.session_id = s.id
   WHERE t.outcome = 'ok' AND t.share BETWEEN 1 AND 65535 AND t.b_ns > 0
  UNION ALL
  SELECT iif(t.share = 0, pair.env_b, pair.env_a), w.family, s.kernels, s.host, 'alone',
         '', t.level, iif(t.share = 0, t.variant_b, t.variant_a),
         w.n, w.n, w.occ_mean, t.median_ns
    FROM workload w JOIN session s ON s.workload_id = w.id
    JOIN pair ON pair.id = s.pair_id JOIN trial t ON t.session_id = s.id
   WHERE t.outcome = 'ok' AND t.share IN (0, 65536);

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

-- What the network between the ranks of an MPI job does, as last measured between rank 0 and the
-- first rank of another machine, or of its own where all are on one.
CREATE TABLE fabric (
  id          INTEGER PRIMARY KEY,
  key         TEXT NOT NULL UNIQUE,      -- sha256 of the four fields below
  mpi         TEXT NOT NULL,             -- the library, with its version
  place       TEXT NOT NULL,             -- sha256 of the ranks' machines in order
  hosts       INTEGER NOT NULL CHECK (hosts BETWEEN 1 AND ranks),
  ranks       INTEGER NOT NULL CHECK (ranks > 0),
  latency_ns  REAL CHECK (latency_ns > 0), -- of 8 bytes, one way; NULL: there is one rank
  byte_ns     REAL CHECK (byte_ns > 0),  -- of each byte of a long message
  times       TEXT CHECK (times GLOB '{*}'), -- of other lengths, in ns: {"64": 812.5}
  measured_ns INTEGER NOT NULL
) STRICT;

-- A run of duet cluster that somebody kept.
CREATE TABLE cluster_run (
  id         INTEGER PRIMARY KEY,
  uid        TEXT NOT NULL UNIQUE,       -- random, the same in every store
  fabric_id  INTEGER NOT NULL REFERENCES fabric (id),
  scene      TEXT NOT NULL,
  dims       INTEGER NOT NULL CHECK (dims IN (2, 3)),
  n          INTEGER NOT NULL CHECK (n >= 0),
  level      TEXT NOT NULL,
  parts      INTEGER NOT NULL CHECK (parts > 0), -- that each rank's objects were searched in
  resident   INTEGER NOT NULL CHECK (resident IN (0, 1)),
  steps      INTEGER NOT NULL CHECK (steps > 0), -- that the times are of
  median_ns  REAL NOT NULL CHECK (low_ns <= median_ns AND median_ns <= high_ns),
  low_ns     REAL NOT NULL,              -- the quickest of them, and the slowest
  high_ns    REAL NOT NULL,
  created_ns INTEGER NOT NULL
) STRICT;

-- What a rank of it did in the last step.
CREATE TABLE cluster_rank (
  run_id     INTEGER NOT NULL REFERENCES cluster_run (id) ON DELETE CASCADE,
  number     INTEGER NOT NULL,
  devices    TEXT NOT NULL,              -- 'A,B'
  n          INTEGER NOT NULL CHECK (n >= 0),
  ghosts     INTEGER NOT NULL CHECK (ghosts >= 0),
  pairs      INTEGER NOT NULL CHECK (pairs >= 0),
  sent_bytes INTEGER NOT NULL CHECK (sent_bytes >= 0),
  busy_ns    REAL NOT NULL CHECK (busy_ns >= 0),
  wait_ns    REAL NOT NULL CHECK (wait_ns >= 0),
  PRIMARY KEY (run_id, number)
) STRICT, WITHOUT ROWID;

-- Imports, merges, prunings and upgrades.
CREATE TABLE audit (
  id     INTEGER PRIMARY KEY,
  at_ns  INTEGER NOT NULL,
  what   TEXT NOT NULL,
  detail TEXT NOT NULL
) STRICT;
INSERT INTO device VALUES (1, 'db088decda112403e2efefd224ce22ef8939e9576b6b7bfe9767643b90a86534', 'cpu', 'AuthenticAMD', 'pthread-haswell-AMD EPYC', NULL, 2, 4096, 524288, 0);
INSERT INTO env VALUES (1, '65bdaf4d90c6d71e6beadd4d1ccaa089ff21342ec607f8001be3674261b7b2dd', 'f7575be072466b5fc66e4c3c8029cb4d5b4ae7446fd3e6fa578744ece5c6ee70', 1, 'Portable Computing Language', 'OpenCL 3.0 PoCL 3.1+debian  Linux, None+Asserts, RELOC, SPIR, LLVM 15.0.6, SLEEF, DISTRO, POCL_DEBUG', '3.1+debian', 'OpenCL 3.0 PoCL HSTR: pthread-x86_64-pc-linux-gnu-haswell', '0-0', 1, NULL);
INSERT INTO env VALUES (2, '7a4e00483ed5898cc4c4fd522f1afa5eff6cb0233bc56c07a668a644a7363236', 'b372b3566a462edc7df93ef2caf26148024285b7adb898959f12c3b8dc6911c9', 1, 'Portable Computing Language', 'OpenCL 3.0 PoCL 3.1+debian  Linux, None+Asserts, RELOC, SPIR, LLVM 15.0.6, SLEEF, DISTRO, POCL_DEBUG', '3.1+debian', 'OpenCL 3.0 PoCL HSTR: pthread-x86_64-pc-linux-gnu-haswell', '1-1', 1, NULL);
INSERT INTO pair VALUES (1, 1, 2);
INSERT INTO workload VALUES (1, 'a8efc3fa9787317f41c918bf2d227c08b16418bf6b6a66aaec4d635bd635870a', '3D poses rotated, level auto, effects: none; sizes 1:128', 'mixed', 3, 5000, 5, 5, 5, 86.5952987670898, 40.0, 62.0, 99.8768005371094, 'poses', 1, '', 'auto', NULL, 0);
INSERT INTO workload VALUES (2, 'd8da5c86360dcf42781a3b1209bef57479ebd10c6cc789e2414d82c01d6bfbeb', '3D poses rotated, level certified, effects: none; sizes 1:128', 'mixed', 3, 5000, 5, 5, 5, 86.5952987670898, 40.0, 62.0, 99.8768005371094, 'poses', 1, '', 'certified', NULL, 0);
INSERT INTO session VALUES ('d19dcdbd665800365d43a7fd50739647', 'complete', 1, 2, 'a925c290a1797498e1cd0c3bacd4ecc7afd862a2208221164fde7db3a5a5c415', 'balance', 'time', '{"seconds":0,"trials":12,"repeats":3,"variants":[],"modes":[]}', 0, NULL, '1.0.0', '0', 7663, 1376146, 0, 1.7333984375, 1.0, '{"trials":[[0,1,"rows","lanes",1,3374522,0,3371426,4,27414565,{"T_1":0.209601,"T_CPU1":0.000000,"T_CPU2":0.000000,"T_GPU1":0.104646,"T_GPU2":0.023955,"T_GPU3":0.002515,"T_BUS1":0.000000,"T_BUS2":0.000000,"T_BUS3":0.000792,"imbalance":-1.000000}],[0,1,"rows","paper",1,21328236,0,21325482,4,2705399617,{"T_1":0.442104,"T_CPU1":0.000000,"T_CPU2":0.000000,"T_GPU1":0.021501,"T_GPU2":17.810388,"T_GPU3":2.333772,"T_BUS1":0.000000,"T_BUS2":0.000000,"T_BUS3":0.000852,"imbalance":-1.000000}],[0,1,"rows","auto sort=radix",1,3882539,0,3879343,4,2441030613,{"T_1":0.284659,"T_CPU1":0.000000,"T_CPU2":0.000000,"T_GPU1":0.178733,"T_GPU2":2.227613,"T_GPU3":0.349331,"T_BUS1":0.000000,"T_BUS2":0.000000,"T_BUS3":0.001112,"imbalance":-1.000000}],[0,1,"rows","rows",1,3452807,0,3449331,4,17674424,{"T_1":0.166092,"T_CPU1":0.000000,"T_CPU2":0.000000,"T_GPU1":0.088164,"T_GPU2":2.154196,"T_GPU3":0.309557,"T_BUS1":0.000000,"T_BUS2":0.000000,"T_BUS3":0.000862,"imbalance":-1.000000}],[0,1,"rows","lanes",1,3277420,0,3274115,4,16450311,{"T_1":0.148177,"T_CPU1":0.000000,"T_CPU2":0.000000,"T_GPU1":0.082354,"T_GPU2":0.010590,"T_GPU3":0.001883,"T_BUS1":0.000000,"T_BUS2":0.000000,"T_BUS3":0.000441,"imbalance":-1.000000}],[0,1,"rows","lanes",1,3543637,0,3541132,4,14151746,{"T_1":0.154607,"T_CPU1":0.000000,"T_CPU2":0.000000,"T_GPU1":0.087072,"T_GPU2":0.024776,"T_GPU3":0.003636,"T_BUS1":0.000000,"T_BUS2":0.000000,"T_BUS3":0.000712,"imbalance":-1.000000}],[4096,1,"rows","lanes",1,3196099,2487468,3173828,4,1629463365,{"T_1":0.096740,"T_CPU1":0.349733,"T_CPU2":0.016460,"T_GPU1":0.059812,"T_GPU2":0.003537,"T_GPU3":0.003507,"T_BUS1":0.000000,"T_BUS2":0.000000,"T_BUS3":0.000431,"imbalance":0.552075}],[0,1,"rows","lanes",1,3039588,0,3037313,3,16075563,{"T_1":0.130133,"T_CPU1":0.000000,"T_CPU2":0.000000,"T_GPU1":0.083075,"T_GPU2":0.023033,"T_GPU3":0.002284,"T_BUS1":0.000000,"T_BUS2":0.000000,"T_BUS3":0.001002,"imbalance":-1.000000}]]}', 1795325919259498176, 1795325926154678282, 1795325926154678282);
INSERT INTO level_cost VALUES (1, 1, 'a925c290a1797498e1cd0c3bacd4ecc7afd862a2208221164fde7db3a5a5c415', 'aabb', 3498724.0, 7110, 0, 11024, 1795325919257029974);
INSERT INTO level_cost VALUES (1, 1, 'a925c290a1797498e1cd0c3bacd4ecc7afd862a2208221164fde7db3a5a5c415', 'certified', 3662048.0, 7110, 0, 0, 1795325919257163583);
INSERT INTO level_cost VALUES (1, 1, 'a925c290a1797498e1cd0c3bacd4ecc7afd862a2208221164fde7db3a5a5c415', 'double', 4123819.0, 7110, 0, 0, 1795325919257191896);
INSERT INTO level_cost VALUES (1, 1, 'a925c290a1797498e1cd0c3bacd4ecc7afd862a2208221164fde7db3a5a5c415', 'sat15', 3622655.0, 7110, 0, 0, 1795325919257133978);
INSERT INTO level_cost VALUES (1, 1, 'a925c290a1797498e1cd0c3bacd4ecc7afd862a2208221164fde7db3a5a5c415', 'sat6', 3643383.0, 7110, 0, 370, 1795325919257105375);
INSERT INTO level_cost VALUES (1, 1, 'a925c290a1797498e1cd0c3bacd4ecc7afd862a2208221164fde7db3a5a5c415', 'sphere', 3453199.0, 7110, 0, 6544, 1795325919257074166);
INSERT INTO trial VALUES (1, 'd19dcdbd665800365d43a7fd50739647', 0, 0, 'own', 'certified', 'auto', 'simd', 'ok', NULL, 0.0, 3, 0, 3374522.0, 1202.0, 3328697.0, 3375724.0, 0.0, 3371426.0, '{"T_1":0.209601,"T_CPU1":0.000000,"T_CPU2":0.000000,"T_GPU1":0.104646,"T_GPU2":0.023955,"T_GPU3":0.002515,"T_BUS1":0.000000,"T_BUS2":0.000000,"T_BUS3":0.000792,"imbalance":-1.000000}', 1795325919308878847);
INSERT INTO trial VALUES (2, 'd19dcdbd665800365d43a7fd50739647', 1, 0, 'own', 'certified', 'auto', 'paper', 'ok', NULL, 0.0, 3, 0, 21328236.0, 1523890.0, 19804346.0, 24222083.0, 0.0, 21325482.0, '{"T_1":0.442104,"T_CPU1":0.000000,"T_CPU2":0.000000,"T_GPU1":0.021501,"T_GPU2":17.810388,"T_GPU3":2.333772,"T_BUS1":0.000000,"T_BUS2":0.000000,"T_BUS3":0.000852,"imbalance":-1.000000}', 1795325922014950396);
INSERT INTO trial VALUES (3, 'd19dcdbd665800365d43a7fd50739647', 2, 0, 'own', 'certified', 'auto', 'auto sort=radix', 'ok', NULL, 0.0, 3, 0, 3882539.0, 50294.0, 3752687.0, 3932833.0, 0.0, 3879343.0, '{"T_1":0.284659,"T_CPU1":0.000000,"T_CPU2":0.000000,"T_GPU1":0.178733,"T_GPU2":2.227613,"T_GPU3":0.349331,"T_BUS1":0.000000,"T_BUS2":0.000000,"T_BUS3":0.001112,"imbalance":-1.000000}', 1795325924456743271);
INSERT INTO trial VALUES (4, 'd19dcdbd665800365d43a7fd50739647', 3, 0, 'own', 'certified', 'auto', 'auto', 'ok', NULL, 0.0, 3, 1, 3452807.0, 32090.0, 3420717.0, 4267667.0, 0.0, 3449331.0, '{"T_1":0.166092,"T_CPU1":0.000000,"T_CPU2":0.000000,"T_GPU1":0.088164,"T_GPU2":2.154196,"T_GPU3":0.309557,"T_BUS1":0.000000,"T_BUS2":0.000000,"T_BUS3":0.000862,"imbalance":-1.000000}', 1795325924475090219);
INSERT INTO trial VALUES (5, 'd19dcdbd665800365d43a7fd50739647', 4, 0, 'own', 'certified', 'auto', 'simd', 'ok', NULL, 0.0, 3, 0, 3277420.0, 156481.0, 3120939.0, 3801287.0, 0.0, 3274115.0, '{"T_1":0.148177,"T_CPU1":0.000000,"T_CPU2":0.000000,"T_GPU1":0.082354,"T_GPU2":0.010590,"T_GPU3":0.001883,"T_BUS1":0.000000,"T_BUS2":0.000000,"T_BUS3":0.000441,"imbalance":-1.000000}', 1795325924492242259);
INSERT INTO trial VALUES (6, 'd19dcdbd665800365d43a7fd50739647', 5, 0, 'own', 'certified', 'auto', 'simd', 'ok', NULL, 0.0, 3, 0, 3543637.0, 26440.0, 3339888.0, 3570077.0, 0.0, 3541132.0, '{"T_1":0.154607,"T_CPU1":0.000000,"T_CPU2":0.000000,"T_GPU1":0.087072,"T_GPU2":0.024776,"T_GPU3":0.003636,"T_BUS1":0.000000,"T_BUS2":0.000000,"T_BUS3":0.000712,"imbalance":-1.000000}', 1795325924507132662);
INSERT INTO trial VALUES (7, 'd19dcdbd665800365d43a7fd50739647', 6, 4096, 'own', 'certified', 'auto', 'simd', 'ok', NULL, 0.0, 3, 0, 3196099.0, 86871.0, 3109228.0, 3303590.0, 2487468.0, 3173828.0, '{"T_1":0.096740,"T_CPU1":0.349733,"T_CPU2":0.016460,"T_GPU1":0.059812,"T_GPU2":0.003537,"T_GPU3":0.003507,"T_BUS1":0.000000,"T_BUS2":0.000000,"T_BUS3":0.000431,"imbalance":0.552075}', 1795325926137320298);
INSERT INTO trial VALUES (8, 'd19dcdbd665800365d43a7fd50739647', 7, 0, 'own', 'certified', 'auto', 'simd', 'ok', NULL, 0.0, 2, 0, 6009981.0, 2970393.0, 3039588.0, 8980374.0, 0.0, 3037313.0, '{"T_1":0.130133,"T_CPU1":0.000000,"T_CPU2":0.000000,"T_GPU1":0.083075,"T_GPU2":0.023033,"T_GPU3":0.002284,"T_BUS1":0.000000,"T_BUS2":0.000000,"T_BUS3":0.001002,"imbalance":-1.000000}', 1795325926154129158);
INSERT INTO sample VALUES (1, 0, 17247919, 0, 6489760, 14346, 0, 1, 1795325919298284634);
INSERT INTO sample VALUES (1, 1, 3375724, 0, 3372839, 1012, 0, 0, 1795325919301683611);
INSERT INTO sample VALUES (1, 2, 3374522, 0, 3371426, 792, 0, 0, 1795325919305080906);
INSERT INTO sample VALUES (1, 3, 3328697, 0, 3325731, 331, 0, 0, 1795325919308430311);
INSERT INTO sample VALUES (2, 0, 2639964381, 0, 1186320832, 3106, 0, 1, 1795325921949064351);
INSERT INTO sample VALUES (2, 1, 19804346, 0, 19801671, 731, 0, 0, 1795325921968885908);
INSERT INTO sample VALUES (2, 2, 21328236, 0, 21325482, 852, 0, 0, 1795325921990230426);
INSERT INTO sample VALUES (2, 3, 24222083, 0, 24218426, 1002, 0, 0, 1795325922014482223);
INSERT INTO sample VALUES (3, 0, 2429374641, 0, 1310435933, 1583, 0, 1, 1795325924444538284);
INSERT INTO sample VALUES (3, 1, 3932833, 0, 3928795, 871, 0, 0, 1795325924448493098);
INSERT INTO sample VALUES (3, 2, 3882539, 0, 3879343, 1112, 0, 0, 1795325924452397918);
INSERT INTO sample VALUES (3, 3, 3752687, 0, 3748810, 972, 0, 0, 1795325924456171905);
INSERT INTO sample VALUES (4, 0, 6451619, 0, 3806017, 470, 0, 1, 1795325924463423125);
INSERT INTO sample VALUES (4, 1, 3452807, 0, 3449331, 862, 0, 0, 1795325924466895419);
INSERT INTO sample VALUES (4, 2, 3420717, 0, 3417772, 481, 0, 0, 1795325924470337317);
INSERT INTO sample VALUES (4, 3, 4267667, 0, 4264822, 551, 0, 2, 1795325924474625242);
INSERT INTO sample VALUES (5, 0, 6167670, 0, 3824892, 762, 0, 1, 1795325924481479772);
INSERT INTO sample VALUES (5, 1, 3801287, 0, 3797069, 1012, 0, 0, 1795325924485301177);
INSERT INTO sample VALUES (5, 2, 3277420, 0, 3274115, 441, 0, 0, 1795325924488601821);
INSERT INTO sample VALUES (5, 3, 3120939, 0, 3118875, 451, 0, 0, 1795325924491742056);
INSERT INTO sample VALUES (6, 0, 3618788, 0, 3615892, 992, 0, 1, 1795325924496143423);
INSERT INTO sample VALUES (6, 1, 3543637, 0, 3541132, 712, 0, 0, 1795325924499706566);
INSERT INTO sample VALUES (6, 2, 3570077, 0, 3566941, 351, 0, 0, 1795325924503297061);
INSERT INTO sample VALUES (6, 3, 3339888, 0, 3265348, 381, 0, 0, 1795325924506658087);
INSERT INTO sample VALUES (7, 0, 1619760214, 862226514, 7707010, 2104, 0, 1, 1795325926127108609);
INSERT INTO sample VALUES (7, 1, 3109228, 1500608, 3081987, 452, 0, 0, 1795325926130240628);
INSERT INTO sample VALUES (7, 2, 3196099, 2487468, 3173828, 1102, 0, 0, 1795325926133458558);
INSERT INTO sample VALUES (7, 3, 3303590, 3069833, 3283422, 952, 0, 0, 1795325926136784299);
INSERT INTO sample VALUES (8, 0, 3994438, 0, 3990961, 1502, 0, 1, 1795325926141571495);
INSERT INTO sample VALUES (8, 1, 8980374, 0, 8976748, 320, 0, 0, 1795325926150571185);
INSERT INTO sample VALUES (8, 2, 3039588, 0, 3037313, 1002, 0, 0, 1795325926153629968);
INSERT INTO profile VALUES (1, '34df0ecc88340b54d8669f0fb037c09f', 1, 2, 'a925c290a1797498e1cd0c3bacd4ecc7afd862a2208221164fde7db3a5a5c415', 'time', 'certified', 0, 'own', 'auto', 'simd', 3039588.0, 3039588.0, 3039588.0, 0.0, 0.0, 0.0, 'ambiguous', 0.0, 0.0, 'measured', 'd19dcdbd665800365d43a7fd50739647', 7, 1795325926154531328, 0, 'too few rounds for a verdict', 7110, 3039588.0, 0, 'own', '{"T_1":0.130133,"T_CPU1":0.000000,"T_CPU2":0.000000,"T_GPU1":0.083075,"T_GPU2":0.023033,"T_GPU3":0.002284,"T_BUS1":0.000000,"T_BUS2":0.000000,"T_BUS3":0.001002,"imbalance":-1.000000}', NULL, NULL, NULL, NULL, NULL);
INSERT INTO profile VALUES (2, '11110ecc88340b54d8669f0fb037c09f', 1, 1, 'a925c290a1797498e1cd0c3bacd4ecc7afd862a2208221164fde7db3a5a5c415', 'time', 'certified', 32768, 'own', 'auto', 'simd', 2000000.0, 2000000.0, 2000000.0, 0.5, 0.4, 0.6, 'faster', 0.0, 0.0, 'measured', 'd19dcdbd665800365d43a7fd50739647', 7, 1795325926154531328, 1, NULL, 7110, 3039588.0, 32768, 'own', '{"T_1":0.130133,"T_CPU1":0.000000,"T_CPU2":0.000000,"T_GPU1":0.083075,"T_GPU2":0.023033,"T_GPU3":0.002284,"T_BUS1":0.000000,"T_BUS2":0.000000,"T_BUS3":0.001002,"imbalance":-1.000000}', NULL, NULL, NULL, NULL, NULL);
INSERT INTO fit VALUES (1, '3D poses rotated, level certified, effects: none; sizes 1:128', 'a925c290a1797498e1cd0c3bacd4ecc7afd862a2208221164fde7db3a5a5c415', '0', 'part', 'own', 'certified', 'auto', 6.21727109434008598336e+05, 1.2434542188679915853e+02, 1.98952675018832087511e+03, 4.97381687547313049418e+01, '4640970761573.6602 -309305257.88991582 -4948884126.2386513 -123722103.15596631 -309305257.88991565 185638.83046294985 -989776.82524775818 -24744.420631193956 -4948884126.2386532 -989776.82524775818 47523540.59851516 -395910.73009910318 -123722103.15596634 -24744.420631193956 -395910.73009910318 29702.212874071971', 3.00002108418696497582e-02, 1, 5000, 5000, 1795349708563663623);
INSERT INTO fit VALUES (2, '3D poses rotated, level certified, effects: none; sizes 1:128', 'a925c290a1797498e1cd0c3bacd4ecc7afd862a2208221164fde7db3a5a5c415', '0', 'alone', '', 'certified', 'auto', 8.63007570567488670361e+05, 1.72601514113513985647e+02, 1.72601514113397570327e+02, 4.31503785283712204545e+00, '8942077598540.3145 -595959716.14143777 -595959716.14143765 -14898992.903535943 -595959716.14143753 357683.10394161911 -119191.94322829085 -2979.7985807072719 -595959716.14143777 -119191.94322829085 357683.10394161911 -2979.7985807072714 -14898992.903535947 -2979.7985807072719 -2979.7985807072714 223.55193996351201', 3.00002108418696115943e-02, 1, 5000, 5000, 1795349708569938222);
INSERT INTO fit VALUES (2, '3D poses rotated, level certified, effects: none; sizes 1:128', 'a925c290a1797498e1cd0c3bacd4ecc7afd862a2208221164fde7db3a5a5c415', '0', 'alone', '', 'certified', 'auto sort=radix', 9.70416403240203857393e+05, 1.94083280648104846474e+02, 1.94083280648046638816e+02, 4.85208201620298495981e+00, '11306429554702.375 -753535906.36403298 -753535906.36403286 -18838397.659100819 -753535906.36403298 452257.18218810338 -150707.18127281073 -3767.6795318202685 -753535906.36403298 -150707.18127281076 452257.18218810332 -3767.6795318202685 -18838397.659100819 -3767.6795318202689 -3767.6795318202685 282.66073886756453', 3.00002108418693236302e-02, 1, 5000, 5000, 1795349708569550209);
INSERT INTO fit VALUES (2, '3D poses rotated, level certified, effects: none; sizes 1:128', 'a925c290a1797498e1cd0c3bacd4ecc7afd862a2208221164fde7db3a5a5c415', '0', 'alone', '', 'certified', 'paper', 5.33085953974533081033e+06, 1.06617190794926136728e+03, 1.06617190794879570603e+03, 2.66542976987257134173e+01, '341195820525214.44 -22739566069.304111 -22739566069.304108 -568489151.73260272 -22739566069.304111 13647832.821008828 -4547913.2138609476 -113697.83034652371 -22739566069.304111 -4547913.2138609486 13647832.821008828 -113697.83034652371 -568489151.73260272 -113697.83034652374 -113697.83034652371 8529.8955131305192', 3.00002108418690772995e-02, 1, 5000, 5000, 1795349708569160773);
INSERT INTO fit VALUES (2, '3D poses rotated, level certified, effects: none; sizes 1:128', 'a925c290a1797498e1cd0c3bacd4ecc7afd862a2208221164fde7db3a5a5c415', '0', 'alone', '', 'certified', 'simd', 8.47800429205417633085e+05, 1.69560085841163527215e+02, 1.69560085840988904234e+02, 4.23900214602326741442e+00, '10408547202156.104 -693817687.08757615 -693817687.08757615 -17345442.177189402 -693817687.08757639 416341.88808628096 -138763.53741753363 -3469.0884354383411 -693817687.08757615 -138763.53741753363 416341.88808628096 -3469.0884354383429 -17345442.177189402 -3469.0884354383415 -3469.0884354383429 260.2136800539256', 0.0365527663774777, 4, 5000, 5000, 1795349708568726483);
INSERT INTO fit VALUES (2, '3D poses rotated, level certified, effects: none; sizes 1:128', 'a925c290a1797498e1cd0c3bacd4ecc7afd862a2208221164fde7db3a5a5c415', '0', 'part', 'own', 'certified', 'simd', 7.93278509826421737672e+05, 1.58655701965326443314e+02, 1.69232748762966366483e+02, 4.23081871907197637483e+00, '7555454627297.5244 -503545909.25701249 -537115636.54081321 -13427890.913520334 -503545909.25701231 302218.18509190658 -107423.12730816565 -2685.5781827041424 -537115636.54081333 -107423.12730816565 343857.13503790257 -2864.6167282177507 -13427890.913520338 -2685.5781827041424 -2864.6167282177507 214.91070939868914', 3.00002108418693930191e-02, 1, 5000, 5000, 1795349708564077445);
