// SPDX-License-Identifier: MIT
// What must hold for bodies that move over any number of ranks, in one job that is cut into smaller
// groups: the state hash of one motion.
//
// Every rank runs this; a fact that does not hold on one ends the job with a line.
#include "cluster/cluster.h"
#include "cluster/colouring.h"
#include "cluster/job.h"
#include "cluster/moving_domains.h"
#include "cluster/row_order.h"

#include "base/rng.h"
#include "base/text.h"
#include "base/text_file.h"
#include "kernels/dynamics/records.h"
#include "runtime/broadphase/world.h"

#include <math.h>
#include <string.h>

// ---------------------------------------------------------------- scenes of files

#define SHOCKS "cluster_motion_shocks.lua"
#define EVENTS "cluster_motion_events.lua"
#define FAR "cluster_motion_far.lua"
#define APART "cluster_motion_apart.lua"
#define BARE "cluster_motion_bare.lua"
#define GIANT "cluster_motion_giant.lua"
#define MIXER "cluster_motion_mixer.lua"
#define MESH "cluster_motion_mesh.lua"
#define UNEQUAL "cluster_motion_unequal.lua"

typedef struct moving_scene {
    const char *path;
    const duet_setting settings[4];
    uint32_t n_settings, steps;
    uint64_t least_contacts; // at the end
    uint32_t saved_at;       // the step at which it is saved, and goes on from the file; 0: none
} moving_scene;

// A motion came to this: its state, and sums over all events of all steps.
typedef struct outcome {
    uint64_t hash;
    uint64_t events, stays, hits; // how many
    uint64_t told;                // a sum of hashes of them, each with its step
} outcome;

// FNV-1a of bytes.
static uint64_t add_bytes(uint64_t hash, const void *bytes, size_t n)
{
    for (size_t i = 0; i < n; ++i)
        hash = (hash ^ ((const uint8_t *)bytes)[i]) * 0x100000001B3u;
    return hash;
}

static uint64_t begin_hash(uint64_t step, uint64_t kind, uint32_t a, uint32_t b)
{
    const uint64_t words[] = {step, kind, a, b};
    return add_bytes(0xCBF29CE484222325u, words, sizeof words);
}

static void add_events(outcome *o, uint64_t step, const duet_event *events, uint64_t n)
{
    for (uint64_t i = 0; i < n; ++i) {
        const duet_event *e = &events[i];
        MUST(i == 0 || e[-1].a < e->a || (e[-1].a == e->a && e[-1].b < e->b), "events ascend");
        o->told += begin_hash(step, e->begins, e->a, e->b);
    }
    o->events += n;
}

static void add_stays(outcome *o, uint64_t step, const duet_pair *stays, uint64_t n)
{
    for (uint64_t i = 0; i < n; ++i)
        o->told += begin_hash(step, 2, stays[i].a, stays[i].b);
    o->stays += n;
}

static void add_hits(outcome *o, uint64_t step, const duet_hit_event *hits, uint64_t n)
{
    for (uint64_t i = 0; i < n; ++i) {
        const duet_hit_event *h = &hits[i];
        uint64_t hash = begin_hash(step, 3, h->a, h->b);
        hash = add_bytes(hash, h->point, sizeof h->point);
        hash = add_bytes(hash, h->normal, sizeof h->normal);
        hash = add_bytes(hash, &h->speed, sizeof h->speed);
        o->told += add_bytes(hash, &h->impulse, sizeof h->impulse);
    }
    o->hits += n;
}

// ---------------------------------------------------------------- the truth

static outcome outcome_of_one(const moving_scene *s, duet_device_pair *pair)
{
    outcome o = {0};
    duet_motion_result result;
    duet_scene *scene = must(duet_scene_load(s->path, s->settings, s->n_settings, ERR));
    duet_motion_def def = duet_scene_motion_def(scene, pair);
    duet_motion *motion = must(duet_motion_create_from_scene(&def, scene, NULL, ERR));
    for (uint32_t i = 0; i < s->steps; ++i) {
        must(duet_motion_advance(motion, &result, ERR));
        add_events(&o, i, result.events, result.n_events);
        add_stays(&o, i, result.stays, result.n_stays);
        add_hits(&o, i, result.hits, result.n_hits);
    }
    must(duet_motion_get_hash(motion, &o.hash, ERR));
    duet_motion_destroy(motion);
    duet_scene_destroy(scene);
    return o;
}

// Rank 0 finds it.
static outcome expected_outcome(const moving_scene *s)
{
    outcome o = {0};
    if (rank == 0) {
        duet_device_pair_def def = duet_default_device_pair_def();
        duet_device_pair *pair = must(duet_device_pair_create(&def, ERR));
        o = outcome_of_one(s, pair);
        duet_device_pair_destroy(pair);
    }
    MPI_Bcast(&o, sizeof o, MPI_BYTE, 0, MPI_COMM_WORLD);
    return o;
}

static uint64_t expected_hash(const moving_scene *s)
{
    return expected_outcome(s).hash;
}

// ---------------------------------------------------------------- ranks

static void add_told(outcome *o, uint64_t step, const duet_cluster_motion_result *result)
{
    add_events(o, step, result->events, result->n_events);
    add_stays(o, step, result->stays, result->n_stays);
    add_hits(o, step, result->hits, result->n_hits);
}

static void must_tell_alike(outcome all, const outcome *expected, duet_cluster *c, const char *what)
{
    ranks_sum(&c->ranks, &all.hash, sizeof all / sizeof(uint64_t));
    MUST(all.events == expected->events, what);
    MUST(all.stays == expected->stays, what);
    MUST(all.hits == expected->hits, what);
    MUST(all.told == expected->told, what);
}

// A motion takes the other's place, as a job that is started again.
static void save_and_resume(duet_cluster *cluster, const moving_scene *s)
{
    static const char file[] = "cluster_motion_at.ck";
    must(duet_cluster_save_motion(cluster, file, ERR));
    must(duet_cluster_begin_motion(cluster, s->path, s->settings, s->n_settings, file, ERR));
    MUST(duet_cluster_get_motion_step(cluster) == s->saved_at, "the step that was saved");
    if (rank == 0)
        remove(file);
}

// Ghosts come after each colour, or after so many.
static const uint32_t colours_between[] = {1, 31, 4};

static duet_cluster_def def_of(uint32_t parts, uint32_t colours)
{
    duet_cluster_def def = duet_default_cluster_def();
    def.parts = parts;
    snprintf(def.world.plan.variant_b, sizeof def.world.plan.variant_b, "auto motion.colours=%u",
             colours);
    return def;
}

// The motion on the first n ranks; NULL on the others. However few contacts may be solved while
// ghosts travel, they are.
static duet_cluster *begin_on(int n, duet_cluster_def def, const moving_scene *s)
{
    duet_cluster *c = cluster_of(n, def);
    if (c) {
        must(duet_cluster_begin_motion(c, s->path, s->settings, s->n_settings, NULL, ERR));
        c->moving->least_inner = 1;
    }
    return c;
}

static void must_move_to(const moving_scene *s, const outcome *expected, int n_ranks,
                         uint32_t parts, uint32_t colours)
{
    duet_cluster *cluster = begin_on(n_ranks, def_of(parts, colours), s);
    if (!cluster)
        return;
    char what[160];
    outcome own = {0};
    uint32_t most_colours = 0;
    duet_cluster_motion_result result = {0};
    for (uint32_t i = 0; i < s->steps; ++i) {
        if (i > 0 && i == s->saved_at)
            save_and_resume(cluster, s);
        must(duet_cluster_advance(cluster, &result, ERR));
        most_colours = result.colours > most_colours ? result.colours : most_colours;
        add_told(&own, i, &result);
    }
    must(duet_cluster_get_state_hash(cluster, &own.hash, ERR));
    snprintf(what, sizeof what, "%s on %d ranks of %u, after %u colours", s->path, n_ranks, parts,
             colours);
    MUST(result.step == s->steps, what);
    MUST(result.contacts >= s->least_contacts, what);
    MUST(strcmp(s->path, GIANT) != 0 || most_colours == COLOUR_OVERFLOW + 1, what);
    MUST(s->least_contacts == 0 || n_ranks * parts == 1 || result.ghosts > 0, what);
    MUST(own.hash == expected->hash, what);
    must_tell_alike(own, expected, cluster, what);
    duet_cluster_destroy(cluster);
}

static outcome must_move_alike(const moving_scene *s, const int (*shapes)[2], size_t n)
{
    outcome expected = expected_outcome(s);
    for (size_t i = 0; i < n; ++i)
        must_move_to(s, &expected, shapes[i][0], (uint32_t)shapes[i][1], colours_between[i % 3]);
    return expected;
}

static void a_flight_has_one_motions_bits(void)
{
    static const int shapes[][2] = {{1, 3}, {2, 1}, {3, 1}, {4, 2}, {5, 1}, {8, 1}};
    const moving_scene s = {"orbit2d", {{"n", "300"}}, 1, 12, 0, 0};
    must_move_alike(&s, shapes, sizeof shapes / sizeof *shapes);
}

static void a_pile_has_one_motions_bits(void)
{
    static const int shapes[][2] = {{1, 1}, {1, 4}, {2, 1}, {3, 1}, {4, 1}, {5, 1}, {8, 1}};
    const moving_scene s = {"falling", {{"n", "120"}, {"sleep", "false"}}, 2, 32, 1, 0};
    must_move_alike(&s, shapes, sizeof shapes / sizeof *shapes);
}

// ---------------------------------------------------------------- while ghosts travel

static void note_travelling(const halo_side *s, uint32_t k, bool *travels)
{
    const halo_item *items = s->items.items;
    for (uint64_t i = 0; i < s->items.n; ++i)
        if (items[i].domain == k)
            travels[items[i].place] = true;
}

