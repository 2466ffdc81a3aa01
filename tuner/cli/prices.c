// SPDX-License-Identifier: MIT
#include "tuner/cli/prices.h"

#include "tuner/cli/interrupt.h"
#include "tuner/cli/pair_list.h"
#include "tuner/cli/progress.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// Cheapest to compute first.
static const duet_level order[DUET_LEVELS] = {DUET_LEVEL_AABB,      DUET_LEVEL_SPHERE,
                                              DUET_LEVEL_SAT6,      DUET_LEVEL_SAT15,
                                              DUET_LEVEL_CERTIFIED, DUET_LEVEL_DOUBLE};

typedef struct survey {
    prices *prices;
    const duet_scene *scene;
    duet_world *world;
    duet_plan plan;
    duet_pair *truth;
    double ms[2 * DUET_LEVELS][PRICES_ROUNDS];
    duet_result result; // of the last step
} survey;

// ---------------------------------------------------------------- right and wrong

static void add_wrong(survey *s, price *row, duet_pair pair, bool missed)
{
    const duet_pose *poses = duet_scene_poses(s->scene);
    double gap =
        poses ? duet_poses_gap(&poses[pair.a], &poses[pair.b], duet_scene_describe(s->scene)->dims)
              : 0;
    if (missed) {
        ++row->missed;
        row->deepest_missed = fmax(row->deepest_missed, -gap);
    } else {
        ++row->added;
        row->widest_added = fmax(row->widest_added, gap);
    }
}

static bool compare(survey *s, price *row, duet_error *err)
{
    duet_pair *found = pair_list_sorted(&s->result, err);
    if (!found)
        return false;
    uint64_t i = 0, j = 0, n = s->result.pairs, n_truth = s->prices->truth;
    while (i < n || j < n_truth) {
        int ahead = i == n ? 1 : j == n_truth ? -1 : pair_list_order(&found[i], &s->truth[j]);
        if (ahead != 0)
            add_wrong(s, row, ahead < 0 ? found[i] : s->truth[j], ahead > 0);
        i += ahead <= 0;
        j += ahead >= 0;
    }
    free(found);
    row->pairs = n;
    row->candidates = s->result.candidates;
    row->undecided = s->result.undecided;
    return true;
}

// ---------------------------------------------------------------- times

static bool hand_over(survey *s, duet_error *err)
{
    uint32_t n = duet_scene_describe(s->scene)->n;
    const duet_pose *poses = duet_scene_poses(s->scene);
    return poses ? duet_world_set_poses(s->world, poses, n, err)
                 : duet_world_set_bounds(s->world, duet_scene_bounds(s->scene), n, err);
}

static bool step(survey *s, duet_error *err)
{
    return hand_over(s, err) && duet_world_step(s->world, &s->result, err);
}

// The first step at a level makes its kernels ready and is not timed.
static bool visit(survey *s, uint32_t at, uint32_t round, duet_error *err)
{
    price *row = &s->prices->rows[at];
    s->plan.share = row->device == 0 ? DUET_SHARE_ONE : 0;
    bool ok = duet_world_set_level(s->world, row->level, err) &&
              duet_world_set_plan(s->world, &s->plan, err) && step(s, err);
    ok = ok && (round > 0 || compare(s, row, err)) && step(s, err);
    s->ms[at][round] = s->result.total_ms;
    return ok;
}

static bool run_rounds(survey *s, uint32_t rounds, duet_error *err)
{
    prices *p = s->prices;
    progress shown = progress_begin("step", (uint64_t)rounds * p->n);
    bool ok = true;
    while (ok && p->rounds < rounds && !interrupt_asked()) {
        uint32_t at = 0;
        for (; ok && at < p->n && !interrupt_asked(); ++at) {
            ok = visit(s, at, p->rounds, err);
            progress_show(&shown, (uint64_t)p->rounds * p->n + at + 1);
        }
        p->rounds += ok && at == p->n;
    }
    progress_end(&shown);
    return ok && (p->rounds > 0 || interrupt_check(err));
}

// ---------------------------------------------------------------- prices

static int by_number(const void *x, const void *y)
{
    double a = *(const double *)x, b = *(const double *)y;
    return (a > b) - (a < b);
}

static double median(double *values, uint32_t n)
{
    qsort(values, n, sizeof *values, by_number);
    return n % 2 ? values[n / 2] : (values[n / 2 - 1] + values[n / 2]) / 2;
}

static uint64_t wrong(const price *row)
{
    return row->missed + row->added;
}

static bool beats(const price *a, const price *b)
{
    return a->device == b->device && a->step_ms <= b->step_ms && wrong(a) <= wrong(b) &&
           (a->step_ms < b->step_ms || wrong(a) < wrong(b));
}

static void draw_conclusions(survey *s)
{
    prices *p = s->prices;
    double textbook[2] = {0};
    for (uint32_t i = 0; i < p->n; ++i) {
        price *row = &p->rows[i];
        row->step_ms = median(s->ms[i], p->rounds);
        if (row->level == DUET_LEVEL_SAT15)
            textbook[row->device] = row->step_ms;
    }
    for (uint32_t i = 0; i < p->n; ++i) {
        price *row = &p->rows[i];
        row->relative = row->step_ms / textbook[row->device];
        row->front = true;
        for (uint32_t k = 0; k < p->n; ++k)
            row->front &= !beats(&p->rows[k], row);
    }
}

static void list_rows(prices *p, const duet_device_pair *pair)
{
    for (int device = 0; device < 2; ++device)
        for (int i = 0; i < DUET_LEVELS; ++i)
            if (order[i] != DUET_LEVEL_DOUBLE || duet_device_pair_info(pair, device)->fp64)
                p->rows[p->n++] = (price){.level = order[i], .device = device};
}

bool prices_measure(prices *p, duet_device_pair *pair, const duet_scene *scene, uint32_t rounds,
                    duet_error *err)
{
    *p = (prices){0};
    list_rows(p, pair);
    duet_world_def def = duet_scene_world_def(scene, pair);
    survey s = {.prices = p, .scene = scene, .plan = def.plan};
    s.world = duet_world_create(&def, err);
    bool ok = s.world && duet_world_set_scene(s.world, scene, err) &&
              duet_reference(scene, &s.truth, &p->truth, err) && run_rounds(&s, rounds, err);
    if (ok)
        draw_conclusions(&s);
    duet_free(s.truth);
    duet_world_destroy(s.world);
    return ok;
}
