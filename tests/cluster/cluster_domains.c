// SPDX-License-Identifier: MIT
// A rank by itself: levels of sizes, domains, the objects in them, and loops.
#include "cluster/cluster.h"
#include "cluster/crowd.h"

#include "cluster/interior.h"
#include "cluster/owner.h"
#include "runtime/narrowphase/rounded.h"
#include "runtime/narrowphase/sat_frame.h"

#include <inttypes.h>
#include <math.h>
#include <unistd.h>

// ---------------------------------------------------------------- levels

FACT(levels_are_octaves_below_the_widest)
{
    MUST(level_of(8, 8) == SIZE_LEVELS - 1 && level_of(7.9, 8) == SIZE_LEVELS - 2,
         "the widest has its own");
    MUST(level_of(0, 8) == 0 && level_of(0, 0) == SIZE_LEVELS - 1, "points");
    MUST(level_of(1e-30, 8) == 0 && level_of(INFINITY, INFINITY) == SIZE_LEVELS - 1, "the ends");
    MUST(level_of(1, INFINITY) == 0, "below what has no end");
    rng r = rng_seed(3);
    for (int i = 0; i < 1000; ++i) {
        double a = exp2(rng_between(&r, -20, 3)), b = exp2(rng_between(&r, -20, 3));
        MUST(!(a < b) || level_of(a, 8) <= level_of(b, 8), "wider is no lower");
    }
}

// ---------------------------------------------------------------- places

// Halves without points too have boxes that hold what is theirs and nothing else.
FACT(a_part_is_its_box)
{
    rng r = rng_seed(14);
    for (int round = 0; round < 200; ++round) {
        uint32_t n = 1 + rng_below(&r, 9);
        uint64_t n_points = rng_below(&r, 20);
        bisection b;
        bisection_point points[20] = {{{0}, 0}}, copy[20];
        must(bisection_begin(&b, n, ERR));
        for (uint64_t i = 0; i < n_points; ++i) {
            points[i].weight = 1;
            for (int k = 0; k < 3; ++k)
                points[i].at[k] = rng_below(&r, 3);
        }
        memcpy(copy, points, sizeof copy);
        bisection_cut(&b, NULL, copy, n_points);
        for (uint64_t i = 0; i < n_points; ++i)
            for (uint32_t part = 0; part < n; ++part) {
                bool inside = true;
                extent box = bisection_box(&b, part, &extent_all);
                for (int k = 0; k < 3; ++k)
                    inside &= points[i].at[k] >= box.lower[k] && points[i].at[k] < box.upper[k];
                MUST(inside == (bisection_part(&b, points[i].at) == part), "its box");
            }
        bisection_end(&b);
    }
}

// Points of a box with these sides, and its cut into four parts.
static void cut_box(bisection *b, rng *r, const double sides[3])
{
    enum { POINTS = 2000 };
    bisection_point points[POINTS];
    for (int i = 0; i < POINTS; ++i) {
        points[i].weight = 1;
        for (int k = 0; k < 3; ++k)
            points[i].at[k] = rng_between(r, 0, sides[k]);
    }
    bisection_cut(b, NULL, points, POINTS);
}

// Sides of almost one width take turns in being the widest, and cuts stay across those that they
// were across; one that is far wider is cut.
FACT(cuts_stay_across_their_sides)
{
    rng r = rng_seed(15);
    bisection b;
    must(bisection_begin(&b, 4, ERR));
    cut_box(&b, &r, (const double[]){10, 9, 2});
    MUST(b.planes[2].axis == 0 && b.planes[1].axis == 1 && b.planes[3].axis == 1, "the widest");
    for (int i = 0; i < 20; ++i) {
        cut_box(&b, &r, (const double[]){rng_between(&r, 9.8, 10), rng_between(&r, 9.8, 10), 2});
        MUST(b.planes[2].axis == 0 && fabs(b.planes[2].at - 4.95) < 0.5, "the same sides");
    }
    cut_box(&b, &r, (const double[]){10, 20, 2});
    MUST(b.planes[2].axis == 1 && fabs(b.planes[2].at - 10) < 1, "a side that is far wider");
    bisection_end(&b);
}

