// SPDX-License-Identifier: MIT
#include "cluster/balance.h"

#include <math.h>

// The loss must be several times the price of a partition, which may turn out higher than the last
// partition's price; and less than this part of the mean is no loss that a new one would end.
#define PAYS 3
#define STEPS_OF_A_PARTITION 16 // its price before one was measured
#define LEAST_LOSS 0.05

void balance_begin(balance *b, double price_ms)
{
    *b = (balance){.price_ms = price_ms};
}

bool balance_note(balance *b, ranks *r, partition *p, double busy_ms, uint32_t n)
{
    b->least_ms = b->steps == 0 ? busy_ms : fmin(b->least_ms, busy_ms);
    if (r->n == 1 || ++b->steps < BALANCE_STEPS)
        return false;
    tally t = {.sums = {(uint64_t)(1e6 * b->least_ms)}, .greatest = {b->least_ms, b->price_ms}};
    b->steps = 0;
    ranks_agree_and(r, true, &t, NULL);
    double mean_ms = 1e-6 * (double)t.sums[0] / r->n, lost_ms = t.greatest[0] - mean_ms;
    double price_ms = t.greatest[1] > 0 ? t.greatest[1] : STEPS_OF_A_PARTITION * mean_ms;
    bool is_uneven = lost_ms > LEAST_LOSS * mean_ms;
    b->lost_ms = is_uneven ? b->lost_ms + BALANCE_STEPS * lost_ms : 0;
    return b->lost_ms > PAYS * price_ms &&
           partition_weigh(p, r, b->least_ms > 0 ? n / b->least_ms : 0);
}
