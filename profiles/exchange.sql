-- SPDX-License-Identifier: MIT
-- Rows as JSON lines and back: for each type of line a query that gives the
-- lines, and a statement that makes a row of the line ?1. exchange.c takes the
-- parts by their names after the @.
-- A column that should hold an object but does not, in a store that somebody
-- tampered with, goes out as none.
-- The order is the one in which rows point at each other.

--@device fields
type key kind vendor name arch units max_group local_bytes global_bytes

--@device out
SELECT json_object('type', 'device', 'key', key, 'kind', kind, 'vendor', vendor, 'name', name,
                   'arch', arch, 'units', units, 'max_group', max_group,
                   'local_bytes', local_bytes, 'global_bytes', global_bytes)
  FROM device ORDER BY key

--@device in
INSERT INTO device (key, kind, vendor, name, arch, units, max_group, local_bytes, global_bytes)
SELECT ?1 ->> 'key', ?1 ->> 'kind', ?1 ->> 'vendor', ?1 ->> 'name', ?1 ->> 'arch',
       ?1 ->> 'units', ?1 ->> 'max_group', ?1 ->> 'local_bytes', ?1 ->> 'global_bytes'
    ON CONFLICT DO NOTHING

--@env fields
type key seat device platform platform_version driver cl_version part part_units limits

--@env out
SELECT json_object('type', 'env', 'key', env.key, 'seat', seat, 'device', device.key,
                   'platform', platform, 'platform_version', platform_version,
                   'driver', driver, 'cl_version', cl_version, 'part', part,
                   'part_units', part_units, 'limits', limits)
  FROM env JOIN device ON device.id = device_id ORDER BY env.key

--@env in
INSERT INTO env (key, seat, device_id, platform, platform_version, driver, cl_version, part,
                 part_units, limits)
SELECT ?1 ->> 'key', ?1 ->> 'seat', (SELECT id FROM device WHERE key = ?1 ->> 'device'),
       ?1 ->> 'platform', ?1 ->> 'platform_version', ?1 ->> 'driver', ?1 ->> 'cl_version',
       ?1 ->> 'part', ?1 ->> 'part_units', ?1 ->> 'limits'
    ON CONFLICT DO NOTHING

--@pair fields
type a b

--@pair out
SELECT json_object('type', 'pair', 'a', a.key, 'b', b.key)
  FROM pair JOIN env a ON a.id = env_a JOIN env b ON b.id = env_b ORDER BY a.key, b.key

--@pair in
INSERT INTO pair (env_a, env_b)
SELECT (SELECT id FROM env WHERE key = ?1 ->> 'a'), (SELECT id FROM env WHERE key = ?1 ->> 'b')
    ON CONFLICT DO NOTHING

--@workload fields
type key family name dims n cells_x cells_y cells_z cell occ_mean occ_p99 size_ratio shape rotated
effects level query boxes

--@workload out
SELECT json_object('type', 'workload', 'key', key, 'family', family, 'name', name, 'dims', dims,
                   'n', n, 'cells_x', cells_x, 'cells_y', cells_y, 'cells_z', cells_z,
                   'cell', cell, 'occ_mean', occ_mean, 'occ_p99', occ_p99,
                   'size_ratio', size_ratio, 'shape', shape, 'rotated', rotated,
                   'effects', effects, 'level', level, 'query', query, 'boxes', boxes)
  FROM workload ORDER BY key

--@workload in
INSERT INTO workload (key, family, name, dims, n, cells_x, cells_y, cells_z, cell, occ_mean,
                      occ_p99, size_ratio, shape, rotated, effects, level, query, boxes)
SELECT ?1 ->> 'key', ?1 ->> 'family', ?1 ->> 'name', ?1 ->> 'dims', ?1 ->> 'n', ?1 ->> 'cells_x',
       ?1 ->> 'cells_y', ?1 ->> 'cells_z', ?1 ->> 'cell', ?1 ->> 'occ_mean', ?1 ->> 'occ_p99',
       ?1 ->> 'size_ratio', ?1 ->> 'shape', ?1 ->> 'rotated', ?1 ->> 'effects', ?1 ->> 'level',
       ?1 ->> 'query', coalesce(?1 ->> 'boxes', 0)
    ON CONFLICT DO NOTHING

--@level_cost fields
type a b workload kernels level step_ns true_pairs missed invented created_ns