// Returns how many of the last step's contacts of a domain are solved while ghosts travel: they
// have no body that does.
static uint64_t inner_contacts(const moving *m, uint32_t k)
{
    uint64_t found = 0;
    domain_contacts c;
    duet_motion *motion = m->domains[k].motion;
    const uint32_t n = motion->graph.n_contacts;
    bool *travels = must(calloc((size_t)motion->n + FIXED, sizeof *travels));
    uint32_t *list = must(malloc(((size_t)n + 1) * sizeof *list));
    note_travelling(&m->halo.sent, k, travels);
    note_travelling(&m->halo.received, k, travels);
    must(domain_read_contacts(motion, false, &c, ERR));
    must(n == 0 || motion_fetch(motion, "list", LIST, 0, list, n * sizeof *list, ERR));
    for (uint32_t colour = 0; colour < COLOUR_OVERFLOW; ++colour) {
        const colour_span *span = &motion->solver.colours[colour];
        for (uint32_t i = span->border; i < span->count; ++i, ++found) {
            const uint32_t *ends = c.links[list[span->first + i]].s;
            MUST(!travels[ends[0]] && !travels[ends[1]],
                 "inner contacts have no body that travels");
        }
    }
    domain_contacts_free(&c);
    free(list);
    free(travels);
    return found;
}

// After a step that exchanged no bodies lists are those that it solved.
static void what_is_solved_while_ghosts_travel_has_none(void)
{
    static const uint32_t colours[] = {1, 4};
    const moving_scene s = {"falling", {{"n", "800"}, {"sleep", "false"}}, 2, 100, 500, 0};
    for (int i = 0; rank == 0 && i < 2; ++i) {
        uint64_t inner = 0;
        duet_cluster_motion_result result;
        duet_cluster *cluster = begin_on(ALONE, def_of(2, colours[i]), &s);
        for (uint32_t step = 0; step < s.steps; ++step) {
            const uint64_t sent = cluster->moving->counts.sent;
            must(duet_cluster_advance(cluster, &result, ERR));
            for (uint32_t k = 0; k < 2 && cluster->moving->counts.sent == sent; ++k)
                inner += inner_contacts(cluster->moving, k);
        }
        MUST(inner > 5000, "many contacts are solved while ghosts travel");
        duet_cluster_destroy(cluster);
    }
}

// ---------------------------------------------------------------- how often ghosts come

static uint64_t exchanges_of(const moving_scene *s, uint64_t hash, uint32_t colours)
{
    uint64_t found = 0;
    duet_cluster_motion_result result;
    duet_cluster *cluster = begin_on(ALONE, def_of(3, colours), s);
    for (uint32_t i = 0; i < s->steps; ++i)
        must(duet_cluster_advance(cluster, &result, ERR));
    MUST(result.contacts >= s->least_contacts, "many push");
    must(duet_cluster_get_state_hash(cluster, &found, ERR));
    MUST(found == hash, "ghosts that come less often give other bits");
    uint64_t n = cluster->moving->halo.n_exchanges;
    duet_cluster_destroy(cluster);
    return n;
}

// A pile of 12 colours; a sweep has an exchange at its end, if each domain solves what it needs.
static void ghosts_come_once_a_sweep(void)
{
    const moving_scene s = {"falling", {{"n", "400"}, {"sleep", "false"}}, 2, 90, 500, 0};
    uint64_t hash = expected_hash(&s);
    if (rank > 0)
        return;
    uint64_t each = exchanges_of(&s, hash, 1), four = exchanges_of(&s, hash, 4),
             all = exchanges_of(&s, hash, 31);
    MUST(2 * four < each, "half as many after four colours");
    MUST(3 * all < each, "less than a third after all of them");
}

// At the end all of it sleeps, after bodies fell asleep and woke beside borders.
static void a_pile_that_falls_asleep_has_one_motions_bits(void)
{
    static const int shapes[][2] = {{1, 3}, {2, 2}};
    const moving_scene s = {"falling", {{"n", "60"}}, 1, 320, 0, 0};
    must_move_alike(&s, shapes, sizeof shapes / sizeof *shapes);
}

static void other_effects_have_one_motions_bits(void)
{
    static const int shapes[][2] = {{1, 5}, {3, 1}};
    const moving_scene bullets = {"bullets", {{0}}, 0, 12, 1, 0};
    const moving_scene marbles = {"marbles", {{"n", "100"}}, 1, 40, 1, 0};
    const moving_scene terrain = {"terrain", {{"n", "100"}}, 1, 80, 1, 0};
    must_move_alike(&bullets, shapes, sizeof shapes / sizeof *shapes);
    must_move_alike(&marbles, shapes, 1);
    must_move_alike(&terrain, shapes, 1);
}

// Rank 0 alone reads the triangles, and the boxes lie over all of them.
static void a_pile_on_a_mesh_has_one_motions_bits(void)
{
    static const int shapes[][2] = {{1, 3}, {2, 1}, {3, 2}};
    const moving_scene s = {MESH, {{0}}, 0, 60, 1, 30};
    job_write(MESH, "for i = 0, 23 do\n"
                    "  add { centre = { i % 6, i // 6, 1.5 + i % 3 },\n"
                    "        half_extents = { 0.45, 0.45, 0.4 } }\n"
                    "end\n"
                    "return {\n"
                    "  dims = 3, gravity = { 0, 0, -9.81 }, wants = { 'contact_response' },\n"
                    "  mesh = { vertices = { -5, -5, 0, 10, -5, 0, 10, 10, 0.5, -5, 10, 0.5 },\n"
                    "           triangles = { 0, 1, 2, 0, 2, 3 } },\n"
                    "}\n");
    must_move_alike(&s, shapes, sizeof shapes / sizeof *shapes);
    job_remove(MESH);
}

// The carrier is no neighbour of most bodies. In the mixer it comes last, turns, rises, and is a
// box that bodies lie on, too; bodies fall asleep far from it. On four domains of the drum two
// grains part and touch again, with another colour, while a domain that left their contact to its
// home still has the colour of before.
static void a_carried_mesh_has_one_motions_bits(void)
{
    static const int shapes[][2] = {{1, 1}, {1, 4}, {2, 1}, {3, 1}, {4, 2}};
    const moving_scene drum = {"drum", {{"n", "120"}}, 1, 60, 30, 30};
    const moving_scene mixer = {MIXER, {{0}}, 0, 90, 1, 45};
    must_move_alike(&drum, shapes, sizeof shapes / sizeof *shapes);
    job_write(MIXER,
              "for i = 0, 47 do\n"
              "  add { centre = { i % 8 - 3.5, i // 8 - 2.5, 0.5 + i % 3 },\n"
              "        half_extents = { 0.4, 0.4, 0.3 }, friction = 0.6 }\n"
              "end\n"
              "add { centre = { 0, 0, 0.1 }, half_extents = { 0.6, 0.6, 0.3 }, mass = 0,\n"
              "      velocity = { 0, 0, 0.1 }, angular_velocity = { 0, 0, 0.5 } }\n"
              "return {\n"
              "  dims = 3, gravity = { 0, 0, -9.81 }, skin = 0.1,\n"
              "  wants = { 'contact_response', 'sleep', 'events', 'continuous' },\n"
              "  mesh = { vertices = { -9, -9, 0, 9, -9, 0, 9, 9, 0, -9, 9, 0, 0, -4, 0.5,\n"
              "                        0, 4, 0.5, 0.2, 0, 0 },\n"
              "           triangles = { 0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 5 }, carrier = 48 },\n"
              "}\n");
    must_move_alike(&mixer, shapes, sizeof shapes / sizeof *shapes);
    job_remove(MIXER);
}

// It has more contacts than there are colours, in all domains.
static void a_giant_on_small_ones_has_one_motions_bits(void)
{
    static const int shapes[][2] = {{1, 1}, {1, 4}, {3, 1}};
    const moving_scene s = {GIANT, {{0}}, 0, 16, 1, 0};
    job_write(GIANT, "for i = 0, 79 do\n"
                     "  local x, y = i % 9, i // 9\n"
                     "  add { centre = { x, y, 0.45 }, half_extents = { 0.4, 0.4, 0.4 } }\n"
                     "end\n"
                     "add { centre = { 4, 4, 1.9 }, half_extents = { 5, 5, 1 }, mass = 40 }\n"
                     "return {\n"
                     "  dims = 3, gravity = { 0, 0, -9.81 }, boundary = 'walls',\n"
                     "  world = { lower = { -2, -2, 0 }, upper = { 11, 11, 20 } },\n"
                     "  body = { friction = 0.5, restitution = 0.3 },\n"
                     "}\n");
    must_move_alike(&s, shapes, sizeof shapes / sizeof *shapes);
    job_remove(GIANT);
}

// ---------------------------------------------------------------- what is told

// Boxes fall through a sensor onto a floor, a sensor that stands in a box, and bodies of one group
// that is told of; a fast sensor passes them all.
static void write_events_scene(void)
{
    job_write(EVENTS,
              "for i = 0, 47 do\n"
              "  local x, y = i % 8, i // 8\n"
              "  add { centre = { x + 0.01 * y, y, 1 + 0.31 * (i * 7 % 11) },\n"
              "        half_extents = { 0.4, 0.45, 0.3 }, group = i % 5 == 0 and 2 or 1,\n"
              "        velocity = { 0, 0, i % 3 == 0 and -2 or 1 } }\n"
              "end\n"
              "add { centre = { 3.5, 2.5, 1 }, half_extents = { 4, 3, 0.1 }, mass = 0,\n"
              "      sensor = true }\n"
              "add { centre = { 3.5, -2, 0.5 }, half_extents = { 4, 0.5, 0.5 }, mass = 0 }\n"
              "add { centre = { 1, -2, 0.5 }, half_extents = { 0.2, 1, 0.2 }, mass = 0,\n"
              "      sensor = true }\n"
              "add { centre = { -1, 2, 1 }, half_extents = { 0.3, 0.3, 0.3 }, sensor = true,\n"
              "      velocity = { 6, 0.4, 7 } }\n"
              "return {\n"
              "  dims = 3, gravity = { 0, 0, -9.81 }, boundary = 'walls', hit_speed = 0.6,\n"
              "  world = { lower = { -2, -3, 0 }, upper = { 9, 7, 20 } },\n"
              "  wants = { 'contact_response', 'events', 'sleep' }, event_mask = 3,\n"
              "  body = { friction = 0.5, restitution = 0.4 },\n"
              "}\n");
}

