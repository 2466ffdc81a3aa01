// SPDX-License-Identifier: MIT
#include "tuner/level_costs.h"

#include "base/budget.h"
#include "base/clock.h"
#include "base/error.h"
#include "runtime/scene/scene.h"
#include "runtime/scene/sorted_pairs.h"
#include "tuner/measure.h"
#include "tuner/race.h"

#include <math.h>
#include <stdlib.h>

// Cheapest to compute first.
static const duet_level order[DUET_LEVELS] = {DUET_LEVEL_AABB,      DUET_LEVEL_SPHERE,
                                              DUET_LEVEL_SAT6,      DUET_LEVEL_SAT15,
                                              DUET_LEVEL_CERTIFIED, DUET_LEVEL_DOUBLE};

typedef struct survey {
    level_costs *costs;
    const level_costs_def *def;
    const duet_scene *scene;
    level_cost *row; // that wrong pairs are counted for
    duet_world *world;
    duet_plan plan;
    duet_pair *truth;
    core_watch *cores;
    uint64_t begun_ns;
    race race;                  // between all rows, each of which runs in each round
    double ms[2 * DUET_LEVELS]; // of the round
    duet_result result;         // the last step's result
} survey;

// ---------------------------------------------------------------- right and wrong

static double separation_of(const duet_scene *scene, duet_pair pair)
{
    const duet_scene_info *info = duet_scene_get_info(scene);
    const duet_pose *poses = duet_scene_get_objects(scene, DUET_OBJECT_POSES);
    const duet_large_pose *placed = duet_scene_get_objects(scene, DUET_OBJECT_LARGE_POSES);
    if (placed)
        return duet_large_poses_separation(&placed[pair.a], &placed[pair.b], info->origin_edge,
                                           info->dims);
    if (info->shape == DUET_SHAPE_ROUNDED_BOXES || info->shape == DUET_SHAPE_SPHERES) {
        duet_rounded_box a = scene_rounded_box(scene, pair.a), b = scene_rounded_box(scene, pair.b);
        return duet_rounded_boxes_separation(&a, &b, info->dims);
    }
    return poses ? duet_poses_separation(&poses[pair.a], &poses[pair.b], info->dims) : 0;
}

static void add_wrong(void *context, duet_pair pair, bool missed)
{
    survey *s = context;
    level_cost *row = s->row;
    double separation = separation_of(s->scene, pair);
    if (missed) {
        ++row->missed;
        row->deepest_missed = fmax(row->deepest_missed, -separation);
    } else {
        ++row->added;
        row->widest_added = fmax(row->widest_added, separation);
    }
}

static bool compare(survey *s, level_cost *row, duet_error *err)
{
    duet_pair *found = sorted_pairs_of(&s->result, err);
    if (!found)
        return false;
    s->row = row;
    sorted_pairs_compare(found, s->result.pairs, s->truth, s->costs->truth, add_wrong, s);
    free(found);
    row->pairs = s->result.pairs;
    row->candidates = s->result.candidates;
    row->undecided = s->result.undecided;
    return true;
}

// ---------------------------------------------------------------- times

static bool step(survey *s, duet_error *err)
{
    const duet_scene_info *info = duet_scene_get_info(s->scene);
    duet_object_kind kind = scene_kind(info);
    return duet_world_set_objects(s->world, kind, duet_scene_get_objects(s->scene, kind), info->n,
                                  err) &&
           duet_world_step(s->world, &s->result, err);
}

enum { TRIES = 4 };

// The first step that other programs do not disturb, or the last of so many.
static bool step_in_quiet(survey *s, duet_error *err)
{
    bool disturbed = true;
    for (int i = 0; i < TRIES && disturbed; ++i) {
        measure_watch(s->cores, s->def->pair);
        if (!step(s, err))
            return false;
        disturbed = core_watch_stop(s->cores).disturbed;
    }
    return true;
}

// The first step at a level makes its kernels ready and is not timed.
static bool visit(survey *s, uint32_t at, duet_error *err)
{
    level_cost *row = &s->costs->rows[at];
    if (row->device != LEVEL_COSTS_BOTH)
        s->plan.share = row->device == 0 ? DUET_SHARE_ONE : 0;
    bool ok = budget_check(err) && duet_world_set_level(s->world, row->level, err) &&
              duet_world_set_plan(s->world, &s->plan, err) && step(s, err);
    ok = ok && (s->costs->rounds > 0 || compare(s, row, err)) && step_in_quiet(s, err);
    s->ms[at] = s->result.total_ms;
    return ok;
}

