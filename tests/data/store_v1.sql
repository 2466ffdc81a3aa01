-- SPDX-License-Identifier: MIT
-- A profile store as the first version of its schema made it, with one workload
-- tuned at two levels of accuracy.
PRAGMA application_id = 1146438996;
PRAGMA user_version = 1;
CREATE TABLE audit (
  id     INTEGER PRIMARY KEY,
  at_ns  INTEGER NOT NULL,
  what   TEXT NOT NULL,
  detail TEXT NOT NULL
) STRICT;
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
INSERT INTO "device" VALUES(1,'198445640af63ee781a726c3162e6e07a7b9b8e4bfc7ec681bf28f362f94aeeb','cpu','AuthenticAMD','pthread-AMD EPYC 7763 64-Core Processor',NULL,2,4096,524288,0);
INSERT INTO "device" VALUES(2,'854645e8eeae162a10ea46a856ec33c6a4550c8a0e6771c6d1b61d872ae6167d','gpu','NVIDIA Corporation','NVIDIA H200',NULL,132,1024,49152,150000000000);
CREATE TABLE drift (
  profile_id INTEGER PRIMARY KEY REFERENCES profile (id) ON DELETE CASCADE,
  n          INTEGER NOT NULL,
  mean       REAL NOT NULL,
  variance   REAL NOT NULL,
  up         REAL NOT NULL,
  down       REAL NOT NULL,
  at_ns      INTEGER NOT NULL
) STRICT;
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
INSERT INTO "env" VALUES(1,'2162b337173e1db31db0dd34af7b482851a712d2184f11817fb84626e7248aac','556de4cd8a019056e7b62ec8cc655acd2a0b42e3b6465a9fb6349ba99517644f',1,'Portable Computing Language','OpenCL 3.0 PoCL 3.1','3.1','OpenCL 3.0','0-0',1,NULL);
INSERT INTO "env" VALUES(2,'a2e8f31637fbfefd9a069248bc5b84cf65356835d730b69ce5e51561168ad6e2','c58ab864d4145c0c930a3b2aa5b7fcc76d12ac0cb420264ebb10a969ec6f8162',2,'NVIDIA CUDA','OpenCL 3.0 CUDA 12.4','550.54','OpenCL 3.0',NULL,0,NULL);
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
CREATE TABLE pair (
  id    INTEGER PRIMARY KEY,
  env_a INTEGER NOT NULL REFERENCES env (id),
  env_b INTEGER NOT NULL REFERENCES env (id),
  UNIQUE (env_a, env_b)
) STRICT;
INSERT INTO "pair" VALUES(1,1,2);
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
  CHECK (origin = 'manual' OR session_id IS NOT NULL),
  CHECK ((live = 1) = (dead_reason IS NULL))
) STRICT;
INSERT INTO "profile" VALUES(1,'1223872e9782565e5ad61522434bb0ea',1,1,'5b1d0c0ffee00000000000000000000000000000000000000000000000000001','time','certified',8192,'own','rows','rows sort=radix',59750.0,59152.5,60347.5,0.12,0.1,0.14,'faster',0.0,0.0,'measured','ebfb2a3c09753f7b3827f25a03105802',1,1795259924514754886,1,NULL);
INSERT INTO "profile" VALUES(2,'a8bb83be2818e5f38de6db70d3f10a35',1,2,'5b1d0c0ffee00000000000000000000000000000000000000000000000000001','time','sat6',8192,'own','rows','rows sort=radix',59750.0,59152.5,60347.5,0.12,0.1,0.14,'faster',0.0,0.0,'measured','8c634a55fd8a7cc3a75b5dc0082f0a00',1,1795259924525496347,1,NULL);
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
CREATE TABLE script (
  id   INTEGER PRIMARY KEY,
  key  TEXT NOT NULL UNIQUE,             -- sha256 of the text
  body TEXT NOT NULL
) STRICT;
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
INSERT INTO "session" VALUES('8c634a55fd8a7cc3a75b5dc0082f0a00','complete',1,2,'5b1d0c0ffee00000000000000000000000000000000000000000000000000001','balance','time','{"launches":16}',1,NULL,'1.0.0','0000000000000000000000000000000000000000000000000000000000000000',20586,1410467,0,0.5,30.0,NULL,1795259924516194501,1795259924525541263,1795259924525541263);
INSERT INTO "session" VALUES('ebfb2a3c09753f7b3827f25a03105802','complete',1,1,'5b1d0c0ffee00000000000000000000000000000000000000000000000000001','balance','time','{"launches":16}',1,NULL,'1.0.0','0000000000000000000000000000000000000000000000000000000000000000',20586,1410467,0,0.5,30.0,NULL,1795259924513348239,1795259924514876656,1795259924514876656);
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
INSERT INTO "trial" VALUES(2,'ebfb2a3c09753f7b3827f25a03105802',1,8192,'own','certified','rows','rows sort=radix','ok',NULL,12.5,3,0,59750.0,1.0,59152.5,60347.5,57250.0,59750.0,'{"T_CPU1":1.5}',1795259924513739770);
INSERT INTO "trial" VALUES(11,'8c634a55fd8a7cc3a75b5dc0082f0a00',1,8192,'own','certified','rows','rows sort=radix','ok',NULL,12.5,3,0,59750.0,1.0,59152.5,60347.5,57250.0,59750.0,'{"T_CPU1":1.5}',1795259924516409389);
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
INSERT INTO "workload" VALUES(1,'3d26699f3996c52be50bf46e00fd279c4b7b2a30b78f07bbbc5e73329244f6cd','3D poses rotated, level certified, effects: none; sizes 1:1','paper',3,1000,11,11,11,1.73205080756887719317e+00,0.66,3.0,1.0,'poses',1,'','certified');
INSERT INTO "workload" VALUES(2,'696050e2b52c429b757b9b9c5b4a30245c6480cba327d26fb2db67d0c4e2aa7c','3D poses rotated, level sat6, effects: none; sizes 1:1','paper',3,1000,11,11,11,1.73205080756887719317e+00,0.66,3.0,1.0,'poses',1,'','sat6');
CREATE INDEX env_seat ON env (seat);
CREATE INDEX workload_near ON workload (family, n);
CREATE INDEX session_search ON session (workload_id, pair_id, kernels, started_ns);
CREATE UNIQUE INDEX profile_live ON profile (workload_id, pair_id, objective, kernels, level)
  WHERE live = 1;
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
