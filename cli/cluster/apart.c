// SPDX-License-Identifier: MIT
#include "cli/cluster/apart.h"

#include "base/error.h"
#include "tuner/stats.h"

// Steps of those at work begin together, as those of ranks that exchange objects do. Where one
// fails all of them stop, and it alone has an error.
static bool take_steps(apart_times *t, ranks *team, uint64_t repeat, apart_step *step,
                       void *context, duet_error *err)
{
    bool ok = true, all_ok = true;
    for (uint64_t i = 0; all_ok && i < repeat; ++i) {
        tally slowest = {0};
        ok = step(context, &slowest.greatest[0], err);
        all_ok = ranks_agree_and(team, ok, &slowest, NULL);
        t->all_ms[i] = slowest.greatest[0];
    }
    return ok;
}

static bool time_row(apart_times *t, ranks *all, int at_work, uint64_t repeat, apart_step *step,
                     void *context, duet_error *err)
{
    ranks team;
    bool works = all->self < at_work;
    bool ok = ranks_choose(&team, all, works, err);
    ok = !works || (ok && take_steps(t, &team, repeat, step, context, err));
    ranks_end(&team);
    ranks_rest(all);
    if (ok && works)
        stats_sort(t->all_ms, repeat);
    double median = ok && works ? t->all_ms[(repeat - 1) / 2] : 0;
    tally told = {.greatest = {median}};
    if (!ranks_agree_and(all, ok, &told, err))
        return false;
    t->ranks[t->n] = at_work;
    t->ms[t->n++] = told.greatest[0];
    return true;
}

static bool check_machine(const ranks *all, duet_error *err)
{
    return all->n == all->n_on_host ||
           error_set(err, DUET_STATUS_BAD_ARGUMENT,
                     "--apart: %d of %d ranks are on %s; expected all of them on one machine",
                     all->n_on_host, all->n, all->host_name);
}

bool apart_measure(apart_times *t, ranks *all, uint64_t repeat, apart_step *step, void *context,
                   duet_error *err)
{
    double warm_ms;
    bool ok = check_machine(all, err);
    ranks_await_turn(all, true);
    ok = ok && step(context, &warm_ms, err);
    ranks_end_turn(all);
    ok = ranks_agree(all, ok, err);
    t->n = 0;
    for (int at_work = 1; ok; at_work = 2 * at_work < all->n ? 2 * at_work : all->n) {
        ok = time_row(t, all, at_work, repeat, step, context, err);
        if (at_work == all->n)
            break;
    }
    return ok;
}

int apart_first_of(const apart_times *t, int rank)
{
    int row = 0;
    while (row + 1 < t->n && t->ranks[row] <= rank)
        ++row;
    return row;
}