static bool tell_watcher(const survey *s, uint64_t done)
{
    const level_costs_def *def = s->def;
    const duet_tune_progress progress = {.stage = "level",
                                         .plan = &s->plan,
                                         .launches = (uint32_t)done,
                                         .seconds = clock_ms_since(s->begun_ns) * 1e-3};
    return !def->watch || def->watch(def->watch_context, &progress);
}

static bool run_rounds(survey *s, duet_error *err)
{
    const level_costs_def *def = s->def;
    level_costs *p = s->costs;
    uint64_t done = 0;
    bool more = true;
    while (more && p->rounds < def->rounds) {
        uint32_t at = 0;
        for (; more && at < p->n; ++at) {
            if (!visit(s, at, err))
                return false;
            more = tell_watcher(s, ++done);
        }
        p->rounds += at == p->n;
        for (uint32_t i = 0; at == p->n && i < p->n; ++i)
            race_add(&s->race, i, s->ms[i]);
    }
    return p->rounds > 0 ||
           error_set(err, DUET_STATUS_INTERRUPTED, "stopped before each level had a step");
}

// ---------------------------------------------------------------- costs

static uint64_t wrong(const level_cost *row)
{
    return row->missed + row->added;
}

static bool is_faster(const survey *s, uint32_t row, uint32_t other)
{
    return race_compare(&s->race, row, other).verdict == RACE_FASTER;
}

// By time beyond noise, or by fewer wrong pairs in a time that is not longer beyond noise.
static bool beats(const survey *s, uint32_t i, uint32_t k)
{
    const level_cost *a = &s->costs->rows[i], *b = &s->costs->rows[k];
    return a->device == b->device && ((wrong(a) <= wrong(b) && is_faster(s, i, k)) ||
                                      (wrong(a) < wrong(b) && !is_faster(s, k, i)));
}

static void compare_times(survey *s, uint32_t at, uint32_t textbook)
{
    level_cost *row = &s->costs->rows[at];
    race_gain gain = race_compare(&s->race, textbook, at); // too few rounds show nothing
    bool known = gain.verdict != RACE_AMBIGUOUS;
    row->relative = gain.ratio;
    row->relative_low = known ? gain.interval.low : 0;
    row->relative_high = known ? gain.interval.high : INFINITY;
    row->same = at != textbook && (!known || gain.verdict == RACE_SAME);
}

static void draw_conclusions(survey *s)
{
    level_costs *p = s->costs;
    uint32_t textbook[LEVEL_COSTS_BOTH + 1] = {0};
    for (uint32_t i = 0; i < p->n; ++i) {
        p->rows[i].step_ms = race_median(&s->race, i);
        if (p->rows[i].level == DUET_LEVEL_SAT15)
            textbook[p->rows[i].device] = i;
    }
    for (uint32_t i = 0; i < p->n; ++i) {
        compare_times(s, i, textbook[p->rows[i].device]);
        p->rows[i].front = true;
        for (uint32_t k = 0; k < p->n; ++k)
            p->rows[i].front &= !beats(s, k, i);
    }
}

static bool has_double(const level_costs_def *def, int device)
{
    bool a = duet_device_pair_get_info(def->pair, 0)->fp64,
         b = duet_device_pair_get_info(def->pair, 1)->fp64;
    return device == LEVEL_COSTS_BOTH ? a && b : device == 0 ? a : b;
}

static void list_rows(level_costs *p, const level_costs_def *def, int device)
{
    for (int i = 0; i < DUET_LEVELS; ++i)
        if (order[i] != DUET_LEVEL_DOUBLE || has_double(def, device))
            p->rows[p->n++] = (level_cost){.level = order[i], .device = device};
}