static void events_are_one_motions(void)
{
    static const int shapes[][2] = {{1, 1}, {1, 3}, {2, 1}, {3, 2}, {5, 1}};
    const moving_scene s = {EVENTS, {{0}}, 0, 90, 1, 45};
    write_events_scene();
    outcome o = must_move_alike(&s, shapes, sizeof shapes / sizeof *shapes);
    MUST(o.events > 200 && o.stays > 1000 && o.hits > 50, "much is told");
    job_remove(EVENTS);
}

// Without response bodies fly through each other and through sensors, and what touches is told.
static void touches_without_response_are_one_motions(void)
{
    static const int shapes[][2] = {{1, 1}, {1, 3}, {2, 1}, {3, 2}, {5, 1}};
    const moving_scene s = {EVENTS, {{0}}, 0, 60, 0, 25};
    job_write(EVENTS, "for i = 0, 59 do\n"
                      "  local x, y = i % 10, i // 10\n"
                      "  add { centre = { 1.2 * x, 1.2 * y, 0.5 + 0.2 * (i % 3) },\n"
                      "        half_extents = { 0.4, 0.3, 0.3 }, sensor = i % 11 == 3,\n"
                      "        mass = i % 13 == 5 and 0 or 1, group = 1 << i % 2,\n"
                      "        velocity = { 3 - i % 7, i % 5 - 2, 0.1 * (i % 4) } }\n"
                      "end\n"
                      "return { dims = 3, wants = { 'events', 'sensors' }, event_mask = 1 }\n");
    outcome o = must_move_alike(&s, shapes, sizeof shapes / sizeof *shapes);
    MUST(o.events > 100 && o.stays > 100 && o.hits == 0, "much is told");
    job_remove(EVENTS);
}

// A blow goes through a row from end to end.
static void shocks_have_one_motions_bits(void)
{
    static const int shapes[][2] = {{1, 4}, {2, 1}, {3, 1}, {5, 1}};
    const moving_scene s = {SHOCKS, {{0}}, 0, 40, 1, 0};
    job_write(SHOCKS,
              "for i = 0, 9 do\n"
              "  add { centre = { i, 0, 0 }, radius = 0.5, mass = 1 + i % 2 }\n"
              "  add { centre = { i, 0.3, 1.5 }, half_extents = { 0.5, 0.5, 0.5 } }\n"
              "end\n"
              "add { centre = { -3, 0, 0 }, radius = 0.5, velocity = { 9, 0, 0 } }\n"
              "add { centre = { 13, 0.3, 1.5 }, half_extents = { 0.5, 0.5, 0.5 },\n"
              "      velocity = { -7, 0, 0 } }\n"
              "return { dims = 3, body = { restitution = 0.9, friction = 0.2 }, dt = 1 / 60,\n"
              "         world = { lower = { -5, -2, -2 }, upper = { 15, 3, 4 } },\n"
              "         wants = { 'contact_response', 'shocks' } }\n");
    must_move_alike(&s, shapes, sizeof shapes / sizeof *shapes);
    job_remove(SHOCKS);
}

// ---------------------------------------------------------------- beginnings

// Bodies that begin in each other are taken apart before they are divided.
static void bodies_are_taken_apart_as_in_one_motion(void)
{
    static const int shapes[][2] = {{1, 1}, {1, 3}, {3, 1}};
    const moving_scene s = {APART, {{0}}, 0, 24, 1, 10};
    job_write(APART, "for i = 0, 39 do\n"
                     "  add { centre = { 0.7 * (i % 8), 0.8 * (i // 8), 0.5 + 0.1 * (i % 3) },\n"
                     "        half_extents = { 0.5, 0.45, 0.4 } }\n"
                     "end\n"
                     "return {\n"
                     "  dims = 3, gravity = { 0, 0, -9.81 }, boundary = 'walls',\n"
                     "  world = { lower = { -2, -2, 0 }, upper = { 12, 8, 20 } },\n"
                     "  wants = { 'contact_response', 'depenetration', 'events', 'sleep' },\n"
                     "  body = { friction = 0.5 },\n"
                     "}\n");
    must_move_alike(&s, shapes, sizeof shapes / sizeof *shapes);
    job_remove(APART);
}

// A pile and what flies on, 10 000 km from 0, over the edges of cells.
static void origin_cells_have_one_motions_bits(void)
{
    static const int shapes[][2] = {{1, 1}, {1, 4}, {2, 1}, {3, 1}, {5, 1}};
    const moving_scene s = {FAR, {{0}}, 0, 50, 1, 20};
    job_write(
        FAR,
        "local x0, y0 = 1e7, -2e7\n"
        "for i = 0, 47 do\n"
        "  add { centre = { x0 + 1.1 * (i % 6), y0 + 1.1 * (i // 6 % 4), 1 + 1.2 * (i // 24) },\n"
        "        half_extents = { 0.5, 0.45, 0.4 }, velocity = { 0.2 * (i % 3), 1, 0 } }\n"
        "end\n"
        "add { centre = { x0 + 3, y0 + 2, -1 }, half_extents = { 8, 8, 1 }, mass = 0 }\n"
        "add { centre = { x0 + 3, y0 - 20, 5 }, half_extents = { 0.3, 0.3, 0.3 },\n"
        "      velocity = { 40, 30, 10 } }\n"
        "return {\n"
        "  dims = 3, gravity = { 0, 0, -9.81 }, origin = 'cell', origin_edge = 4,\n"
        "  body = { friction = 0.5, restitution = 0.3 }, hit_speed = 0.3,\n"
        "  wants = { 'contact_response', 'sleep', 'events' },\n"
        "}\n");
    must_move_alike(&s, shapes, sizeof shapes / sizeof *shapes);
    job_remove(FAR);
}

// ---------------------------------------------------------------- other borders

// Between steps the borders are cut at random, so that bodies, with their contacts, their sleep and
// what is told of them, change domains all the time.
static void move_with_any_borders(const moving_scene *s, const outcome *expected, uint64_t seed)
{
    rng r = rng_seed(seed); // the same on all ranks
    outcome own = {0};
    duet_cluster_motion_result result;
    duet_cluster *cluster = begin_on(3, def_of(2, 31), s);
    if (!cluster)
        return;
    for (uint32_t i = 0; i < s->steps; ++i) {
        for (uint32_t k = 1; k < cluster->moving->cuts.n; ++k)
            cluster->moving->cuts.planes[k] =
                (bisection_plane){rng_between(&r, 0, 6), rng_below(&r, 3)};
        for (uint32_t times = rng_below(&r, 3); times > 0; --times)
            must(moving_settle(cluster->moving, ERR));
        must(duet_cluster_advance(cluster, &result, ERR));
        add_told(&own, i, &result);
    }
    must(duet_cluster_get_state_hash(cluster, &own.hash, ERR));
    MUST(own.hash == expected->hash, "other borders give other bits");
    must_tell_alike(own, expected, cluster, "other borders tell of others");
    duet_cluster_destroy(cluster);
}

static void borders_change_nothing(uint64_t seed)
{
    const moving_scene s = {EVENTS, {{0}}, 0, 90, 0, 0};
    write_events_scene();
    outcome expected = expected_outcome(&s);
    move_with_any_borders(&s, &expected, seed);
    job_remove(EVENTS);
}

// Between steps another number of colours is drawn, after which ghosts come.
static void colours_between_change_nothing(uint64_t seed)
{
    static const uint32_t drawn[] = {1, 2, 3, 4, 8, 31};
    const moving_scene s = {"falling", {{"n", "200"}, {"sleep", "false"}}, 2, 90, 200, 0};
    const uint64_t hash = expected_hash(&s);
    rng r = rng_seed(seed); // the same on all ranks
    uint64_t found = 0;
    duet_cluster_motion_result result;
    duet_cluster *cluster = begin_on(3, def_of(2, 1), &s);
    if (!cluster)
        return;
    for (uint32_t i = 0; i < s.steps; ++i) {
        const uint32_t every = drawn[rng_below(&r, sizeof drawn / sizeof *drawn)];
        must(moving_set_every(cluster->moving, every, ERR));
        MUST(moving_get_every(cluster->moving) == every, "the colours that were set");
        must(duet_cluster_advance(cluster, &result, ERR));
    }
    MUST(result.contacts >= s.least_contacts && result.ghosts > 0, "contacts at borders");
    must(duet_cluster_get_state_hash(cluster, &found, ERR));
    MUST(found == hash, "ghosts that come now more and now less often give other bits");
    duet_cluster_destroy(cluster);
}

// Each look at the clock takes as long, so exchanges are a large part of a step.
static uint64_t ticks_ns;

static uint64_t tick_ns(void)
{
    return ticks_ns += 1000;
}

static void advance_by(duet_cluster *cluster, uint64_t steps, duet_cluster_motion_result *result)
{
    uint64_t (*now_ns)(void) = ranks_now_ns;
    ranks_now_ns = tick_ns;
    for (uint64_t i = 0; i < steps; ++i)
        must(duet_cluster_advance(cluster, result, ERR));
    ranks_now_ns = now_ns;
}

static bool is_rival(uint32_t every)
{
    bool is = false;
    for (int i = 0; i < EVERY_RIVALS; ++i)
        is = is || every_rivals[i] == every;
    return is;
}

// If nobody says how often ghosts come, each number is tried; once somebody does, none is.
static void ghosts_that_are_tried_change_nothing(void)
{
    const moving_scene s = {"falling", {{"n", "200"}, {"sleep", "false"}}, 2, 130, 200, 0};
    const uint64_t hash = expected_hash(&s);
    uint64_t found = 0;
    duet_cluster_motion_result result;
    duet_cluster *cluster = begin_on(2, duet_default_cluster_def(), &s);
    if (!cluster)
        return;
    const every_trial *t = moving_get_trial(cluster->moving);
    advance_by(cluster, s.steps, &result);
    MUST(t->is_tried && is_rival(moving_get_every(cluster->moving)), "each number is tried");
    for (int i = 0; i < EVERY_RIVALS; ++i)
        MUST(t->best_ns[i] > 0, "each number's time");
    MUST(result.contacts >= s.least_contacts && result.ghosts > 0, "contacts at borders");
    must(duet_cluster_get_state_hash(cluster, &found, ERR));
    MUST(found == hash, "a trial of how often ghosts come gives other bits");
    must(moving_set_every(cluster->moving, 2, ERR));
    advance_by(cluster, 40, &result);
    MUST(!t->is_tried && t->turn == 0 && moving_get_every(cluster->moving) == 2, "as was said");
    duet_cluster_destroy(cluster);
}

