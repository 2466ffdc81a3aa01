// SPDX-License-Identifier: MIT
// Finds the column of bodies that needs the shortest substeps, in two passes over the blocks: from
// below, how many layers lie under each; from above, where the weight of all that it bears presses.
#include "runtime/dynamics/substeps.h"

#include "base/error.h"
#include "runtime/dynamics/height_map.h"
#include "runtime/dynamics/motion.h"

#include <math.h>
#include <stdlib.h>

typedef enum column_kind {
    COLUMN_UPRIGHT,
    COLUMN_LEANING, // its weight presses more than a tenth off the middle of what bears it
} column_kind;

// Bodies on each other. The edge is that of cubes as slender: width^2 / height, the least of an
// upright column's bodies; of a leaning one twice the way from where its weight presses to the rim
// of what bears it, squared, by the height of its lowest body.
typedef struct column {
    column_kind kind;
    uint32_t layers; // 0: no body can stand
    double edge;
} column;

// ---------------------------------------------------------------- what a column needs

// A column of N bodies stands if its springs hold it alone, or if it keeps the levers that it has
// upright and sways too slowly to fall: then it may be as tall as stands with springs a tenth as
// stiff, and must not sink so far that manifolds are made again. One that leans has no such levers;
// it falls anyway if twice the most substeps would not hold it.
static const double plain_limit = 0.98, kept_limit = 10.0, margin_part = 1.0 / 3.0;

// Substeps of a spring's swing (set_solver in motion_step.c).
static const double substeps_a_swing = 6.0;

enum { LEAST = 4, MOST = 32 };

static double gravity_of(const duet_motion_def *def)
{
    return sqrt(def->gravity[0] * def->gravity[0] + def->gravity[1] * def->gravity[1] +
                (def->dims == 3 ? def->gravity[2] * def->gravity[2] : 0.0));
}

static double substeps_of(const duet_motion *m, double stiffness)
{
    const double pi = 3.14159265358979323846;
    return ceil(m->def.dt * sqrt(stiffness) * substeps_a_swing / (2.0 * pi));
}

// The least square of a spring's angular frequency that holds the column.
static double stiffness_for(const duet_motion *m, const column *c)
{
    double n = c->layers, g = gravity_of(&m->def);
    double plain = n * n * n * g / (plain_limit * c->edge);
    if (c->kind == COLUMN_LEANING)
        return substeps_of(m, plain) <= 2 * MOST ? plain : 0.0;
    if (c->layers < 2)
        return 0.0;
    double sway = n * n * n * g / (kept_limit * c->edge);
    double sink = n * g / (margin_part * m->margin);
    return fmin(plain, fmax(sway, sink));
}

// ---------------------------------------------------------------- columns

// How far off the middle the weight of an upright column presses, as a part of half the width.
static const double upright = 0.1;

// Bodies that are thrown down at random touch here and there, but not three above each other.
enum { LEAST_LEANING = 3 };

// The weight of a block and of all that it bears, and where it presses.
typedef struct load {
    uint32_t layers; // from the block upwards
    double mass, moment[2];
} load;

// The least rectangle about all places of contact of a block with its supports.
typedef struct footing {
    double from[2], to[2];
} footing;

static footing overlap(const block *a, const block *b)
{
    footing f;
    for (int k = 0; k < 2; ++k) {
        f.from[k] = fmax(a->at[k] - a->reach[k] + a->radius, b->at[k] - b->reach[k] + b->radius);
        f.to[k] = fmin(a->at[k] + a->reach[k] - a->radius, b->at[k] + b->reach[k] - b->radius);
    }
    return f;
}

static footing footing_of(const height_map *map, const support *s, uint64_t n)
{
    footing all = overlap(&map->blocks[s[0].upper], &map->blocks[s[0].lower]);
    for (uint64_t i = 1; i < n; ++i) {
        footing f = overlap(&map->blocks[s[i].upper], &map->blocks[s[i].lower]);
        for (int k = 0; k < 2; ++k) {
            all.from[k] = fmin(all.from[k], f.from[k]);
            all.to[k] = fmax(all.to[k], f.to[k]);
        }
    }
    return all;
}

// Kind upright: it does not lean, or nothing can hold it.
static column leaning(const height_map *map, const block *b, const load *l, const footing *f)
{
    double least = INFINITY, lean = 0.0;
    for (uint32_t k = 0; k < map->n_flat; ++k) {
        double half = 0.5 * (f->to[k] - f->from[k]);
        double off = fabs(l->moment[k] / l->mass - 0.5 * (f->to[k] + f->from[k]));
        least = fmin(least, half - off);
        lean = fmax(lean, off / half);
    }
    if (l->layers < LEAST_LEANING || !(least > 0.0) || lean <= upright)
        return (column){0};
    return (column){COLUMN_LEANING, l->layers, 4.0 * least * least / (b->top - b->bottom)};
}