// Each object passed over is sound and lies inside, and none is wider than is said.
FACT(what_is_found_inside_is_deep_inside)
{
    static crowd c;
    rng r = rng_seed(15);
    const extent inside = {{-2.5, -2.25, -3}, {2.5, 3, 2.7}};
    uint32_t found = 0;
    for (uint32_t i = 0; i < 12; ++i) {
        make_crowd(&c, &r, i < 8 ? i : SPHERES - 8 + i);
        object_form form = object_form_of(&c.world);
        if (form.origin == 0 && form.shape == DUET_SHAPE_POSES && c.n > 9)
            c.poses[7].rotation[1] = NAN;
        const object_rows rows = {.objects = (void *)(uintptr_t)objects_of(&c), .n = c.n};
        for (uint32_t first = 0, end; first < c.n; first = end + 1) {
            interior s = interior_none;
            end = object_rows_add_interior(&rows, &form, first, c.n, &inside, &s);
            MUST(end >= first && end <= c.n, "a row");
            for (uint32_t k = first; k < end; ++k, ++found) {
                double at[3];
                extent e = extent_of(&form, object_row(&rows, &form, k));
                object_centre(&form, object_row(&rows, &form, k), at);
                MUST(object_is_sound(&form, object_row(&rows, &form, k)), "sound");
                for (int d = 0; d < 3; ++d)
                    MUST(at[d] > inside.lower[d] && at[d] < inside.upper[d] &&
                             at[d] >= s.centres.lower[d] && at[d] <= s.centres.upper[d],
                         "inside");
                MUST(extent_widest(&e) <= interior_widest(&s, &form), "no wider");
            }
        }
    }
    MUST(found > 200, "some were");
}

// Rounds as the plain C reference does, which the devices do in the same way.
static duet_bounds bounds_in_float(const crowd *c, uint32_t id)
{
    duet_rounded_box box = rounded_of_sphere(&c->spheres[id]);
    return c->world.shape == DUET_SHAPE_POSES
               ? sat_bounds(&c->poses[id], c->world.dims, c->world.rotated)
               : sat_rounded_bounds(c->world.shape == DUET_SHAPE_SPHERES ? &box : &c->rounded[id],
                                    c->world.dims, c->world.rotated);
}

// Covers boxes that turn and those that do not, of all sizes, and of points at 0.
FACT(extents_hold_what_devices_take)
{
    static crowd c;
    static const uint32_t crowds[] = {0, 3, 6, SPHERES, SPHERES + 1, ROUNDED, ROUNDED + 1, 54};
    rng r = rng_seed(19);
    for (uint32_t i = 0; i < 16; ++i) {
        make_crowd(&c, &r, crowds[i / 2]);
        c.world.rotated = i % 2;
        object_form form = object_form_of(&c.world);
        for (uint32_t id = 0; id < c.n; ++id) {
            uint32_t numbers = c.world.shape == DUET_SHAPE_SPHERES ? 4 : 6;
            memset(row_of(&c, id), 0, id == 0 ? numbers * sizeof(float) : 0);
            extent e = extent_of(&form, row_of(&c, id));
            duet_bounds b = bounds_in_float(&c, id);
            for (uint32_t k = 0; k < c.world.dims; ++k)
                MUST(e.lower[k] <= (double)b.lower[k] && e.upper[k] >= (double)b.upper[k], c.name);
        }
    }
}

enum { ROWS_OF_TIDY = 64, DOMAINS_OF_TIDY = 7 };