static uint32_t most_own(const duet_cluster *c)
{
    uint32_t most = c->moving->domains[0].n_own;
    MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_UINT32_T, MPI_MAX, c->ranks.comm);
    return most;
}

// All bodies are one domain's, and the world is cut anew in the next step.
static void borders_follow_bodies(void)
{
    const moving_scene s = {"orbit2d", {{"n", "400"}}, 1, 0, 0, 0};
    duet_cluster_motion_result result;
    duet_cluster *cluster = begin_on(4, duet_default_cluster_def(), &s);
    if (!cluster)
        return;
    moving *m = cluster->moving;
    for (uint32_t k = 1; k < m->cuts.n; ++k)
        m->cuts.planes[k] = (bisection_plane){1e6, 0};
    must(moving_settle(m, ERR));
    MUST(most_own(cluster) == 400, "all are of one domain");
    must(duet_cluster_advance(cluster, &result, ERR));
    MUST(most_own(cluster) <= 104, "a quarter is each domain's");
    duet_cluster_destroy(cluster);
}

// Own bodies and ghosts whose bounds begin outside of the cells in which pairs were searched, or
// nearly so, and how many there are.
static void count_outside(const moving_domain *d, uint64_t counts[2])
{
    const grid_level *cells = &d->motion->graph.world->grid.levels[0];
    float *bounds = malloc(6 * (d->bodies.n + 1) * sizeof *bounds);
    MUST(bounds, "memory");
    domain_forget_bounds(d->motion);
    must(domain_read_bounds(d->motion, bounds, ERR));
    for (uint64_t i = 0; i < d->bodies.n; ++i) {
        bool inside = true;
        for (int k = 0; k < 3; ++k) {
            const float at = (bounds[6 * i + k] - cells->lower.s[k]) * cells->per_cell.s[k];
            inside &= at > -1.0f && at < (float)cells->cells.s[k] + 1.0f;
        }
        counts[0] += !inside;
        ++counts[1];
    }
    free(bounds);
}

// The world is cut across another side, and each domain's bodies lie elsewhere than before: the
// cells in which it searches pairs are where they are.
static void cells_follow_bodies(void)
{
    const moving_scene s = {"falling", {{"n", "2000"}}, 1, 0, 0, 0};
    duet_cluster_motion_result result;
    duet_cluster *cluster = begin_on(2, def_of(1, 1), &s);
    if (!cluster)
        return;
    moving *m = cluster->moving;
    for (uint32_t axis = 0; axis < 4; ++axis) {
        uint64_t counts[2] = {0};
        m->cuts.planes[1] = (bisection_plane){8.5, axis % 2};
        must(moving_settle(m, ERR));
        must(duet_cluster_advance(cluster, &result, ERR));
        count_outside(&m->domains[0], counts);
        MUST(counts[1] >= 900 && counts[0] == 0, "bodies lie in the cells");
    }
    duet_cluster_destroy(cluster);
}

// A step that one domain searches its pairs for has all of them search.
static void domains_search_together(void)
{
    const moving_scene s = {"falling", {{"n", "3000"}}, 1, 30, 0, 0};
    duet_cluster_motion_result result;
    uint32_t searched = 0;
    duet_cluster *cluster = begin_on(3, def_of(2, 1), &s);
    for (uint32_t i = 0; cluster && i < s.steps; ++i) {
        uint64_t counts[2] = {0};
        must(duet_cluster_advance(cluster, &result, ERR));
        for (uint32_t k = 0; k < cluster->moving->parts; ++k) {
            duet_motion *motion = cluster->moving->domains[k].motion;
            duet_result search;
            counts[0] += motion->n > 0;
            counts[1] += motion_take_search(motion, &search);
        }
        ranks_sum(&cluster->ranks, counts, 2);
        MUST(counts[1] == 0 || counts[1] == counts[0], "all domains search, or none does");
        searched += counts[1] > 0;
    }
    MUST(!cluster || (searched > 5 && searched + 5 < s.steps), "some steps have a search");
    duet_cluster_destroy(cluster);
}

// ---------------------------------------------------------------- checkpoints

// Takes steps of a pile on so many ranks, from a file or from the beginning, and saves it.
static uint64_t go_on(int n_ranks, uint32_t parts, uint32_t steps, const char *from, const char *to)
{
    const duet_setting settings[] = {{"n", "90"}};
    uint64_t hash = 0;
    duet_cluster_motion_result result;
    duet_cluster_def def = duet_default_cluster_def();
    def.parts = parts;
    duet_cluster *c = cluster_of(n_ranks, def);
    if (c) {
        must(duet_cluster_begin_motion(c, "falling", settings, 1, from, ERR));
        for (uint32_t i = 0; i < steps; ++i)
            must(duet_cluster_advance(c, &result, ERR));
        must(duet_cluster_get_state_hash(c, &hash, ERR));
        must(!to || duet_cluster_save_motion(c, to, ERR));
        duet_cluster_destroy(c);
    }
    MPI_Bcast(&hash, 1, MPI_UINT64_T, 0, MPI_COMM_WORLD);
    return hash;
}

static void must_be_the_same_bytes(const char *path, const char *other)
{
    text a = {0}, b = {0};
    must(text_read_file(&a, path, ERR) && text_read_file(&b, other, ERR));
    MUST(a.length == b.length && memcmp(a.chars, b.chars, a.length) == 0, other);
    text_free(&a);
    text_free(&b);
}

// Saved on 3 ranks, gone on with on 1 and on 5.
static void checkpoints_know_no_ranks(void)
{
    const char *three = "cluster_motion_3.ck", *one = "cluster_motion_1.ck";
    const moving_scene s = {"falling", {{"n", "90"}}, 1, 70, 0, 0};
    uint64_t expected = expected_hash(&s);
    go_on(3, 1, 40, NULL, three);
    go_on(1, 4, 40, NULL, one);
    if (rank == 0)
        must_be_the_same_bytes(three, one);
    MUST(go_on(5, 1, 30, three, NULL) == expected, "5 ranks go on from what 3 saved");
    MUST(go_on(1, 1, 30, three, NULL) == expected, "1 rank goes on from what 3 saved");
    job_remove(three);
    job_remove(one);
}

// The hash after so many more steps of one motion from a file, which rank 0 finds.
static uint64_t go_on_alone(const moving_scene *s, const char *from)
{
    uint64_t hash = 0;
    duet_motion_result result;
    duet_device_pair_def pair_def = duet_default_device_pair_def();
    duet_device_pair *pair = must(duet_device_pair_create(&pair_def, ERR));
    duet_scene *scene = must(duet_scene_load(s->path, s->settings, s->n_settings, ERR));
    duet_motion_def def = duet_scene_motion_def(scene, pair);
    duet_motion *motion = must(duet_motion_create_from_scene(&def, scene, NULL, ERR));
    must(duet_motion_load(motion, from, ERR));
    for (uint32_t i = s->saved_at; i < s->steps; ++i)
        must(duet_motion_advance(motion, &result, ERR));
    must(duet_motion_get_hash(motion, &hash, ERR));
    duet_motion_destroy(motion);
    duet_scene_destroy(scene);
    duet_device_pair_destroy(pair);
    return hash;
}

// Saved on n ranks of so many parts, gone on with by one motion.
static void must_go_on_alone(const moving_scene *s, uint64_t expected, int n, uint32_t parts)
{
    static const char file[] = "cluster_motion_alone.ck";
    duet_cluster_motion_result result;
    duet_cluster *c = begin_on(n, def_of(parts, 1), s);
    for (uint32_t i = 0; c && i < s->saved_at; ++i)
        must(duet_cluster_advance(c, &result, ERR));
    must(!c || duet_cluster_save_motion(c, file, ERR));
    duet_cluster_destroy(c);
    if (rank == 0)
        MUST(go_on_alone(s, file) == expected, "one motion goes on from what ranks saved");
    job_remove(file);
}

// Bodies that did not touch when they were saved do later, within a skin and without one, and all
// of a pile falls asleep.
static void one_motion_goes_on_from_what_ranks_saved(void)
{
    static const int shapes[][2] = {{1, 1}, {2, 1}, {3, 1}, {1, 2}};
    const moving_scene scenes[] = {{"falling", {{"n", "90"}}, 1, 40, 0, 15},
                                   {"falling", {{"n", "30"}}, 1, 150, 0, 110},
                                   {BARE, {{0}}, 0, 24, 0, 8}};
    job_write(BARE,
              "for i = 0, 59 do\n"
              "  add { centre = { i % 4 + 0.1 * (i % 3), i // 4 % 4, 0.6 + 1.05 * (i // 16) },\n"
              "        half_extents = { 0.5, 0.45, 0.4 } }\n"
              "end\n"
              "return {\n"
              "  dims = 3, gravity = { 0, 0, -9.81 }, boundary = 'walls',\n"
              "  world = { lower = { -1, -1, 0 }, upper = { 5, 5, 9 } },\n"
              "  wants = { 'contact_response', 'sleep' },\n"
              "}\n");
    for (size_t i = 0; i < sizeof scenes / sizeof *scenes; ++i) {
        const uint64_t expected = expected_hash(&scenes[i]);
        for (size_t k = 0; k < sizeof shapes / sizeof *shapes; ++k)
            must_go_on_alone(&scenes[i], expected, shapes[k][0], (uint32_t)shapes[k][1]);
    }
    job_remove(BARE);
}

// ---------------------------------------------------------------- failures

// Nothing moves then.
static void must_refuse(const char *path, duet_status status, const char *says)
{
    duet_cluster_motion_result result;
    duet_cluster *c = cluster_of(2, duet_default_cluster_def());
    if (!c)
        return;
    must_fail(duet_cluster_begin_motion(c, path, NULL, 0, NULL, ERR), status, says);
    must_fail(duet_cluster_advance(c, &result, ERR), DUET_STATUS_BAD_ARGUMENT,
              "expected duet_cluster_begin_motion first");
    duet_cluster_destroy(c);
}

static void what_is_not_there_is_refused(void)
{
    must_refuse("no_such_scene.lua", DUET_STATUS_NOT_FOUND, "no_such_scene.lua");
}

