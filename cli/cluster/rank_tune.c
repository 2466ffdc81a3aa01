// SPDX-License-Identifier: MIT
#include "cli/cluster/rank_tune.h"

#include "base/error.h"
#include "cli/say.h"
#include "cluster/moving.h"
#include "runtime/dynamics/motion.h"
#include "tuner/record.h"

#include <inttypes.h>
#include <stdio.h>

// Colours after which ghosts come: each, some, and all of them.
static const uint32_t rivals[] = {1, 2, 4, 8, 31};

enum { RIVALS = sizeof rivals / sizeof *rivals };

// A turn begins with an exchange of bodies, of which a motion has one in about as many steps.
enum { STEPS_A_TURN = 8 };

static uint64_t fewest_steps(const rank_tune *t)
{
    return (uint64_t)RIVALS * t->race.options.least_rounds;
}

// Nothing takes a step that could not be kept in the end.
static bool check_store(duet_error *err)
{
    record r;
    bool ok = record_open(&r, NULL, err);
    record_close(&r);
    return ok;
}

// Looks at the bodies of rank 0's first domain: what the store knows of is as large as that.
static bool describe(rank_tune *t, duet_error *err)
{
    if (t->cluster->ranks.self > 0)
        return true;
    bool ok =
        profile_subject_read_motion(moving_get_motion(t->cluster->moving, 0), &t->subject, err);
    t->subject.objective = t->objective;
    return ok && check_store(err);
}

bool rank_tune_begin(rank_tune *t, duet_cluster *cluster, uint64_t steps, duet_error *err)
{
    race_options options = race_default_options();
    options.stay = 1; // the others are measured by an exchange after each colour
    *t =
        (rank_tune){.cluster = cluster, .state = TUNE_RACING, .race = race_begin(RIVALS, &options)};
    if ((uint64_t)cluster->ranks.n * cluster->def.parts == 1)
        return bad_argument(
            err, "--tune-colours: one domain exchanges nothing; expected several ranks or parts");
    if (steps < fewest_steps(t))
        return bad_argument(
            err, "--tune-colours: %" PRIu64 " steps are left; expected %" PRIu64 " or more", steps,
            fewest_steps(t));
    const uint64_t most = steps / fewest_steps(t);
    t->steps = most < STEPS_A_TURN ? (uint32_t)most : STEPS_A_TURN;
    cluster_objective(cluster, t->objective);
    return ranks_agree(&cluster->ranks, describe(t, err), err);
}

// The place of the best one that is surely faster than an exchange after each colour, else of that;
// RIVALS: not all had their rounds.
static uint32_t winner_of(const rank_tune *t)
{
    const race *r = &t->race;
    if (t->state == TUNE_NONE || r->rivals[0].rounds < r->options.least_rounds)
        return RIVALS;
    const uint32_t best = race_best(r, 0, RIVALS);
    return best > 0 && race_compare(r, best, 0).verdict == RACE_FASTER ? best : 0;
}

uint32_t rank_tune_found(const rank_tune *t)
{
    const uint32_t winner = winner_of(t);
    return winner < RIVALS ? rivals[winner] : 0;
}

// All ranks know the same times, and so the same winner. The race ends once the first has its
// rounds, since that one stays.
static void end_race(rank_tune *t)
{
    t->state = TUNE_ENDED;
    t->turn = winner_of(t);
}

// Ghosts come anew in the time of the turn, since they lie deeper for more colours.
static bool begin_turn(rank_tune *t, duet_error *err)
{
    const uint64_t begun_ns = ranks_now_ns();
    duet_error own = {0};
    if (!moving_set_every(t->cluster->moving, rivals[t->turn], &own) ||
        !ranks_agree(&t->cluster->ranks, is_well(&own), &own))
        return error_copy(err, &own);
    t->ms = ranks_greatest(&t->cluster->ranks, (double)(ranks_now_ns() - begun_ns) * 1e-6);
    t->n_left = t->steps;
    return true;
}

bool rank_tune_before(rank_tune *t, duet_error *err)
{
    if (t->state != TUNE_RACING || t->n_left > 0)
        return true;
    if (!race_next(&t->race, &t->turn))
        end_race(t);
    return begin_turn(t, err);
}

void rank_tune_after(rank_tune *t, double ms)
{
    if (t->state != TUNE_RACING)
        return;
    t->ms += ms;
    if (--t->n_left == 0)
        race_add(&t->race, t->turn, t->ms * 1e6 / t->steps);
}

// ---------------------------------------------------------------- the store

static duet_plan plan_of(const rank_tune *t, uint32_t winner)
{
    const duet_motion *part = moving_get_motion(t->cluster->moving, 0);
    duet_plan plan = part->def.plan;
    plan.mode = plan.mode == DUET_MODE_DEFAULT ? DUET_MODE_OWN : plan.mode;
    snprintf(plan.variant_b, sizeof plan.variant_b, "auto motion.colours=%" PRIu32, rivals[winner]);
    return plan;
}

static bool keep(const rank_tune *t, uint32_t winner, duet_error *err)
{
    record r;
    const duet_plan plan = plan_of(t, winner);
    const profile_request request = profile_subject_request(&t->subject);
    bool ok = record_open(&r, NULL, err);
    ok = ok && record_aim(&r, &request, err) && record_raced(&r, &plan, &t->race, winner, 0, err);
    record_close(&r);
    return ok;
}

bool rank_tune_end(const rank_tune *t, duet_error *err)
{
    if (t->state == TUNE_NONE)
        return true;
    const uint32_t winner = winner_of(t);
    bool ok = true;
    if (t->cluster->ranks.self == 0 && winner < RIVALS)
        ok = keep(t, winner, err);
    else if (t->cluster->ranks.self == 0)
        say_note("--tune-colours: it ended before each choice had its rounds, so none is kept");
    return ranks_agree(&t->cluster->ranks, ok, err);
}