// On one support the weight presses where its centre is; on several in the middle of each, in equal
// parts.
static void hand_down(const height_map *map, const load *l, const support *s, uint64_t n,
                      load *loads)
{
    for (uint64_t i = 0; i < n; ++i) {
        footing f = overlap(&map->blocks[s[i].upper], &map->blocks[s[i].lower]);
        load *lower = &loads[s[i].lower];
        double mass = l->mass / (double)n;
        lower->mass += mass;
        for (int k = 0; k < 2; ++k)
            lower->moment[k] +=
                mass * (n == 1 ? l->moment[k] / l->mass : 0.5 * (f.from[k] + f.to[k]));
        if (l->layers >= lower->layers)
            lower->layers = l->layers + 1;
    }
}

// Touches all that it stands on, and is pressed into none of it.
static bool lies(const height_map *map, const support *s, uint64_t n, double margin)
{
    bool all = n > 0;
    for (uint64_t i = 0; i < n; ++i)
        all = all && map->blocks[s[i].upper].bottom - map->blocks[s[i].lower].top >= -margin;
    return all;
}

typedef struct finding {
    const duet_motion *m;
    column *found;
} finding;

static void consider(const finding *f, const column *c)
{
    if (f->found->layers == 0 || stiffness_for(f->m, c) > stiffness_for(f->m, f->found))
        *f->found = *c;
}

// The most layers and the least edge of all that a block stands on.
static void find_upright(const height_map *map, column *columns, const finding *f)
{
    uint64_t i = 0;
    for (uint32_t place = 0; place < map->n; ++place) {
        column *c = &columns[place];
        *c = (column){COLUMN_UPRIGHT, map->blocks[place].mass > 0.0, map->blocks[place].edge};
        for (; i < map->n_supports && map->supports[i].upper == place; ++i) {
            const column *below = &columns[map->supports[i].lower];
            if (below->layers == 0)
                continue;
            if (below->layers >= c->layers)
                c->layers = below->layers + 1;
            c->edge = fmin(c->edge, below->edge);
        }
        if (c->layers > 0)
            consider(f, c);
    }
}

static void find_leaning(const height_map *map, load *loads, const finding *f)
{
    uint64_t end = map->n_supports;
    for (uint32_t place = map->n; place-- > 0;) {
        const block *b = &map->blocks[place];
        load *l = &loads[place];
        uint64_t n = 0;
        for (; end > 0 && map->supports[end - 1].upper == place; --end)
            ++n;
        const support *s = &map->supports[end];
        if (!lies(map, s, n, f->m->margin))
            continue;
        l->layers += l->layers == 0;
        l->mass += b->mass;
        for (int k = 0; k < 2; ++k)
            l->moment[k] += b->mass * b->at[k];
        const footing under = footing_of(map, s, n);
        const column c = leaning(map, b, l, &under);
        if (c.layers > 0)
            consider(f, &c);
        hand_down(map, l, s, n, loads);
    }
}

// Finds the column that needs the shortest substeps.
static bool find_column(const duet_motion *m, column *found, duet_error *err)
{
    height_map map;
    *found = (column){0};
    bool ok = height_map_open(&map, m);
    column *columns = malloc(((size_t)map.n + 1) * sizeof *columns);
    load *loads = calloc((size_t)map.n + 1, sizeof *loads);
    ok = ok && columns && loads;
    if (ok) {
        const finding f = {m, found};
        find_upright(&map, columns, &f);
        find_leaning(&map, loads, &f);
    }
    free(loads);
    free(columns);
    height_map_close(&map);
    return ok || no_memory(err, "the columns of %u bodies", m->n);
}

// ---------------------------------------------------------------- substeps

static uint32_t substeps_for(const duet_motion *m, const column *c)
{
    return (uint32_t)fmax(LEAST, fmin(MOST, substeps_of(m, stiffness_for(m, c))));
}

bool motion_choose_substeps(duet_motion *m, duet_error *err)
{
    const uint32_t all = DUET_EFFECT_CONTACT_RESPONSE | DUET_EFFECT_GRAVITY;
    if (m->def.substeps > 0)
        return true;
    column tallest = {0};
    bool falls = (m->effects & all) == all && m->def.attraction == 0.0;
    if (falls && !find_column(m, &tallest, err))
        return false;
    m->def.substeps = substeps_for(m, &tallest);
    m->substeps = (duet_substep_info){.substeps = m->def.substeps,
                                      .chosen = true,
                                      .layers = tallest.layers,
                                      .edge = tallest.edge};
    return true;
}

bool duet_motion_explain_substeps(const duet_motion *m, duet_substep_info *info)
{
    if (!m || !info)
        return false;
    *info = m->substeps;
    info->substeps = m->def.substeps;
    return true;
}
