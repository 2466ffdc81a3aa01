// SPDX-License-Identifier: MIT
// Files that any number of ranks, and one motion, save and go on from.
#include "cluster/motion/moving.h"

#include "base/text.h"
#include "base/text_file.h"

// Takes steps on so many ranks, from a file or from the beginning, and saves it.
static uint64_t go_on(const moving_scene *s, int n_ranks, uint32_t parts, const char *from,
                      const char *to)
{
    uint64_t hash = 0;
    duet_cluster *c = begin_from(n_ranks, parts, 0, s, from);
    if (c) {
        advance(c, from ? s->steps - s->saved_at : s->saved_at);
        hash = state_hash(c);
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
FACT(checkpoints_know_no_ranks)
{
    const char *three = "cluster_motion_3.ck", *one = "cluster_motion_1.ck";
    const moving_scene s = {"falling", {{"n", "90"}}, 70, .saved_at = 40};
    uint64_t expected = expected_hash(&s);
    go_on(&s, 3, 1, NULL, three);
    go_on(&s, 1, 4, NULL, one);
    if (rank == 0)
        must_be_the_same_bytes(three, one);
    MUST(go_on(&s, 5, 1, three, NULL) == expected, "5 ranks go on from what 3 saved");
    MUST(go_on(&s, 1, 1, three, NULL) == expected, "1 rank goes on from what 3 saved");
    job_remove(three);
    job_remove(one);
}

// Saved on n ranks of so many parts, gone on with by one motion.
static void must_go_on_alone(const moving_scene *s, uint64_t expected, int n, uint32_t parts)
{
    static const char file[] = "cluster_motion_alone.ck";
    duet_cluster *c = begin_on(n, parts, 1, s);
    if (c) {
        advance(c, s->saved_at);
        must(duet_cluster_save_motion(c, file, ERR));
    }
    duet_cluster_destroy(c);
    if (rank == 0)
        MUST(one_motions_hash(s, file) == expected, "one motion goes on from what ranks saved");
    job_remove(file);
}

// Bodies that did not touch when they were saved do later, within a skin and without one, and all
// of a pile falls asleep.
FACT(one_motion_goes_on_from_what_ranks_saved)
{
    static const int shapes[][2] = {{1, 1}, {2, 1}, {3, 1}, {1, 2}};
    const moving_scene scenes[] = {{"falling", {{"n", "90"}}, 40, .saved_at = 15},
                                   {"falling", {{"n", "30"}}, 150, .saved_at = 110},
                                   {"bare.lua", .steps = 24, .saved_at = 8}};
    for (size_t i = 0; i < sizeof scenes / sizeof *scenes; ++i) {
        const uint64_t expected = expected_hash(&scenes[i]);
        for (size_t k = 0; k < sizeof shapes / sizeof *shapes; ++k)
            must_go_on_alone(&scenes[i], expected, shapes[k][0], (uint32_t)shapes[k][1]);
    }
}

// Nothing moves then.
FACT(what_is_not_there_is_refused)
{
    static const char path[] = "no_such_scene.lua";
    duet_cluster_motion_result result;
    duet_cluster *c = cluster_of(2, duet_default_cluster_def());
    if (!c)
        return;
    must_fail(duet_cluster_begin_motion(c, path, NULL, 0, NULL, ERR), DUET_STATUS_NOT_FOUND, path);
    must_fail(duet_cluster_advance(c, &result, ERR), DUET_STATUS_BAD_ARGUMENT,
              "expected duet_cluster_begin_motion first");
    duet_cluster_destroy(c);
}
