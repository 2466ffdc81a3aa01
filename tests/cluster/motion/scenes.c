// SPDX-License-Identifier: MIT
// Any number of ranks and domains has one motion's bits, and tells what it tells.
#include "cluster/motion/moving.h"

#include "kernels/dynamics/records.h"

typedef struct told {
    uint64_t events, stays, hits;
} told;

// Each scene, and the ranks and domains of each that it moves on.
static const struct {
    moving_scene scene;
    int shapes[8][2];
    told more_than; // hits 0: there are none
} rows[] = {
    {{"orbit2d", {{"n", "300"}}, .steps = 12},
     .shapes = {{1, 3}, {2, 1}, {3, 1}, {4, 2}, {5, 1}, {8, 1}}},
    {{"falling", {{"n", "120"}, {"sleep", "false"}}, .steps = 32, .least_contacts = 1},
     .shapes = {{1, 1}, {1, 4}, {2, 1}, {3, 1}, {4, 1}, {5, 1}, {8, 1}}},
    // At the end all of it sleeps, after bodies fell asleep and woke beside borders.
    {{"falling", {{"n", "60"}}, .steps = 320}, .shapes = {{1, 3}, {2, 2}}},
    // On four domains of the drum two grains part and touch again, with another colour, while a
    // domain that left their contact to its home still has the colour of before.
    {{"drum", {{"n", "120"}}, .steps = 60, .least_contacts = 30, .saved_at = 30},
     .shapes = {{1, 1}, {1, 4}, {2, 1}, {3, 1}, {4, 2}}},
    {{"bullets", .steps = 12, .least_contacts = 1}, .shapes = {{1, 5}, {3, 1}}},
    {{"marbles", {{"n", "100"}}, .steps = 40, .least_contacts = 1}, .shapes = {{1, 5}}},
    {{"terrain", {{"n", "100"}}, .steps = 80, .least_contacts = 1}, .shapes = {{1, 5}}},
    {{"giant.lua", .steps = 16, .least_contacts = 1, .colours = COLOUR_OVERFLOW + 1},
     .shapes = {{1, 1}, {1, 4}, {3, 1}}},
    {{"mesh.lua", .steps = 60, .least_contacts = 1, .saved_at = 30},
     .shapes = {{1, 3}, {2, 1}, {3, 2}}},
    {{"mixer.lua", .steps = 90, .least_contacts = 1, .saved_at = 45},
     .shapes = {{1, 1}, {1, 4}, {2, 1}, {3, 1}, {4, 2}}},
    {{"events.lua", .steps = 90, .least_contacts = 1, .saved_at = 45},
     .shapes = {{1, 1}, {1, 3}, {2, 1}, {3, 2}, {5, 1}},
     .more_than = {200, 1000, 50}},
    {{"touches.lua", .steps = 60, .saved_at = 25},
     .shapes = {{1, 1}, {1, 3}, {2, 1}, {3, 2}, {5, 1}},
     .more_than = {100, 100, 0}},
    {{"shocks.lua", .steps = 40, .least_contacts = 1}, .shapes = {{1, 4}, {2, 1}, {3, 1}, {5, 1}}},
    {{"apart.lua", .steps = 24, .least_contacts = 1, .saved_at = 10},
     .shapes = {{1, 1}, {1, 3}, {3, 1}}},
    {{"far.lua", .steps = 50, .least_contacts = 1, .saved_at = 20},
     .shapes = {{1, 1}, {1, 4}, {2, 1}, {3, 1}, {5, 1}}},
};

static void must_move_to(const moving_scene *s, const outcome *expected, int n_ranks,
                         uint32_t parts, uint32_t colours)
{
    duet_cluster *cluster = begin_on(n_ranks, parts, colours, s);
    if (!cluster)
        return;
    char what[160];
    outcome own = {0};
    uint32_t most_colours = 0;
    duet_cluster_motion_result result = {0};
    for (uint32_t i = 0; i < s->steps; ++i) {
        if (i > 0 && i == s->saved_at)
            save_and_resume(cluster, s);
        result = advance(cluster, 1);
        most_colours = result.colours > most_colours ? result.colours : most_colours;
        add_told(&own, i, &result);
    }
    own.hash = state_hash(cluster);
    snprintf(what, sizeof what, "%s on %d ranks of %u, after %u colours", s->name, n_ranks, parts,
             colours);
    MUST(result.step == s->steps, what);
    MUST(result.contacts >= s->least_contacts, what);
    MUST(s->colours == 0 || most_colours == s->colours, what);
    MUST(s->least_contacts == 0 || n_ranks * parts == 1 || result.ghosts > 0, what);
    MUST(own.hash == expected->hash, what);
    must_tell_alike(own, expected, cluster, what);
    duet_cluster_destroy(cluster);
}

static void must_tell_much(const outcome *o, const told *more_than, const char *name)
{
    if (more_than->events > 0)
        MUST(o->events > more_than->events && o->stays > more_than->stays, name);
    if (more_than->events > 0)
        MUST(more_than->hits > 0 ? o->hits > more_than->hits : o->hits == 0, name);
}

FACT(scenes_have_one_motions_bits)
{
    static const uint32_t colours[] = {1, 31, 4}; // after which ghosts come
    for (size_t i = 0; i < sizeof rows / sizeof *rows; ++i) {
        const outcome expected = expected_outcome(&rows[i].scene);
        for (int k = 0; rows[i].shapes[k][0] > 0; ++k)
            must_move_to(&rows[i].scene, &expected, rows[i].shapes[k][0],
                         (uint32_t)rows[i].shapes[k][1], colours[k % 3]);
        must_tell_much(&expected, &rows[i].more_than, rows[i].scene.name);
    }
}

JOB_MAIN(8, 20261128, "all facts hold on 1, 2, 3, 4, 5 and 8 ranks")
