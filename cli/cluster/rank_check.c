// SPDX-License-Identifier: MIT
#include "cli/cluster/rank_check.h"

#include "base/error.h"
#include "cli/difference.h"
#include "runtime/commands/recording.h"
#include "runtime/commands/replay.h"

// A motion that went on from a file was given the commands of its steps.
static bool open_replay(rank_check *c, const char *path, duet_error *err)
{
    const replay_begin begin = {.dims = duet_motion_get_def(c->one)->dims,
                                .step = duet_motion_get_step(c->one),
                                .ground = recorded_ground_sum(c->one)};
    c->replay = duet_replay_create(path, err);
    return c->replay && (begin.step == 0 || replay_pass(c->replay, &begin, err));
}

static bool begin_one(rank_check *c, const moving_start *start, const char *replay, duet_error *err)
{
    duet_scene *scene = duet_scene_load(start->path, start->settings, start->n_settings, err);
    if (!scene)
        return false;
    const duet_motion_def def = duet_scene_motion_def(scene, start->pair);
    c->one = duet_motion_create_from_scene(&def, scene, NULL, err);
    duet_scene_destroy(scene);
    if (!c->one || (start->resume && !duet_motion_load(c->one, start->resume, err)))
        return false;
    return !replay || open_replay(c, replay, err);
}

bool rank_check_begin(rank_check *c, ranks *r, moving *motion, const moving_start *start,
                      const char *replay, duet_error *err)
{
    *c = (rank_check){.ranks = r, .motion = motion};
    return ranks_agree(r, r->self > 0 || begin_one(c, start, replay, err), err);
}

// ---------------------------------------------------------------- what differs

static bool find(const verified_run runs[2], bool is_start, difference *d, duet_error *err)
{
    return is_start ? difference_find_state(d, runs, "start", err) : difference_find(d, runs, err);
}

static bool tell(const rank_check *c, const difference *d, duet_error *err)
{
    text told = {0};
    difference_tell(d, &told);
    error_set(err, DUET_STATUS_WRONG_RESULT, "different: %s: one motion and %d ranks",
              text_chars(&told), c->ranks->n);
    text_free(&told);
    return false;
}

// Rank 0 looks at all bodies.
static bool name_difference(const rank_check *c, bool is_start, duet_error *own)
{
    duet_motion *whole;
    bool ok = moving_gather(c->motion, &whole, own);
    if (ok && is_well(own) && whole) {
        difference d = {.step = is_start ? 0 : moving_get_counts(c->motion).step};
        const verified_run runs[2] = {{.motion = c->one}, {.motion = whole}};
        if (find(runs, is_start, &d, own))
            tell(c, &d, own);
    }
    duet_motion_destroy(whole);
    return ok && ranks_agree(c->ranks, is_well(own), own);
}

static bool advance(const rank_check *c, duet_error *own)
{
    duet_motion_result last;
    return c->replay ? duet_replay_advance(c->replay, c->one, &last, own)
                     : duet_motion_advance(c->one, &last, own);
}

// Moves the one motion as far as the other.
static bool follow(const rank_check *c, uint64_t *hash, duet_error *own)
{
    if (duet_motion_get_step(c->one) < moving_get_counts(c->motion).step && !advance(c, own))
        return false;
    return duet_motion_get_hash(c->one, hash, own);
}

static bool compare(const rank_check *c, duet_error *own)
{
    uint64_t hash = 0, differs = 0, other = 0;
    const uint64_t step = c->one ? duet_motion_get_step(c->one) : 0;
    if (!moving_hash(c->motion, &hash, own))
        return false;
    if (c->one && follow(c, &other, own))
        differs = hash != other;
    if (!ranks_agree(c->ranks, is_well(own), own))
        return false;
    ranks_sum(c->ranks, &differs, 1);
    const bool is_start = c->one && step == moving_get_counts(c->motion).step;
    return differs == 0 || name_difference(c, is_start, own);
}

bool rank_check_compare(rank_check *c, duet_error *err)
{
    duet_error own = {0};
    return !c->motion || compare(c, &own) || error_copy(err, &own);
}

void rank_check_end(rank_check *c)
{
    duet_motion_destroy(c->one);
    duet_replay_destroy(c->replay);
}