// ---------------------------------------------------------------- colours

enum { MOST_CONTACTS = 200, MOST_BODIES = 40 };

// Whether no two contacts at one body have one colour, of those below COLOUR_OVERFLOW.
static bool are_apart(const waiting_contact *c, uint64_t n)
{
    for (uint64_t i = 0; i < n; ++i)
        for (uint64_t k = 0; k < i; ++k) {
            bool meet = c[i].owner == c[k].owner ||
                        (c[i].other_moves && c[i].other == c[k].owner) ||
                        (c[k].other_moves && c[k].other == c[i].owner) ||
                        (c[i].other_moves && c[k].other_moves && c[i].other == c[k].other);
            if (meet && c[i].colour == c[k].colour && c[i].colour < COLOUR_OVERFLOW)
                return false;
        }
    return true;
}

// Which domain tells of a contact, and in which order, changes no colour.
static void colours_follow_from_ids(uint64_t seed)
{
    rng r = rng_seed(seed);
    waiting_contact once[MOST_CONTACTS], twice[2 * MOST_CONTACTS];
    uint64_t n = 0, m = 0, left;
    for (uint32_t a = 0; a < MOST_BODIES; ++a)
        for (uint32_t b = a + 1; b < MOST_BODIES && n < MOST_CONTACTS; ++b)
            if (rng_below(&r, 6) == 0)
                once[n++] =
                    (waiting_contact){a, b, b % 7 != 0, 1u << a % 5, 1u << b % 5, COLOUR_WAITS, 1};
    for (uint64_t i = n; i-- > 0;) {
        twice[m] = once[i];
        twice[m++].owner_used = 0;
        twice[m] = once[i];
        twice[m++].other_used = 0;
    }
    must(colouring_run(once, &n, &left, ERR) && left == 0);
    must(colouring_run(twice, &m, &left, ERR) && left == 0);
    MUST(m == n, "contacts that two domains know are one");
    MUST(memcmp(once, twice, n * sizeof *once) == 0, "other colours");
    MUST(are_apart(once, n), "two contacts of a body have one colour");
    for (uint64_t i = 0; i < n; ++i) {
        uint32_t used = once[i].owner_used | (once[i].other_moves ? once[i].other_used : 0);
        MUST(!(used >> once[i].colour & 1u), "a colour that an end had");
        MUST(colouring_find(once, n, once[i].owner, once[i].other) == once[i].colour, "found");
    }
    MUST(colouring_find(once, n, MOST_BODIES, 0) == COLOUR_NONE, "no such contact");
}

enum { HOMES = 4 };

// The contacts that a home knows: those of its own bodies, and of the bodies that these touch.
typedef struct home_contacts {
    waiting_contact contacts[5 * MOST_CONTACTS];
    uint64_t n, n_left;
} home_contacts;

static bool has_body(const waiting_contact *all, uint64_t n, const uint32_t *home, uint32_t k,
                     uint32_t body)
{
    bool has = home[body] == k;
    for (uint64_t i = 0; i < n && !has; ++i)
        has = (all[i].owner == body && home[all[i].other] == k) ||
              (all[i].other == body && all[i].other_moves && home[all[i].owner] == k);
    return has;
}

static bool is_of(const waiting_contact *c, const uint32_t *home, uint32_t k)
{
    return home[c->owner] == k || (c->other_moves && home[c->other] == k);
}

// Tells each home what another one decides, as far as it has an end of it.
static void tell_homes(const waiting_contact *all, uint64_t n, const uint32_t *home,
                       home_contacts *homes)
{
    static home_contacts before[HOMES];
    memcpy(before, homes, sizeof before);
    for (uint32_t k = 0; k < HOMES; ++k)
        for (uint32_t from = 0; from < HOMES; ++from)
            for (uint64_t i = 0; from != k && i < n; ++i) {
                const waiting_contact *c = &all[i];
                uint64_t place =
                    colouring_place(before[from].contacts, before[from].n, c->owner, c->other);
                if (place == before[from].n || !before[from].contacts[place].is_decided_here ||
                    !(has_body(all, n, home, k, c->owner) ||
                      (c->other_moves && has_body(all, n, home, k, c->other))))
                    continue;
                waiting_contact told = before[from].contacts[place];
                told.is_decided_here = 0;
                MUST(homes[k].n < 5 * MOST_CONTACTS, "space");
                homes[k].contacts[homes[k].n++] = told;
            }
}

// Homes that know of no more than their bodies and the ones that these touch find the colours that
// follow from all contacts, in some rounds.
static void homes_colour_together(uint64_t seed)
{
    static home_contacts homes[HOMES];
    rng r = rng_seed(seed);
    waiting_contact all[MOST_CONTACTS];
    uint32_t home[MOST_BODIES];
    uint64_t n = 0, left = 1, rounds = 0;
    for (uint32_t a = 0; a < MOST_BODIES; ++a)
        home[a] = rng_below(&r, HOMES);
    for (uint32_t a = 0; a < MOST_BODIES; ++a)
        for (uint32_t b = a + 1; b < MOST_BODIES && n < MOST_CONTACTS; ++b)
            if (rng_below(&r, 6) == 0)
                all[n++] =
                    (waiting_contact){a, b, b % 7 != 0, 1u << a % 5, 1u << b % 5, COLOUR_WAITS, 1};
    for (uint32_t k = 0; k < HOMES; ++k) {
        homes[k].n = 0;
        for (uint64_t i = 0; i < n; ++i) {
            if (!is_of(&all[i], home, k))
                continue;
            waiting_contact c = all[i];
            c.owner_used = home[c.owner] == k ? c.owner_used : 0;
            c.other_used = home[c.other] == k ? c.other_used : 0;
            homes[k].contacts[homes[k].n++] = c;
        }
    }
    for (; left > 0 && rounds < MOST_CONTACTS; ++rounds) {
        tell_homes(all, n, home, homes);
        left = 0;
        for (uint32_t k = 0; k < HOMES; ++k) {
            must(colouring_run(homes[k].contacts, &homes[k].n, &homes[k].n_left, ERR));
            left += homes[k].n_left;
        }
    }
    MUST(rounds > 1 && left == 0, "rounds end");
    must(colouring_run(all, &n, &left, ERR));
    for (uint32_t k = 0; k < HOMES; ++k)
        for (uint64_t i = 0; i < homes[k].n; ++i) {
            const waiting_contact *c = &homes[k].contacts[i];
            MUST(!c->is_decided_here || colouring_find(all, n, c->owner, c->other) == c->colour,
                 "a home finds the colours of all");
        }
}

// ---------------------------------------------------------------- closures

static duet_cluster *two_domains_after_steps(const char *n, uint32_t colours, uint32_t steps)
{
    const moving_scene s = {"falling", {{"n", n}}, 1, 0, 0, 0};
    duet_cluster *cluster = begin_on(ALONE, def_of(2, colours), &s);
    duet_cluster_motion_result result;
    for (uint32_t i = 0; i < steps; ++i)
        must(duet_cluster_advance(cluster, &result, ERR));
    return cluster;
}

enum { FIELD = 60, FIELD_CONTACTS = 150, SWEEPS = 3, WRONG = 0xBAD };

// Contacts of bodies on a line, each of one with another near it; the first `n_own` are a domain's.
typedef struct field {
    uint32_t n, n_own;
    uint32_t ends[FIELD_CONTACTS][2], colours[FIELD_CONTACTS];
    uint32_t used[FIELD];
    bool is_known[FIELD_CONTACTS]; // to the domain
} field;

static field random_field(rng *r)
{
    field f = {.n_own = FIELD / 3};
    for (int tries = 0; tries < 4 * FIELD_CONTACTS && f.n < FIELD_CONTACTS; ++tries) {
        uint32_t a = rng_below(r, FIELD - 1), b = a + 1 + rng_below(r, 6), colour = rng_below(r, 9);
        if (b >= FIELD || ((f.used[a] | f.used[b]) >> colour & 1u))
            continue;
        f.used[a] |= 1u << colour;
        f.used[b] |= 1u << colour;
        f.ends[f.n][0] = a;
        f.ends[f.n][1] = b;
        f.colours[f.n] = colour;
        f.is_known[f.n++] = a < f.n_own || rng_below(r, 8) > 0;
    }
    return f;
}

// The contact's impulse and both ends come to depend on each other.
static void solve_contact(uint64_t *impulse, uint64_t *a, uint64_t *b)
{
    *impulse = 0x9E3779B97F4A7C15u * (*impulse ^ *a) + (*b << 7 | *b >> 57);
    *a += 3 * *impulse;
    *b ^= *impulse >> 9;
}

static void solve_colour(const field *f, const bool *solved, uint32_t colour, uint64_t *impulses,
                         uint64_t *bodies)
{
    for (uint32_t i = 0; i < f->n; ++i)
        if (f->colours[i] == colour && (!solved || solved[i]))
            solve_contact(&impulses[i], &bodies[f->ends[i][0]], &bodies[f->ends[i][1]]);
}

// A device's answer: its ghosts, and which contacts are solved.
typedef struct found_closure {
    ghost_colours ghosts[FIELD];
    bool solved[FIELD_CONTACTS];
} found_closure;

static void write_words(duet_motion *m, motion_buffer which, const void *words, size_t bytes)
{
    must(motion_reserve(m, which, bytes, 1, ERR));
    must(timeline_write_at(&m->times, "test", &m->buffers[which], 0, words, bytes, ERR));
}

// The motion has the field's bodies and the contacts that the domain knows, instead of its own.
static void write_field(duet_motion *m, const field *f, uint32_t rows[FIELD_CONTACTS])
{
    domain_place *places = must(calloc(m->n + FIXED, sizeof *places));
    cl_uint2 links[FIELD_CONTACTS];
    cl_uint colours[FIELD_CONTACTS], at_home[FIELD][GHOST_WORDS] = {{0}};
    uint32_t n = 0;
    for (uint32_t i = 0; i < f->n; ++i)
        if (f->is_known[i]) {
            rows[n] = i;
            links[n] = (cl_uint2){{f->ends[i][0], f->ends[i][1]}};
            colours[n++] = f->colours[i];
        }
    for (uint32_t i = 0; i < FIELD; ++i) {
        places[i] = (domain_place){i, PLACE_MOVES | (i < f->n_own ? PLACE_OWN : 0)};
        at_home[i][GHOST_AT_HOME] = f->used[i];
    }
    must(domain_mark_places(m, places, ERR));
    must(domain_reserve_ghosts(m, ERR));
    write_words(m, LINKS, links, n * sizeof *links);
    write_words(m, COLOUR_OF, colours, n * sizeof *colours);
    write_words(m, GHOSTS, at_home, sizeof at_home);
    m->graph.n_contacts = n;
    must(timeline_finish(&m->times, ERR));
    free(places);
}