// Whether each row is that of its id, and in one run, of the domain whose box holds it. Returns how
// many runs there are.
static uint64_t must_be_in_domains(owned *o, classes *c, uint64_t there)
{
    uint64_t seen = 0;
    uint32_t n = 0;
    must(classify(c, o) && owned_sort_runs(o, ERR));
    for (uint32_t i = 0; i < o->n_domains; ++i) {
        const domain *d = &o->domains[i];
        uint32_t n_before = n;
        for (uint64_t k = d->run; k < d->run + d->n_runs; ++k) {
            const row_run *run = &o->runs.runs[k];
            MUST(run->domain == i && run->at == n - n_before, "behind each other");
            n += run->n;
            for (uint32_t row = run->first; row < run->first + run->n; ++row) {
                double centre[3];
                const duet_bounds *at = object_row(&o->rows, &o->form, row);
                object_centre(&o->form, at, centre);
                MUST(bisection_part(&o->planes, centre) == i, "each lies in its domain");
                MUST(at->upper[1] == (float)o->rows.ids[row], "rows stay whole");
                seen |= UINT64_C(1) << o->rows.ids[row];
            }
        }
        MUST(d->n == n - n_before, "counted");
    }
    MUST(n == o->rows.n && seen == there, "all are there, once");
    return o->runs.n;
}

static duet_bounds some_bounds(uint64_t id, rng *r)
{
    float x = (float)rng_between(r, 0, 9);
    return (duet_bounds){.lower = {x, -1, -1}, .upper = {x, (float)id, 1}};
}

// Rows come to their domains, some of which are empty, and stay there as random ones leave and
// come.
FACT(rows_come_to_their_domains)
{
    static const extent all = {{-1e9, -1e9, -1e9}, {1e9, 1e9, 1e9}};
    rng r = rng_seed(16);
    parallel team;
    duet_world_def def = duet_default_world_def();
    def.shape = DUET_SHAPE_BOUNDS;
    worker *w = must(worker_open_plain(&def, NULL, ERR)), *const workers[2] = {w, w};
    must(parallel_begin(&team, 3, 1, ERR));
    for (int round = 0; round < 300; ++round) {
        owned o;
        classes c = {0};
        object_rows rows;
        uint32_t n_domains = 2 + rng_below(&r, DOMAINS_OF_TIDY - 1);
        uint32_t n = rng_below(&r, ROWS_OF_TIDY / 2);
        uint64_t there = 0;
        must(owned_begin(&o, n_domains, n_domains, &team, ERR));
        o.form = (object_form){.dims = 3, .shape = DUET_SHAPE_BOUNDS, .bytes = sizeof(duet_bounds)};
        must(object_rows_begin(&rows, &o.form, n, ERR));
        for (uint32_t i = 0; i < n; ++i) {
            duet_bounds b = some_bounds(i, &r);
            rows.ids[i] = i;
            memcpy(object_row(&rows, &o.form, i), &b, sizeof b);
            there |= UINT64_C(1) << i;
        }
        owned_take(&o, &rows);
        must(owned_place(&o, &all, workers, ERR));
        MUST(must_be_in_domains(&o, &c, there) <= n_domains, "placed together");
        for (int step = 0; step < 9; ++step) {
            unsigned char messages[ROWS_OF_TIDY][sizeof(uint64_t) + sizeof(duet_bounds)];
            parcels in = {.rows = messages, .row_bytes = sizeof *messages};
            uint32_t few = rng_below(&r, 3) > 0 ? 9 : 1; // or all
            for (uint32_t row = 0; row < o.rows.n; ++row)
                if (rng_below(&r, few) == 0) {
                    row_list_add(&o.leavers, row);
                    there &= ~(UINT64_C(1) << o.rows.ids[row]);
                }
            uint64_t taken = there;
            for (uint64_t id = 0; id < ROWS_OF_TIDY; ++id)
                if (!(taken >> id & 1) && rng_below(&r, 9) == 0) {
                    duet_bounds b = some_bounds(id, &r);
                    object_write_message(&o.form, messages[in.n++], id, &b);
                    there |= UINT64_C(1) << id;
                }
            must(owned_add_newcomers(&o, &in, ERR));
            owned_tidy(&o);
            must_be_in_domains(&o, &c, there);
        }
        owned_end(&o);
        classes_end(&c);
    }
    w->close(w);
    parallel_end(&team);
}

JOB_MAIN(1, 20261122, "each rank places objects rightly")