--@level_cost out
SELECT json_object('type', 'level_cost', 'a', a.key, 'b', b.key, 'workload', workload.key,
                   'kernels', kernels, 'level', p.level, 'step_ns', step_ns,
                   'true_pairs', true_pairs, 'missed', missed, 'invented', invented,
                   'created_ns', created_ns)
  FROM level_cost p JOIN workload ON workload.id = workload_id JOIN pair ON pair.id = pair_id
  JOIN env a ON a.id = env_a JOIN env b ON b.id = env_b
 ORDER BY workload.key, a.key, b.key, kernels, p.level

--@level_cost in
INSERT INTO level_cost (pair_id, workload_id, kernels, level, step_ns, true_pairs, missed, invented,
                   created_ns)
SELECT (SELECT id FROM pair WHERE env_a = (SELECT id FROM env WHERE key = ?1 ->> 'a')
                              AND env_b = (SELECT id FROM env WHERE key = ?1 ->> 'b')),
       (SELECT id FROM workload WHERE key = ?1 ->> 'workload'),
       ?1 ->> 'kernels', ?1 ->> 'level', ?1 ->> 'step_ns', ?1 ->> 'true_pairs', ?1 ->> 'missed',
       ?1 ->> 'invented', ?1 ->> 'created_ns'
    ON CONFLICT DO NOTHING

--@script fields
type key body

--@script out
SELECT json_object('type', 'script', 'key', key, 'body', body) FROM script ORDER BY key

--@script in
INSERT INTO script (key, body) SELECT ?1 ->> 'key', ?1 ->> 'body' ON CONFLICT DO NOTHING

--@session fields
type id state a b workload kernels strategy objective options seed script tool_version host pid
pid_start resumed load timer_ns search_state started_ns heartbeat_ns ended_ns

--@session out
SELECT json_object('type', 'session', 'id', s.id, 'state', state, 'a', a.key, 'b', b.key,
                   'workload', workload.key, 'kernels', kernels, 'strategy', strategy,
                   'objective', objective, 'options', CASE WHEN json_valid(options) THEN CASE json_type(options) WHEN 'object' THEN json(options)
                                    ELSE json('{}') END ELSE json('{}') END, 'seed', seed,
                   'script', script, 'tool_version', tool_version, 'host', host, 'pid', pid,
                   'pid_start', pid_start, 'resumed', resumed, 'load', load,
                   'timer_ns', timer_ns, 'search_state', CASE WHEN json_valid(search_state) THEN CASE json_type(search_state) WHEN 'object' THEN json(search_state)
                                    END END,
                   'started_ns', started_ns, 'heartbeat_ns', heartbeat_ns, 'ended_ns', ended_ns)
  FROM session s JOIN workload ON workload.id = workload_id JOIN pair ON pair.id = pair_id
  JOIN env a ON a.id = env_a JOIN env b ON b.id = env_b ORDER BY started_ns, s.id

--@session in
INSERT INTO session (id, state, pair_id, workload_id, kernels, strategy, objective, options, seed,
                     script, tool_version, host, pid, pid_start, resumed, load, timer_ns,
                     search_state, started_ns, heartbeat_ns, ended_ns)
SELECT ?1 ->> 'id', ?1 ->> 'state',
       (SELECT id FROM pair WHERE env_a = (SELECT id FROM env WHERE key = ?1 ->> 'a')
                              AND env_b = (SELECT id FROM env WHERE key = ?1 ->> 'b')),
       (SELECT id FROM workload WHERE key = ?1 ->> 'workload'),
       ?1 ->> 'kernels', ?1 ->> 'strategy', ?1 ->> 'objective', ?1 ->> 'options', ?1 ->> 'seed',
       ?1 ->> 'script', ?1 ->> 'tool_version', ?1 ->> 'host', ?1 ->> 'pid', ?1 ->> 'pid_start',
       ?1 ->> 'resumed', ?1 ->> 'load', ?1 ->> 'timer_ns', ?1 ->> 'search_state',
       ?1 ->> 'started_ns', ?1 ->> 'heartbeat_ns', ?1 ->> 'ended_ns'
    ON CONFLICT DO NOTHING

--@trial fields
type session number timestamp created_ns configuration times invalidity reason launches outliers
measurements objectives terms samples disturbed