static found_closure closure_of(duet_motion *m, const field *f, uint32_t every)
{
    found_closure c = {0};
    uint32_t rows[FIELD_CONTACTS];
    cl_uint colours[FIELD_CONTACTS];
    write_field(m, f, rows);
    must(domain_close(m, every, ERR));
    must(motion_fetch(m, "test", GHOSTS, 0, c.ghosts, sizeof c.ghosts, ERR));
    must(
        motion_fetch(m, "test", COLOUR_OF, 0, colours, m->graph.n_contacts * sizeof *colours, ERR));
    for (uint32_t k = 0; k < m->graph.n_contacts; ++k) {
        c.solved[rows[k]] = colours[k] == f->colours[rows[k]];
        MUST(c.solved[rows[k]] || colours[k] == (COLOUR_LEFT | f->colours[rows[k]]),
             "solved or left");
        MUST(c.solved[rows[k]] || f->ends[rows[k]][0] >= f->n_own, "own ones are solved");
    }
    return c;
}

// Returns how often ghosts come. Ghosts that are wrong and do not come are wrong without bounds.
static uint32_t must_sweep_alike(const field *f, const found_closure *c, rng *r)
{
    uint64_t at_home[FIELD], here[FIELD], impulses[FIELD_CONTACTS], own[FIELD_CONTACTS];
    uint32_t times = 0;
    for (uint32_t i = 0; i < f->n; ++i)
        impulses[i] = own[i] = rng_next(r);
    for (uint32_t i = 0; i < FIELD; ++i) {
        at_home[i] = rng_next(r);
        here[i] = i < f->n_own || c->ghosts[i].here != 0 ? at_home[i] : WRONG;
    }
    for (int sweep = 0; sweep < SWEEPS; ++sweep)
        for (uint32_t colour = 0; colour <= HALO_END; ++colour) {
            uint32_t came = 0;
            solve_colour(f, NULL, colour, impulses, at_home);
            solve_colour(f, c->solved, colour, own, here);
            for (uint32_t i = f->n_own; i < FIELD; ++i)
                if (c->ghosts[i].comes >> colour & 1u) {
                    here[i] = at_home[i];
                    ++came;
                }
            times += came > 0;
        }
    MUST(memcmp(here, at_home, f->n_own * sizeof *here) == 0, "own bodies are right");
    for (uint32_t i = 0; i < f->n; ++i)
        MUST(!c->solved[i] || own[i] == impulses[i], "contacts that are solved are right");
    for (uint32_t i = f->n_own; i < FIELD; ++i)
        MUST(c->ghosts[i].here == 0 || here[i] == at_home[i],
             "ghosts with contacts are right after a sweep");
    return times;
}

// Contacts that the domain does not know, of bodies anywhere, make ghosts come sooner.
static void closures_leave_nothing_wrong(uint64_t seed)
{
    rng r = rng_seed(seed);
    uint32_t times[2] = {0};
    duet_cluster *cluster = two_domains_after_steps("200", 1, 1);
    duet_motion *m = cluster->moving->domains[0].motion;
    MUST(m->n > FIELD, "places for a field");
    for (int i = 0; i < 200; ++i) {
        const field f = random_field(&r);
        for (uint32_t every = 1; every <= 9; ++every) {
            const found_closure c = closure_of(m, &f, every);
            uint32_t n = must_sweep_alike(&f, &c, &r);
            times[0] += every == 1 ? n : 0;
            times[1] += every == 9 ? n : 0;
        }
    }
    MUST(times[1] > 0 && 2 * times[1] < times[0], "ghosts come less often");
    duet_cluster_destroy(cluster);
}

// ---------------------------------------------------------------- contacts that are asked for

enum { ASKED_MOST = ASKED_RECORD + 512 };

// A row of a coloured contact that follows another coloured one of the same owner.
static uint32_t second_coloured(duet_motion *m, cl_uint2 *links, cl_uint *colours)
{
    const uint32_t n = m->graph.n_contacts;
    must(motion_fetch(m, "test", LINKS, 0, links, n * sizeof *links, ERR));
    must(motion_fetch(m, "test", COLOUR_OF, 0, colours, n * sizeof *colours, ERR));
    for (uint32_t i = 1; i < n; ++i)
        if (links[i].s[0] == links[i - 1].s[0] && colours[i] < COLOUR_OVERFLOW &&
            colours[i - 1] < COLOUR_OVERFLOW)
            return i;
    MUST(false, "a body with two contacts");
    return 0;
}

static cl_uint colour_at(duet_motion *m, uint32_t row)
{
    cl_uint colour = 0;
    must(motion_fetch(m, "test", COLOUR_OF, row * sizeof colour, &colour, sizeof colour, ERR));
    return colour;
}

static uint32_t mistaken_after(duet_motion *m, const asked_contact *asked, const cl_uint *row)
{
    domain_closed closed;
    must(domain_take_asked(m, asked, 1, row, ERR));
    must(domain_count_closed(m, &closed, ERR));
    return closed.n_mistaken;
}

// A contact is found by an end and its colour. If another one comes instead, both are known again:
// the one was solved in the place of the other, and the other by a colour that it does not have.
static void asked_contacts_come_or_are_mistaken(void)
{
    duet_cluster *cluster = two_domains_after_steps("200", 31, 80);
    const moving_domain *d = &cluster->moving->domains[0];
    duet_motion *m = d->motion;
    const size_t n = m->graph.n_contacts, bytes = domain_asked_bytes(m);
    cl_uint2 *links = must(malloc(n * sizeof *links));
    cl_uint *colours = must(malloc(n * sizeof *colours)), row[ASKED_MOST], again[ASKED_MOST];
    const uint32_t i = second_coloured(m, links, colours);
    const asked_contact asked = {links[i].s[0], colours[i]};
    MUST(bytes <= sizeof row, "space for a record");
    must(domain_read_asked(m, &asked, 1, row, ERR));
    MUST(row[0] == d->places[links[i].s[0]].id && row[1] == d->places[links[i].s[1]].id, "its ids");
    row[ASKED_RECORD + 1] += 77;
    MUST(mistaken_after(m, &asked, row) == 0, "it is the one that was meant");
    must(domain_read_asked(m, &asked, 1, again, ERR));
    MUST(memcmp(row, again, bytes) == 0 && colour_at(m, i) == asked.colour, "it came");
    row[1] = d->places[links[i - 1].s[1]].id;
    MUST(mistaken_after(m, &asked, row) == 2, "another one came");
    MUST(colour_at(m, i) == (COLOUR_LEFT | COLOUR_NONE), "of this nothing is known");
    MUST(colour_at(m, i - 1) == (COLOUR_LEFT | asked.colour), "that has the colour at home");
    MUST(mistaken_after(m, &asked, row) == 2, "it is left to its home, and nothing rests on it");
    free(links);
    free(colours);
    duet_cluster_destroy(cluster);
}

// ---------------------------------------------------------------- bounds

static extent cube_at(double x, double y)
{
    return (extent){{x - 0.5, y - 0.5, 0.0}, {x + 0.5, y + 0.5, 1.0}};
}

// Two domains side by side, whose reaches overlap for x from 9 to 11.
static void bodies_far_from_borders_stay(void)
{
    extent reaches[] = {{{0, 0, 0}, {11, 10, 1}}, {{9, 0, 0}, {20, 10, 1}}};
    uint32_t others[] = {1, 0};
    const moving m = {.n_domains = 2, .reaches = reaches};
    const moving_domain first = {.number = 0, .neighbours = {.rows = &others[0], .n = 1}},
                        second = {.number = 1, .neighbours = {.rows = &others[1], .n = 1}};
    static const struct {
        double from, to; // x; y is 5
        bool stays;
    } moves[] = {
        {3, 3.2, true},   // inside
        {3, 8, true},     // it meets the other's reach neither before nor now
        {3, 9, false},    // now it does
        {9, 10.4, true},  // it did before, so it is a ghost there
        {9, 10.6, false}, // it leaves its own domain's reach
        {10.6, 9, true},  // back into it
    };
    for (size_t i = 0; i < sizeof moves / sizeof *moves; ++i) {
        const extent old = cube_at(moves[i].from, 5), now = cube_at(moves[i].to, 5);
        MUST(moving_stays(&m, &first, &old, &now) == moves[i].stays, "whether a body stays");
        const extent mirrored = cube_at(20 - moves[i].from, 5),
                     there = cube_at(20 - moves[i].to, 5);
        MUST(moving_stays(&m, &second, &mirrored, &there) == moves[i].stays, "as in a mirror");
    }
}

// ---------------------------------------------------------------- rows

// Three words of every four, in place and by the device.
static void vectors_leave_out_their_fourth(duet_motion *m)
{
    enum { WORDS = 32, TAKEN = 12, ROW = 5 };
    const uint32_t place = ROW;
    const row_parts whole = {.words = {WORDS}}, threes = {{0, 24}, {6, 6}, 3};
    static const uint32_t at[TAKEN] = {0, 1, 2, 4, 5, 6, 24, 25, 26, 28, 29, 30};
    uint32_t all[WORDS], in_place[TAKEN], packed[TAKEN];
    void *host = m->buffers[BODIES].host;
    MUST(motion_words(m, BODIES) == WORDS, "bodies turn");
    must(domain_pack_rows(m, BODIES, &whole, &place, 1, all, ERR));
    must(domain_pack_rows(m, BODIES, &threes, &place, 1, in_place, ERR));
    m->buffers[BODIES].host = NULL;
    must(domain_pack_rows(m, BODIES, &threes, &place, 1, packed, ERR));
    m->buffers[BODIES].host = host;
    MUST(all[2] != 0 && all[7] != 0, "it falls, and has an inertia");
    for (uint32_t k = 0; k < TAKEN; ++k)
        MUST(in_place[k] == all[at[k]] && packed[k] == all[at[k]], "three of every four");
}

