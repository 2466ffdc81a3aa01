// SPDX-License-Identifier: MIT
// What a program sees of a store: COLUMN(type, member, value) for each member of STORED_PROFILE or
// STORED_TRIAL, whichever is defined. type is what a script takes it for, value its SQL. DEVICE is a
// member that is a struct.
#ifdef STORED_PROFILE
COLUMN(chars, uid, "p.uid")
COLUMN(chars, replaced, "p.dead_reason")
COLUMN(chars, scene, "w.name")
COLUMN(count, dims, "w.dims")
COLUMN(count, objects, "iif(w.query IS NULL, w.n, w.boxes)")
COLUMN(chars, query, "coalesce(w.query, '')")
COLUMN(count, items, "iif(w.query IS NULL, 0, w.n)")
COLUMN(bool, moving, PROFILE_IS_MOVING)
DEVICE(a, "da.name", "a.part", "a.driver")
DEVICE(b, "db.name", "b.part", "b.driver")
COLUMN(share, share, "p.share")
COLUMN(chars, mode, "p.mode")
COLUMN(chars, variant_a, "p.variant_a")
COLUMN(chars, variant_b, "p.variant_b")
COLUMN(chars, level, "p.level")
COLUMN(chars, objective, "p.objective")
COLUMN(double, step_ms, "p.median_ns * 1e-6")
COLUMN(double, low_ms, "p.low_ns * 1e-6")
COLUMN(double, high_ms, "p.high_ns * 1e-6")
COLUMN(double, gain, "p.gain")
COLUMN(double, gain_low, "p.gain_low")
COLUMN(double, gain_high, "p.gain_high")
COLUMN(chars, verdict, "p.verdict")
COLUMN(count, rounds, "p.rounds")
COLUMN(count, watched, "p.watched")
COLUMN(count, disturbed, "p.disturbed")
COLUMN(double, whole_ms, "p.whole_ns * 1e-6")
COLUMN(double, whole_gain, "p.whole_gain")
COLUMN(double, whole_gain_low, "p.whole_gain_low")
COLUMN(double, whole_gain_high, "p.whole_gain_high")
COLUMN(double, missed_rate, "p.missed_rate")
COLUMN(double, false_rate, "p.false_rate")
COLUMN(chars, origin, "p.origin")
COLUMN(chars, session, "s.id")
COLUMN(int, measured_s, "p.created_ns / 1000000000")
#undef STORED_PROFILE
#endif
#ifdef STORED_TRIAL
COLUMN(share, share, "share")
COLUMN(chars, mode, "mode")
COLUMN(chars, variant_a, "variant_a")
COLUMN(chars, variant_b, "variant_b")
COLUMN(count, samples, "(SELECT count(*) FROM sample WHERE trial_id = id)")
COLUMN(double, step_ms, "median_ns * 1e-6")
COLUMN(double, low_ms, "low_ns * 1e-6")
COLUMN(double, high_ms, "high_ns * 1e-6")
COLUMN(double, a_ms, "a_ns * 1e-6")
COLUMN(double, b_ms, "b_ns * 1e-6")
COLUMN(chars, outcome, "outcome")
COLUMN(chars, reason, "reason")
#undef STORED_TRIAL
#endif
#undef COLUMN
#undef DEVICE
