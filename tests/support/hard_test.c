// SPDX-License-Identifier: MIT
#include "support/hard_test.h"

#include "support/devices.h"
#include "support/hard_pairs.h"
#include "support/promise.h"
#include "support/test.h"

#include "runtime/narrowphase/level.h"
#include "runtime/narrowphase/narrow.h"

typedef struct crowd {
    uint32_t dims;
    uint64_t n;
    int each;             // pairs of a class
    duet_pose *poses;     // [2 n]
    duet_pose *exchanged; // second pose first
    duet_pose *negated;   // -q for q
    bool *truth;          // [n]
    uint8_t *answers;     // answers of B alone
    uint8_t *others;
} crowd;

static void *block_for(uint64_t n, size_t size)
{
    void *block = calloc(n, size);
    assert_non_null(block);
    return block;
}

static duet_pose with_minus_q(duet_pose pose)
{
    for (int i = 0; i < 4; ++i)
        pose.rotation[i] = -pose.rotation[i];
    return pose;
}

static void add_pair(crowd *c, uint64_t i, const hard_pair *pair)
{
    c->poses[2 * i] = c->exchanged[2 * i + 1] = pair->a;
    c->poses[2 * i + 1] = c->exchanged[2 * i] = pair->b;
    c->negated[2 * i] = with_minus_q(pair->a);
    c->negated[2 * i + 1] = pair->b;
    c->truth[i] = narrow_exact(&pair->a, &pair->b, c->dims);
}

static void gather(crowd *c)
{
    uint64_t n_classes = 0;
    while (hard_classes[n_classes].name)
        ++n_classes;
    c->n = n_classes * (uint64_t)c->each;
    c->poses = block_for(2 * c->n, sizeof *c->poses);
    c->exchanged = block_for(2 * c->n, sizeof *c->poses);
    c->negated = block_for(2 * c->n, sizeof *c->poses);
    c->truth = block_for(c->n, sizeof *c->truth);
    c->answers = block_for(c->n, sizeof *c->answers);
    c->others = block_for(c->n, sizeof *c->others);
    rng r = rng_seed(test_seed() + c->dims);
    for (uint64_t i = 0; i < c->n; ++i) {
        hard_pair pair = hard_classes[i / (uint64_t)c->each].make(&r, c->dims);
        add_pair(c, i, &pair);
    }
}

static void let_go(crowd *c)
{
    void *const blocks[] = {c->poses, c->exchanged, c->negated, c->truth, c->answers, c->others};
    for (size_t i = 0; i < sizeof blocks / sizeof *blocks; ++i)
        free(blocks[i]);
}

// ------------------------------------------------------------ asking

void hard_test_answers(duet_level level, uint32_t dims, uint32_t share, const duet_pose *poses,
                       uint64_t n, uint8_t *answers, duet_pair_query_result *result)
{
    duet_pair_query_result ignored;
    duet_pair_query_def def = duet_default_pair_query_def();
    def.pair = default_pair();
    def.share = share;
    def.level = level;
    def.dims = dims;
    duet_pair_query *test = must(duet_pair_query_create(&def, ERR));
    must(duet_pair_query_run(test, poses, n, answers, NULL, result ? result : &ignored, ERR));
    duet_pair_query_destroy(test);
}

// ------------------------------------------------------------ judging

static void fail_at(const crowd *c, duet_level level, uint64_t i, const char *what)
{
    hard_pair pair = {c->poses[2 * i], c->poses[2 * i + 1]};
    hard_pair_print(&pair, c->dims);
    fail_msg("level %s, '%s': answer %d %s", duet_level_get_info(level)->name,
             hard_classes[i / (uint64_t)c->each].name, c->answers[i], what);
}

static bool comes_first(const duet_pose *a, const duet_pose *b, uint32_t dims)
{
    for (uint32_t k = 0; k < dims; ++k)
        if (a->centre[k] != b->centre[k])
            return a->centre[k] < b->centre[k];
    return true;
}

static bool specified(duet_level level, const hard_pair *p, uint32_t dims)
{
    return comes_first(&p->a, &p->b, dims)
               ? level_collide(level, &p->a, &p->b, narrow_here, dims, true)
               : level_collide(level, &p->b, &p->a, narrow_here, dims, true);
}

static void judge(const crowd *c, duet_level level)
{
    const duet_level_info *info = duet_level_get_info(level);
    for (uint64_t i = 0; i < c->n; ++i) {
        hard_pair pair = {c->poses[2 * i], c->poses[2 * i + 1]};
        bool answer = c->answers[i];
        if (answer != c->truth[i] &&
            !promise_allows(info->missed, info->added, &pair, c->dims, answer))
            fail_at(c, level, i, "breaks the level's promise");
        if (answer != specified(level, &pair, c->dims))
            fail_at(c, level, i, "is not what the specification says");
    }
}

static void compare(crowd *c, duet_level level, uint32_t share, const duet_pose *poses,
                    const char *how)
{
    hard_test_answers(level, c->dims, share, poses, c->n, c->others, NULL);
    for (uint64_t i = 0; i < c->n; ++i)
        if (c->others[i] != c->answers[i])
            fail_at(c, level, i, how);
}

void hard_test_run(uint32_t dims, int each)
{
    crowd c = {.dims = dims, .each = each};
    gather(&c);
    for (int l = 0; l < DUET_LEVELS; ++l) {
        duet_level level = (duet_level)l;
        hard_test_answers(level, dims, 0, c.poses, c.n, c.answers, NULL);
        judge(&c, level);
        compare(&c, level, DUET_SHARE_ONE, c.poses, "is another on A");
        compare(&c, level, DUET_SHARE_ONE / 3, c.exchanged, "is another with the poses exchanged");
        compare(&c, level, 2 * (DUET_SHARE_ONE / 3), c.negated, "is another for -q");
    }
    print_message("%" PRIu64 " pairs in %uD\n", c.n, dims);
    let_go(&c);
}