// Parts of rows by a device that does not work on the host's memory: as one that does has them.
static void parts_of_rows_come_and_go(void)
{
    static const uint32_t places[] = {17, 3, 20};
    enum { N = sizeof places / sizeof *places };
    duet_cluster *cluster = two_domains_after_steps("80", 1, 1);
    duet_motion *m = cluster->moving->domains[0].motion;
    const uint32_t words = motion_words(m, VELOCITIES);
    const row_parts whole = {.words = {words}}, ends = {{0, words - 1}, {2, 1}, 0};
    uint32_t before[N * 8], after[N * 8], packed[3 * N], again[3 * N];
    void *host = m->buffers[VELOCITIES].host;
    MUST(words == 4 && m->n > 20 && host, "rows are of four words, and the host's");
    vectors_leave_out_their_fourth(m);
    must(domain_pack_rows(m, VELOCITIES, &whole, places, N, before, ERR));
    must(domain_pack_rows(m, VELOCITIES, &ends, places, N, packed, ERR));
    m->buffers[VELOCITIES].host = NULL;
    must(domain_pack_rows(m, VELOCITIES, &ends, places, N, again, ERR));
    MUST(memcmp(packed, again, sizeof packed) == 0, "the device packs the same");
    for (uint32_t i = 0; i < 3 * N; ++i)
        again[i] += 1000 + i;
    must(domain_unpack_rows(m, VELOCITIES, &ends, places, N, again, ERR));
    m->buffers[VELOCITIES].host = host;
    must(domain_pack_rows(m, VELOCITIES, &whole, places, N, after, ERR));
    for (uint32_t i = 0; i < N; ++i)
        for (uint32_t k = 0; k < words; ++k) {
            uint32_t at = k < 2 ? k : 2, more = k < 2 || k == words - 1 ? 1000 + 3 * i + at : 0;
            MUST(after[i * words + k] == before[i * words + k] + more,
                 "parts are written, and nothing else");
        }
    duet_cluster_destroy(cluster);
}

// ---------------------------------------------------------------- what a domain's device lists

static bool is_within(const float b[6], const float e[6])
{
    bool within = true;
    for (int k = 0; k < 3; ++k)
        within = within && b[k] >= e[k] && b[k + 3] <= e[k + 3];
    return within;
}

static bool do_meet(const float b[6], const float e[6])
{
    bool meet = true;
    for (int k = 0; k < 3; ++k)
        meet = meet && b[k] <= e[k + 3] && b[k + 3] >= e[k];
    return meet;
}

// Its own bodies that leave the first extent or meet another, each once and with its bounds.
static void bodies_near_extents_are_listed(void)
{
    static const float extents[][6] = {{-1, -1, -1, 6, 6, 6}, {0, 0, 0, 2, 2, 3}};
    duet_cluster *cluster = two_domains_after_steps("300", 1, 1);
    const moving_domain *d = &cluster->moving->domains[1];
    domain_near *near;
    uint32_t n, expected = 0;
    float *bounds = malloc(6 * d->bodies.n * sizeof *bounds);
    bool *told = calloc(d->bodies.n, sizeof *told);
    MUST(bounds && told, "memory");
    must(domain_list_near(d->motion, extents[0], 2, &near, &n, ERR));
    must(domain_read_bounds(d->motion, bounds, ERR));
    for (uint32_t i = 0; i < n; ++i) {
        MUST(near[i].place < d->bodies.n && !told[near[i].place], "a body is listed once");
        told[near[i].place] = true;
        MUST(memcmp(near[i].bounds, bounds + 6 * near[i].place, sizeof near[i].bounds) == 0,
             "with its bounds");
    }
    for (uint32_t i = 0; i < d->bodies.n; ++i) {
        const float *b = bounds + 6 * i;
        bool is_near = (d->places[i].kind & PLACE_OWN) &&
                       (!is_within(b, extents[0]) || do_meet(b, extents[1]));
        MUST(told[i] == is_near, "own bodies near extents");
        expected += is_near;
    }
    MUST(n == expected && n > 0 && n < d->n_own, "some are near");
    free(near);
    free(bounds);
    free(told);
    duet_cluster_destroy(cluster);
}

// Rows go where their bodies go, and those of bodies that were not there are 0.
static void rows_move_with_their_bodies(void)
{
    enum { WORDS = 4, MOST = 300 };
    static const motion_buffer list[] = {VELOCITIES};
    duet_cluster *cluster = two_domains_after_steps("300", 1, 1);
    duet_motion *m = cluster->moving->domains[0].motion;
    const uint32_t n = m->n + FIXED;
    const row_parts whole = {.words = {WORDS}};
    uint32_t places[MOST], from[MOST + FIXED], before[MOST * WORDS], after[MOST * WORDS];
    MUST(m->n <= MOST && m->n > 20 && motion_words(m, VELOCITIES) == WORDS, "rows of four words");
    for (uint32_t i = 0; i < n; ++i)
        from[i] = i % 3 == 0 || i >= m->n ? NO_PLACE : m->n - 1 - i;
    for (uint32_t i = 0; i < m->n; ++i)
        places[i] = i;
    must(domain_pack_rows(m, VELOCITIES, &whole, places, m->n, before, ERR));
    must(domain_move_rows(m, list, 1, from, n, ERR));
    must(domain_pack_rows(m, VELOCITIES, &whole, places, m->n, after, ERR));
    for (uint32_t i = 0; i < m->n; ++i)
        for (uint32_t k = 0; k < WORDS; ++k) {
            const uint32_t row = from[i] == NO_PLACE ? 0 : before[from[i] * WORDS + k];
            MUST(after[i * WORDS + k] == row, "a row moves with its body");
        }
    duet_cluster_destroy(cluster);
}

// ---------------------------------------------------------------- balance

// How much more the rank with the most work has than the mean one, as ranks weigh bodies and ends.
static double imbalance_of(const duet_cluster *c)
{
    const moving_domain *d = &c->moving->domains[0];
    const double ends = 2.0 * d->motion->solver.n_pushing;
    double most = work_of(&c->moving->balance.model, d->n_own, ends), sum = most;
    MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, c->ranks.comm);
    MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_DOUBLE, MPI_MAX, c->ranks.comm);
    return most * c->ranks.n / sum;
}

// Half of the bodies are a pile, and half of them touch nothing: equal numbers are unequal work.
static void ranks_have_alike_much_to_do(void)
{
    const moving_scene s = {UNEQUAL, {{0}}, 0, 60, 900, 0};
    duet_cluster_motion_result result;
    double first = 0, mean = 0;
    job_write(UNEQUAL,
              "for i = 0, 511 do\n"
              "  add { centre = { i % 8, i // 8 % 8, 0.45 + 0.9 * (i // 64) },\n"
              "        half_extents = { 0.5, 0.5, 0.45 } }\n"
              "  add { centre = { 40 + 3 * (i % 8), 3 * (i // 8 % 8), 200 + 3 * (i // 64) },\n"
              "        half_extents = { 0.5, 0.5, 0.45 } }\n"
              "end\n"
              "return { dims = 3, gravity = { 0, 0, -9.81 }, boundary = 'walls',\n"
              "         world = { lower = { -1, -1, 0 }, upper = { 90, 40, 300 } },\n"
              "         wants = { 'contact_response' } }\n");
    duet_cluster *cluster = begin_on(4, def_of(1, 1), &s);
    for (uint32_t i = 0; cluster && i < s.steps; ++i) {
        must(duet_cluster_advance(cluster, &result, ERR));
        const double now = imbalance_of(cluster);
        first = i == 0 ? now : first;
        mean += now / s.steps;
    }
    MUST(!cluster || result.contacts >= s.least_contacts, "a pile");
    MUST(!cluster || (first > 1.5 && mean < 1.2), "borders follow the work");
    duet_cluster_destroy(cluster);
    job_remove(UNEQUAL);
}

// ---------------------------------------------------------------- who is told of what waits

// Each contact goes to few of eight ranks, however many these are.
static void what_waits_is_told_to_who_has_an_end(void)
{
    const moving_scene s = {"falling", {{"n", "600"}}, 1, 110, 900, 0};
    const uint64_t hash = expected_hash(&s);
    duet_cluster_motion_result result;
    uint64_t found = 0, counts[2] = {0};
    duet_cluster *cluster = begin_on(8, def_of(1, 1), &s);
    for (uint32_t i = 0; cluster && i < s.steps; ++i)
        must(duet_cluster_advance(cluster, &result, ERR));
    if (!cluster)
        return;
    must(duet_cluster_get_state_hash(cluster, &found, ERR));
    counts[0] = cluster->moving->counts.waited;
    counts[1] = cluster->moving->counts.told;
    ranks_sum(&cluster->ranks, counts, 2);
    MUST(found == hash && result.contacts >= s.least_contacts, "one motion's pile");
    MUST(counts[0] > 100 && counts[1] < 4 * counts[0], "seven are not told of all that waits");
    duet_cluster_destroy(cluster);
}

// ---------------------------------------------------------------- what an exchange reads

// The home of each body, and how many own bodies have bounds that leave their domain's box.
static uint64_t note_homes(moving *m, uint32_t *home)
{
    uint64_t leaving = 0;
    for (uint32_t k = 0; k < m->parts; ++k) {
        const moving_domain *d = &m->domains[k];
        const extent box = bisection_box(&m->cuts, d->number, &extent_all);
        float *bounds = malloc(6 * d->bodies.n * sizeof *bounds);
        MUST(bounds, "memory");
        domain_forget_bounds(d->motion);
        must(domain_read_bounds(d->motion, bounds, ERR));
        for (uint32_t i = 0; i < d->bodies.n; ++i) {
            const float *b = bounds + 6 * i;
            const extent e = {{b[0], b[1], b[2]}, {b[3], b[4], b[5]}};
            if (!moving_is_own(d, &d->bodies.rows[i]))
                continue;
            home[d->bodies.rows[i].id] = d->number;
            leaving += !extent_within(&e, &box);
        }
        free(bounds);
    }
    return leaving;
}