--@trial out
SELECT json_object(
         'type', 'trial', 'session', session_id, 'number', number,
         'timestamp', strftime('%Y-%m-%dT%H:%M:%SZ', created_ns / 1000000000, 'unixepoch'),
         'created_ns', created_ns,
         'configuration', json_object('share', share, 'mode', mode, 'level', level,
                                      'variant_a', variant_a, 'variant_b', variant_b),
         'times', json_object('compilation', build_ms,
                              'runtimes', (SELECT json_group_array(total_ns * 1e-6) FROM sample
                                            WHERE trial_id = trial.id AND flags & 5 = 0)),
         'invalidity', CASE outcome WHEN 'ok' THEN 'correct' WHEN 'build' THEN 'compile'
                                    WHEN 'launch' THEN 'runtime' WHEN 'wrong' THEN 'correctness'
                                    WHEN 'timeout' THEN 'timeout' ELSE 'constraints' END,
         'reason', reason, 'launches', launches, 'outliers', outliers,
         'measurements', iif(outcome = 'ok', json_array(
           json_object('name', 'median', 'value', median_ns, 'unit', 'ns'),
           json_object('name', 'mad', 'value', mad_ns, 'unit', 'ns'),
           json_object('name', 'low', 'value', low_ns, 'unit', 'ns'),
           json_object('name', 'high', 'value', high_ns, 'unit', 'ns'),
           json_object('name', 'a', 'value', a_ns, 'unit', 'ns'),
           json_object('name', 'b', 'value', b_ns, 'unit', 'ns')), json_array()),
         'objectives', json_array('median'), 'terms', CASE WHEN json_valid(terms) THEN CASE json_type(terms) WHEN 'object' THEN json(terms)
                                    END END,
         'samples', (SELECT json_group_array(json_array(number, total_ns, a_ns, b_ns, transfer_ns,
                                                        merge_ns, flags, at_ns, cpu_ns, wait_ns))
                       FROM sample WHERE trial_id = trial.id),
         'disturbed', disturbed)
  FROM trial ORDER BY session_id, number

--@trial in
INSERT INTO trial (session_id, number, share, mode, level, variant_a, variant_b, outcome, reason,
                   build_ms, launches, outliers, median_ns, mad_ns, low_ns, high_ns, a_ns, b_ns,
                   terms, created_ns, disturbed)
  WITH measured (name, value) AS (SELECT value ->> 'name', value ->> 'value'
                                    FROM json_each(?1, '$.measurements'))
SELECT ?1 ->> 'session', ?1 ->> 'number',
       ?1 ->> '$.configuration.share', ?1 ->> '$.configuration.mode',
       ?1 ->> '$.configuration.level', ?1 ->> '$.configuration.variant_a',
       ?1 ->> '$.configuration.variant_b',
       CASE ?1 ->> 'invalidity' WHEN 'correct' THEN 'ok' WHEN 'compile' THEN 'build'
                                WHEN 'runtime' THEN 'launch' WHEN 'correctness' THEN 'wrong'
                                WHEN 'timeout' THEN 'timeout' WHEN 'constraints' THEN 'pruned' END,
       ?1 ->> 'reason', ?1 ->> '$.times.compilation', ?1 ->> 'launches', ?1 ->> 'outliers',
       (SELECT value FROM measured WHERE name = 'median'),
       (SELECT value FROM measured WHERE name = 'mad'),
       (SELECT value FROM measured WHERE name = 'low'),
       (SELECT value FROM measured WHERE name = 'high'),
       (SELECT value FROM measured WHERE name = 'a'),
       (SELECT value FROM measured WHERE name = 'b'),
       ?1 ->> 'terms', ?1 ->> 'created_ns', coalesce(?1 ->> 'disturbed', 0)
    ON CONFLICT DO NOTHING

--@trial parts
INSERT INTO sample (trial_id, number, total_ns, a_ns, b_ns, transfer_ns, merge_ns, flags, at_ns,
                    cpu_ns, wait_ns)
SELECT ?2, value ->> 0, value ->> 1, value ->> 2, value ->> 3, value ->> 4, value ->> 5,
       value ->> 6, value ->> 7, coalesce(value ->> 8, 0), coalesce(value ->> 9, 0)
  FROM json_each(?1, '$.samples')

--@profile fields
type uid a b workload kernels objective level share mode variant_a variant_b median_ns low_ns
high_ns gain gain_low gain_high verdict missed_rate false_rate true_pairs single_ns best_share
best_mode terms rounds whole_ns whole_gain whole_gain_low whole_gain_high origin session trial
created_ns live dead_reason watched disturbed

