// SPDX-License-Identifier: MIT
#include "cluster/moving_every.h"

#include "cluster/moving_domains.h"

const uint32_t every_rivals[EVERY_RIVALS] = {1, 4, 31};

// Steps that are looked at before a trial, and of a turn, which begins with an exchange of bodies;
// turns of each rival; and steps from a trial to the next one: what a pile is like changes slowly.
enum { QUIET_STEPS = 16, TURN_STEPS = 8, ROUNDS = 2, STEPS_BETWEEN = 2048 };

// Exchanges of ghosts take less than this part of a step: no other number can win much. Another one
// than an exchange after each colour is to be so much faster.
static const double least_part = 0.1, least_gain = 0.05;

void every_note_exchange(every_trial *t, uint64_t ns)
{
    t->quickest_ns = t->n_exchanges == 0 || ns < t->quickest_ns ? ns : t->quickest_ns;
    ++t->n_exchanges;
}

// The quickest exchange is the least that each takes: others wait for ranks that are behind.
void every_note_step(moving *m, tally *t)
{
    every_trial *e = &m->trial;
    const uint64_t now = ranks_now_ns();
    t->sums[3] = e->begun_ns > 0 ? now - e->begun_ns : 0;
    t->sums[4] = e->quickest_ns * e->n_exchanges;
    e->begun_ns = now;
    e->n_exchanges = 0;
}

void every_take_step(moving *m, const tally *t)
{
    every_trial *e = &m->trial;
    const double n = m->ranks->n;
    e->n_steps += t->sums[3] > 0;
    e->ns += (double)t->sums[3] / n;
    e->latency_ns += (double)t->sums[4] / n;
}

static void forget_steps(every_trial *e)
{
    e->n_steps = 0;
    e->ns = e->latency_ns = 0.0;
}

static uint32_t best_of(const every_trial *e)
{
    uint32_t best = 0;
    for (uint32_t i = 1; i < EVERY_RIVALS; ++i) {
        const double least = best == 0 ? (1.0 - least_gain) * e->best_ns[0] : e->best_ns[best];
        best = e->best_ns[i] < least ? i : best;
    }
    return best;
}

static void note_turn(every_trial *e)
{
    const uint32_t rival = (e->turn - 1) % EVERY_RIVALS;
    const double ns = e->ns / e->n_steps;
    e->best_ns[rival] = e->turn <= EVERY_RIVALS || ns < e->best_ns[rival] ? ns : e->best_ns[rival];
}

static bool go_on_with(moving *m, uint32_t every, duet_error *own)
{
    forget_steps(&m->trial);
    m->every = every;
    return moving_settle(m, own);
}

// All ranks know the same times.
static bool end_turn(moving *m, duet_error *own)
{
    every_trial *e = &m->trial;
    note_turn(e);
    if (e->turn++ < ROUNDS * EVERY_RIVALS)
        return go_on_with(m, every_rivals[(e->turn - 1) % EVERY_RIVALS], own);
    e->turn = 0;
    e->is_tried = true;
    e->next = m->counts.step + STEPS_BETWEEN;
    return go_on_with(m, every_rivals[best_of(e)], own);
}

bool every_choose(moving *m, duet_error *own)
{
    every_trial *e = &m->trial;
    if (e->is_fixed || !moving_pushes(m))
        return true;
    if (e->turn > 0)
        return e->n_steps < TURN_STEPS || end_turn(m, own);
    if (e->n_steps < QUIET_STEPS)
        return true;
    const bool is_due = m->counts.step >= e->next && e->latency_ns > least_part * e->ns;
    forget_steps(e);
    e->turn = is_due;
    return !is_due || go_on_with(m, every_rivals[0], own);
}

uint32_t moving_get_every(const moving *m)
{
    return m->every;
}

const every_trial *moving_get_trial(const moving *m)
{
    return &m->trial;
}

// Ghosts lie deeper for more colours, and contacts of two of them are as at home after an exchange.
bool moving_set_every(moving *m, uint32_t every, duet_error *own)
{
    bool is_new = m->every != every;
    m->every = every;
    m->trial = (every_trial){.is_fixed = true};
    return !is_new || m->n_domains == 1 || moving_settle(m, own);
}
