-- SPDX-License-Identifier: MIT
-- Trials as results of T4, the format in which auto-tuners hand on what they measured. Its schema
-- takes further fields: session, workload, a and b say which trials belong together.
SELECT json_object(
         'timestamp', strftime('%Y-%m-%dT%H:%M:%SZ', t.created_ns / 1000000000, 'unixepoch'),
         'configuration', json_object('share', t.share / 65536.0, 'mode', t.mode, 'level', t.level,
                                      'variant_a', t.variant_a, 'variant_b', t.variant_b),
         'objectives', json_array('median'),
         'times', json_object('runtimes', (SELECT json_group_array(total_ns * 1e-6) FROM sample
                                            WHERE trial_id = t.id AND flags & 5 = 0)),
         'invalidity', CASE t.outcome WHEN 'ok' THEN 'correct' WHEN 'build' THEN 'compile'
                                      WHEN 'launch' THEN 'runtime' WHEN 'wrong' THEN 'correctness'
                                      WHEN 'timeout' THEN 'timeout' ELSE 'constraints' END,
         'correctness', iif(t.outcome = 'ok', 1, 0),
         'measurements', (SELECT json_group_array(json_object('name', name, 'value', ns * 1e-6,
                                                              'unit', 'ms'))
                            FROM (SELECT 'median' AS name, t.median_ns AS ns UNION ALL
                                  VALUES ('mad', t.mad_ns), ('low', t.low_ns), ('high', t.high_ns),
                                         ('a', t.a_ns), ('b', t.b_ns))
                           WHERE ns IS NOT NULL),
         'session', t.session_id,
         'workload', json_object('name', w.name, 'n', w.n, 'query', w.query, 'boxes', w.boxes),
         'a', trim(da.name || ' ' || coalesce(ea.part, '')),
         'b', trim(db.name || ' ' || coalesce(eb.part, '')))
  FROM trial t JOIN session s ON s.id = t.session_id JOIN workload w ON w.id = s.workload_id
  JOIN pair ON pair.id = s.pair_id
  JOIN env ea ON ea.id = env_a JOIN device da ON da.id = ea.device_id
  JOIN env eb ON eb.id = env_b JOIN device db ON db.id = eb.device_id
 WHERE t.scope = 65536
 ORDER BY s.started_ns, s.id, t.number
