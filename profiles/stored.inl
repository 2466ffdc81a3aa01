// SPDX-License-Identifier: MIT
// What a program sees of a store: FIELD(type, member, value) for each member of STORED_PROFILE or
// STORED_TRIAL, whichever is defined. type is what a script takes it for, value its SQL. DEVICE is a
// member that is a struct.
#ifdef STORED_PROFILE
FIELD(chars, uid, "p.uid")
FIELD(chars, replaced, "p.dead_reason")
FIELD(chars, scene, "w.name")
FIELD(count, dims, "w.dims")
FIELD(count, objects, "iif(w.query IS NULL, w.n, w.boxes)")
FIELD(chars, query, "coalesce(w.query, '')")
FIELD(count, items, "iif(w.query IS NULL, 0, w.n)")
FIELD(bool, moving, PROFILE_IS_MOVING)
DEVICE(a, "da.name", "a.part", "a.driver")
DEVICE(b, "db.name", "b.part", "b.driver")
FIELD(share, share, "p.share")
FIELD(chars, mode, "p.mode")
FIELD(chars, variant_a, "p.variant_a")
FIELD(chars, variant_b, "p.variant_b")
FIELD(chars, level, "p.level")
FIELD(chars, objective, "p.objective")
FIELD(double, step_ms, "p.median_ns * 1e-6")
FIELD(double, low_ms, "p.low_ns * 1e-6")
FIELD(double, high_ms, "p.high_ns * 1e-6")
FIELD(double, gain, "p.gain")
FIELD(double, gain_low, "p.gain_low")
FIELD(double, gain_high, "p.gain_high")
FIELD(chars, verdict, "p.verdict")
FIELD(count, rounds, "p.rounds")
FIELD(count, watched, "p.watched")
FIELD(count, disturbed, "p.disturbed")
FIELD(double, whole_ms, "p.whole_ns * 1e-6")
FIELD(double, whole_gain, "p.whole_gain")
FIELD(double, whole_gain_low, "p.whole_gain_low")
FIELD(double, whole_gain_high, "p.whole_gain_high")
FIELD(double, missed_rate, "p.missed_rate")
FIELD(double, false_rate, "p.false_rate")
FIELD(chars, origin, "p.origin")
FIELD(chars, session, "s.id")
FIELD(int, measured_s, "p.created_ns / 1000000000")
#undef STORED_PROFILE
#endif
#ifdef STORED_TRIAL
FIELD(share, share, "share")
FIELD(chars, mode, "mode")
FIELD(chars, variant_a, "variant_a")
FIELD(chars, variant_b, "variant_b")
FIELD(count, samples, "(SELECT count(*) FROM sample WHERE trial_id = id)")
FIELD(double, step_ms, "median_ns * 1e-6")
FIELD(double, low_ms, "low_ns * 1e-6")
FIELD(double, high_ms, "high_ns * 1e-6")
FIELD(double, a_ms, "a_ns * 1e-6")
FIELD(double, b_ms, "b_ns * 1e-6")
FIELD(chars, outcome, "outcome")
FIELD(chars, reason, "reason")
#undef STORED_TRIAL
#endif
#undef FIELD
#undef DEVICE