// Own bodies that another domain has as ghosts, by their far boxes; those that were there before.
static uint64_t count_ghosts(const moving *m, const moving_domain *d, const uint32_t *home,
                             uint64_t *stayed)
{
    const row_parts whole = {.words = {6}};
    uint64_t n = 0;
    for (uint32_t i = 0; i < d->bodies.n; ++i) {
        float b[6];
        must(domain_pack_rows(d->motion, FAR_BOXES, &whole, &i, 1, b, ERR));
        const extent e = {{b[0], b[1], b[2]}, {b[3], b[4], b[5]}};
        for (uint32_t to = 0; moving_is_own(d, &d->bodies.rows[i]) && to < m->n_domains; ++to) {
            bool is_ghost = to != d->number && extents_meet(&e, &m->reaches[to]);
            n += is_ghost;
            *stayed += is_ghost && home[d->bodies.rows[i].id] == d->number;
        }
    }
    return n;
}

// The states of bodies that may leave their domain's box and of ghosts are read, and those of no
// others, however many there are.
static void an_exchange_reads_what_travels(void)
{
    enum { N = 6000 };
    duet_cluster *cluster = two_domains_after_steps("6000", 1, 1);
    moving *m = cluster->moving;
    uint32_t home[N], moved = 0;
    const moving_counts before = m->counts;
    const uint64_t leaving = note_homes(m, home);
    uint64_t shared = 0, stayed = 0;
    must(moving_settle(m, ERR));
    for (uint32_t k = 0; k < m->parts; ++k) {
        const moving_domain *d = &m->domains[k];
        shared += count_ghosts(m, d, home, &stayed);
        for (uint32_t i = 0; i < d->bodies.n; ++i)
            moved +=
                moving_is_own(d, &d->bodies.rows[i]) && home[d->bodies.rows[i].id] != d->number;
    }
    MUST(m->counts.read - before.read == leaving + stayed, "what may travel is read");
    MUST(m->counts.sent - before.sent == moved + shared, "what travels is sent");
    MUST(leaving > 0 && stayed > 0 && leaving + stayed < N / 2, "most bodies do not");
    duet_cluster_destroy(cluster);
}

// A motion begins, or goes on from a file, with the ghosts that its next exchange would choose. The
// scene's origin lies outside of one half, whose reach has nothing there.
static void a_motion_begins_with_the_ghosts_that_it_needs(void)
{
    enum { N = 6000 };
    for (uint32_t steps = 0; steps < 2; ++steps) {
        const moving_scene s = {"falling", {{"n", "6000"}}, 1, steps, 0, steps};
        duet_cluster *cluster = two_domains_after_steps("6000", 1, steps);
        if (steps > 0)
            save_and_resume(cluster, &s);
        moving *m = cluster->moving;
        const uint64_t at_first = m->halo.sent.items.n;
        must(moving_settle(m, ERR));
        MUST(at_first > 0 && at_first == m->halo.sent.items.n, "no ghost that is not needed");
        MUST(at_first < N / 2, "most bodies are far from the border");
        duet_cluster_destroy(cluster);
    }
}

// Rows in new places, as their definition says.
static void rows_are_spliced(uint64_t seed)
{
    enum { MOST = 200 };
    uint32_t from[MOST], fresh[MOST], rows[MOST], expected[MOST], came[MOST];
    rng random = rng_seed(seed);
    for (int round = 0; round < 2000; ++round) {
        const uint32_t before = rng_below(&random, MOST / 2), odds = 1 + rng_below(&random, 9);
        domain_bodies b = {.from = from, .fresh = fresh};
        for (uint32_t i = 0; i <= before; ++i) {
            for (uint32_t n = rng_below(&random, odds) ? 0 : rng_below(&random, 3); n > 0; --n)
                if (b.n < MOST - before) {
                    came[b.n_fresh] = expected[b.n] = 1000 + b.n_fresh;
                    fresh[b.n_fresh++] = b.n;
                    from[b.n++] = NO_PLACE;
                }
            if (i < before && rng_below(&random, odds) < 5) {
                expected[b.n] = i;
                from[b.n++] = i;
            }
        }
        for (uint32_t i = 0; i < before; ++i)
            rows[i] = i;
        domain_splice(&b, rows, came, sizeof *rows);
        MUST(memcmp(rows, expected, b.n * sizeof *rows) == 0, "rows go to their places");
    }
}

// ---------------------------------------------------------------- work

// Times are made of what bodies and ends cost, and these are found in them; of ranks that all have
// as many ends for a body nothing is learnt.
static void times_tell_what_contacts_cost(uint64_t seed)
{
    rng r = rng_seed(seed);
    work_model model = work_begin(), alike = work_begin();
    const double at_first = alike.end;
    for (int i = 0; i < 12; ++i) {
        work_row rows[3], same[3];
        for (int k = 0; k < 3; ++k) {
            double bodies = rng_between(&r, 1000, 2000), ends = rng_between(&r, 0, 9000);
            rows[k] = (work_row){bodies, ends, 300 * bodies + 750 * ends};
            same[k] = (work_row){bodies, 2 * bodies, rng_between(&r, 1e5, 1e6)};
        }
        work_note(&model, rows, 3);
        work_note(&alike, same, 3);
    }
    MUST(fabs(model.end - 2.5) < 1e-9, "an end costs two and a half bodies");
    MUST(alike.end == at_first, "nothing is learnt of ranks that are alike");
    MUST(fabs(work_of(&model, 100, 20) - 150) < 1e-6, "20 ends are the work of 50 bodies");
}

typedef struct long_row {
    uint64_t key, words[5];
} long_row;

static uint64_t key_of_long(const void *row)
{
    return ((const long_row *)row)->key;
}

// Ascending stretches of keys, some of them twice. Each key comes once, with its row, in order.
static void rows_come_in_order(uint64_t seed)
{
    enum { KEYS_MOST = 300 };
    rng r = rng_seed(seed);
    for (int round = 0; round < 60; ++round) {
        uint64_t seen[KEYS_MOST] = {0}, key = 0, n_seen = 0, at = 0;
        item_list rows = {0};
        for (uint32_t i = 0, n = rng_below(&r, 400); i < n; ++i) {
            key = rng_below(&r, 9) == 0 ? rng_below(&r, KEYS_MOST) : key + rng_below(&r, 3);
            key = round == 0 ? i : key % KEYS_MOST;
            if (key >= KEYS_MOST)
                break;
            n_seen += seen[key]++ == 0;
            const long_row row = {key, {key, key + 1, key + 2, key + 3, key + 4}};
            list_add(&rows, &row, 1, sizeof row);
        }
        MUST(row_order(&rows, sizeof(long_row), key_of_long) && rows.n == n_seen, "each key once");
        for (key = 0; key < KEYS_MOST; ++key) {
            const long_row *row = (const long_row *)rows.items + at;
            at += seen[key] > 0;
            MUST(seen[key] == 0 || (row->key == key && row->words[4] == key + 4), "rows in order");
        }
        free(rows.items);
    }
}

static void ids_are_found_at_their_places(uint64_t seed)
{
    enum { IDS = 2000 };
    rng r = rng_seed(seed);
    for (uint32_t one_of = 1; one_of < 400; one_of += 57) {
        moving_domain d = {0};
        moving m = {.n_all = IDS};
        uint32_t places[IDS + 40];
        for (uint32_t id = 0; id < IDS; ++id) {
            const moving_body b = {.id = id};
            const bool is_here = rng_below(&r, one_of) == 0;
            places[id] = is_here ? (uint32_t)d.bodies.n : UINT32_MAX;
            if (is_here)
                list_add(&d.bodies.list, &b, 1, sizeof b);
        }
        for (uint32_t id = IDS; id < IDS + 40; ++id) { // that came after the others were counted

            places[id] = (uint32_t)d.bodies.n;
            list_add(&d.bodies.list, &(moving_body){.id = id}, 1, sizeof(moving_body));
        }
        for (int indexed = 0; indexed < 2; ++indexed) {
            for (uint32_t id = 0; id < IDS + 40; ++id)
                MUST(moving_place(&d, id) == places[id], "the place of an id");
            moving_index_places(&m, &d, ERR);
        }
        free(d.bodies.rows);
        free(d.index.firsts);
    }
}

int main(int argc, char **argv)
{
    uint64_t seed = job_begin(&argc, &argv, 8, 20261128);
    if (rank == 0) {
        bodies_far_from_borders_stay();
        colours_follow_from_ids(seed);
        homes_colour_together(seed);
        closures_leave_nothing_wrong(seed);
        asked_contacts_come_or_are_mistaken();
        times_tell_what_contacts_cost(seed);
        parts_of_rows_come_and_go();
        bodies_near_extents_are_listed();
        rows_move_with_their_bodies();
        an_exchange_reads_what_travels();
        a_motion_begins_with_the_ghosts_that_it_needs();
        rows_are_spliced(seed);
        rows_come_in_order(seed);
        ids_are_found_at_their_places(seed);
    }
    what_is_not_there_is_refused();
    checkpoints_know_no_ranks();
    one_motion_goes_on_from_what_ranks_saved();
    borders_change_nothing(seed);
    colours_between_change_nothing(seed);
    ghosts_that_are_tried_change_nothing();
    borders_follow_bodies();
    cells_follow_bodies();
    domains_search_together();
    ranks_have_alike_much_to_do();
    what_waits_is_told_to_who_has_an_end();
    a_flight_has_one_motions_bits();
    a_pile_has_one_motions_bits();
    what_is_solved_while_ghosts_travel_has_none();
    ghosts_come_once_a_sweep();
    a_pile_that_falls_asleep_has_one_motions_bits();
    a_giant_on_small_ones_has_one_motions_bits();
    a_pile_on_a_mesh_has_one_motions_bits();
    a_carried_mesh_has_one_motions_bits();
    events_are_one_motions();
    touches_without_response_are_one_motions();
    shocks_have_one_motions_bits();
    bodies_are_taken_apart_as_in_one_motion();
    origin_cells_have_one_motions_bits();
    other_effects_have_one_motions_bits();
    return job_end("all facts hold on 1, 2, 3, 4, 5 and 8 ranks");
}
