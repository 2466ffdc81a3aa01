// SPDX-License-Identifier: MIT
// The figures of a profile, each a column of that name: FIGURE(type, name), WORD(name) for a short
// text and COUNT(name) for a number that is -1 where nobody counted. Times are of a step.
FIGURE(double, median_ns) // by this plan; predicted if interpolated; 0 if transferred, as all below
FIGURE(double, low_ns)    // the median's interval; 0 if predicted, as whatever says nothing else
FIGURE(double, high_ns)
FIGURE(double, single_ns) // by the best single device; 0 or NaN: not known
FIGURE(double, gain)      // over the best single device: 0.25 is a quarter faster
FIGURE(double, gain_low)
FIGURE(double, gain_high)
WORD(verdict)                // "faster", "same", "slower" than that device, or "ambiguous"
FIGURE(uint32_t, best_share) // of the best plan that shares the work, which the gain is of
WORD(best_mode)
FIGURE(uint32_t, rounds)    // of the race that the gain is of; 0: there was none, or not known
FIGURE(uint32_t, watched)   // launches whose threads were watched; 0: not known
FIGURE(uint32_t, disturbed) // watched launches that waited for a core
FIGURE(double, whole_ns)    // by the undivided device of A and B; 0 or NaN: it was not raced
FIGURE(double, whole_gain)  // of the plan over it
FIGURE(double, whole_gain_low)
FIGURE(double, whole_gain_high)
FIGURE(double, missed_rate) // pairs missed, by true pairs, as measured at the plan's level
FIGURE(double, false_rate)  // pairs reported in excess, by true pairs
COUNT(true_pairs)           // that the rates are of; -1: the rates were not measured
#undef FIGURE
#undef WORD
#undef COUNT