bool level_costs_measure(level_costs *p, const level_costs_def *def, duet_error *err)
{
    // None leaves, however slow it is.
    const race_options rounds = {.least_rounds = 1,
                                 .most_rounds = LEVEL_COSTS_ROUNDS,
                                 .confidence = 0.95,
                                 .stay = 2 * DUET_LEVELS};
    *p = (level_costs){0};
    if (def->alone && !duet_device_pair_is_one(def->pair))
        list_rows(p, def, 0);
    list_rows(p, def, def->alone ? 1 : LEVEL_COSTS_BOTH);
    duet_world_def world = duet_scene_world_def(def->scene, def->pair);
    survey s = {.costs = p,
                .def = def,
                .scene = def->scene,
                .plan = world.plan,
                .cores = core_watch_open(),
                .race = race_begin(p->n, &rounds),
                .begun_ns = clock_steady_ns()};
    s.world = duet_world_create(&world, err);
    bool ok = s.world && duet_world_set_scene(s.world, s.scene, err) &&
              duet_reference(s.scene, DUET_LEVEL_CERTIFIED, &s.truth, &p->truth, err) &&
              run_rounds(&s, err);
    if (ok)
        draw_conclusions(&s);
    p->cores = core_watch_tally(s.cores);
    core_watch_close(s.cores);
    duet_free(s.truth);
    duet_world_destroy(s.world);
    return ok;
}

// ---------------------------------------------------------------- the choice

// A level that promises more may cost this much before a level that promises less is worth it: less
// than that is noise.
static const double WORTH = 1.02;

static duet_accuracy wrong_of(const profile_level_cost *cost)
{
    double pairs = fmax((double)cost->true_pairs, 1);
    return (duet_accuracy){(double)cost->missed / pairs, (double)cost->invented / pairs};
}

static duet_level level_of(const profile_level_cost *cost)
{
    duet_level level = DUET_LEVELS;
    duet_level_from_name(cost->level, &level);
    return level;
}

// Copies the costs of the levels to choose from.
static uint32_t list_offers(const profile_level_cost *costs, uint32_t n_costs,
                            const duet_level *levels, uint32_t n_levels, profile_level_cost *offers)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < n_costs; ++i)
        for (uint32_t k = 0; k < n_levels; ++k)
            if (levels[k] == level_of(&costs[i])) {
                offers[n++] = costs[i];
                break;
            }
    return n;
}

// Returns how far an offer is above what is allowed; 0 if it is within.
static double excess(const profile_level_cost *offer, const duet_accuracy *accuracy)
{
    duet_accuracy wrong = wrong_of(offer);
    return fmax(wrong.missed - accuracy->missed, 0) +
           fmax(wrong.false_rate - accuracy->false_rate, 0);
}

// The one that is least above what is allowed, and of equal ones the quickest.
static const profile_level_cost *find_nearest(const profile_level_cost *offers, uint32_t n,
                                              const duet_accuracy *accuracy)
{
    const profile_level_cost *best = offers;
    for (uint32_t i = 1; i < n; ++i) {
        double above = excess(&offers[i], accuracy), least = excess(best, accuracy);
        if (above < least || (above == least && offers[i].step_ns < best->step_ns))
            best = &offers[i];
    }
    return best;
}

// The quickest of those that promise all that `than` does, and more.
static const profile_level_cost *safer_for_nothing(const profile_level_cost *offers, uint32_t n,
                                                   const profile_level_cost *than,
                                                   const duet_accuracy *accuracy)
{
    const profile_level_cost *best = than;
    for (uint32_t i = 0; i < n; ++i) {
        const profile_level_cost *o = &offers[i];
        bool promises_more = duet_level_covers(level_of(o), level_of(best)) &&
                             !duet_level_covers(level_of(best), level_of(o));
        if (promises_more && excess(o, accuracy) <= 0 && o->step_ns <= WORTH * than->step_ns)
            best = o;
    }
    return best;
}

bool level_choose(const profile_level_cost *costs, uint32_t n_costs, const duet_level *levels,
                  uint32_t n_levels, const duet_accuracy *accuracy, duet_level *level,
                  duet_error *err)
{
    profile_level_cost offers[PROFILE_LEVEL_COSTS];
    uint32_t n = list_offers(costs, n_costs, levels, n_levels, offers);
    const profile_level_cost *nearest = find_nearest(offers, n, accuracy);
    if (n == 0)
        return error_set(err, DUET_STATUS_NOT_FOUND,
                         "none of the levels to choose from runs on both devices");
    if (excess(nearest, accuracy) > 0)
        return error_set(err, DUET_STATUS_NOT_FOUND,
                         "no level to choose from is within missed %.6g and false rate %.6g: '%s' "
                         "comes nearest, with %.6g and %.6g",
                         accuracy->missed, accuracy->false_rate, nearest->level,
                         wrong_of(nearest).missed, wrong_of(nearest).false_rate);
    *level = level_of(safer_for_nothing(offers, n, nearest, accuracy));
    return true;
}