--@profile out
SELECT json_object('type', 'profile', 'uid', uid, 'a', a.key, 'b', b.key,
                   'workload', workload.key, 'kernels', kernels, 'objective', objective,
                   'level', p.level, 'share', share, 'mode', mode, 'variant_a', variant_a,
                   'variant_b', variant_b, 'median_ns', median_ns, 'low_ns', low_ns,
                   'high_ns', high_ns, 'gain', gain, 'gain_low', gain_low,
                   'gain_high', gain_high, 'verdict', verdict, 'missed_rate', missed_rate,
                   'false_rate', false_rate, 'true_pairs', true_pairs,
                   'single_ns', single_ns, 'best_share', best_share, 'best_mode', best_mode,
                   'terms', CASE WHEN json_valid(terms) THEN CASE json_type(terms) WHEN 'object' THEN json(terms)
                                    END END, 'rounds', rounds, 'whole_ns', whole_ns,
                   'whole_gain', whole_gain, 'whole_gain_low', whole_gain_low,
                   'whole_gain_high', whole_gain_high, 'origin', origin, 'session', session_id,
                   'trial', trial, 'created_ns', created_ns, 'live', live,
                   'dead_reason', dead_reason, 'watched', watched, 'disturbed', disturbed)
  FROM profile p JOIN workload ON workload.id = workload_id JOIN pair ON pair.id = pair_id
  JOIN env a ON a.id = env_a JOIN env b ON b.id = env_b ORDER BY created_ns, uid

-- Where the store has a live profile for the key, that one stays live. A plan without
-- a verdict, which older versions loaded, is not live.

--@profile in
INSERT INTO profile (uid, pair_id, workload_id, kernels, objective, level, share, mode, variant_a,
                     variant_b, median_ns, low_ns, high_ns, gain, gain_low, gain_high, verdict,
                     missed_rate, false_rate, true_pairs, single_ns, best_share, best_mode, terms,
                     rounds, whole_ns, whole_gain, whole_gain_low, whole_gain_high, origin, session_id, trial, created_ns, live, dead_reason,
                     watched, disturbed)
  WITH place (pair_id, workload_id) AS (SELECT
         (SELECT id FROM pair WHERE env_a = (SELECT id FROM env WHERE key = ?1 ->> 'a')
                                AND env_b = (SELECT id FROM env WHERE key = ?1 ->> 'b')),
         (SELECT id FROM workload WHERE key = ?1 ->> 'workload')),
       own (there) AS (SELECT count(*) FROM place JOIN profile USING (pair_id, workload_id)
                        WHERE profile.live = 1 AND objective = ?1 ->> 'objective'
                          AND kernels = ?1 ->> 'kernels' AND level = ?1 ->> 'level'),
       untrusted (yes) AS (SELECT ?1 ->> 'verdict' = 'ambiguous')
SELECT ?1 ->> 'uid', place.pair_id, place.workload_id, ?1 ->> 'kernels', ?1 ->> 'objective',
       ?1 ->> 'level', ?1 ->> 'share', ?1 ->> 'mode', ?1 ->> 'variant_a', ?1 ->> 'variant_b',
       ?1 ->> 'median_ns', ?1 ->> 'low_ns', ?1 ->> 'high_ns', ?1 ->> 'gain', ?1 ->> 'gain_low',
       ?1 ->> 'gain_high', ?1 ->> 'verdict', ?1 ->> 'missed_rate', ?1 ->> 'false_rate',
       ?1 ->> 'true_pairs', ?1 ->> 'single_ns', ?1 ->> 'best_share', ?1 ->> 'best_mode',
       ?1 ->> 'terms', ?1 ->> 'rounds', ?1 ->> 'whole_ns', ?1 ->> 'whole_gain',
       ?1 ->> 'whole_gain_low', ?1 ->> 'whole_gain_high',
       ?1 ->> 'origin', ?1 ->> 'session', ?1 ->> 'trial', ?1 ->> 'created_ns',
       iif(own.there OR untrusted.yes, 0, ?1 ->> 'live'),
       iif(NOT ?1 ->> 'live', ?1 ->> 'dead_reason',
           iif(untrusted.yes, 'too few rounds for a verdict',
               iif(own.there, 'the store had one of its own', ?1 ->> 'dead_reason'))),
       coalesce(?1 ->> 'watched', 0), coalesce(?1 ->> 'disturbed', 0)
  FROM place, own, untrusted WHERE true
    ON CONFLICT DO NOTHING
