// SPDX-License-Identifier: MIT
#include "cli/cluster/rank_replay.h"

#include "cli/inputs.h"
#include "cluster/moving.h"
#include "runtime/commands/commands.h"
#include "runtime/commands/recording.h"

// ---------------------------------------------------------------- the file

static bool read_file(rank_replay *r, uint64_t steps, duet_error *own)
{
    r->file = duet_replay_create(r->path, own);
    r->n = duet_replay_get_info(r->file).commands;
    return r->file && inputs_check_recorded(r->file, r->path, steps, own);
}

// A motion that goes on from a file has steps, whose commands it was given.
static bool check_begin(rank_replay *r, uint64_t hash, duet_error *own)
{
    const moving_counts counts = moving_get_counts(r->cluster->moving);
    const replay_begin begin = {.n = (uint32_t)counts.bodies,
                                .dims = duet_cluster_get_motion_def(r->cluster)->dims,
                                .step = counts.step,
                                .hash = hash,
                                .ground =
                                    recorded_ground_sum(moving_get_motion(r->cluster->moving, 0))};
    if (counts.step > 0 ? !replay_pass(r->file, &begin, own)
                        : !replay_check_begin(r->file, &begin, own))
        return false;
    r->n_given = replay_get_place(r->file).commands_done;
    r->steps_left = duet_replay_get_info(r->file).steps - counts.step;
    return true;
}

bool rank_replay_begin(rank_replay *r, duet_cluster *cluster, const char *path, uint64_t steps,
                       duet_error *err)
{
    ranks *all = &cluster->ranks;
    uint64_t hash;
    *r = (rank_replay){.cluster = cluster, .path = path};
    if (!path)
        return true;
    if (!ranks_agree(all, all->self > 0 || read_file(r, steps, err), err) ||
        !duet_cluster_get_state_hash(cluster, &hash, err))
        return false;
    if (!ranks_agree(all, all->self > 0 || check_begin(r, hash, err), err))
        return false;
    ranks_broadcast(all, &r->n, sizeof r->n);
    ranks_broadcast(all, &r->n_given, sizeof r->n_given);
    ranks_broadcast(all, &r->steps_left, sizeof r->steps_left);
    return true;
}

void rank_replay_end(rank_replay *r)
{
    duet_replay_destroy(r->file);
}

// ---------------------------------------------------------------- commands

// The others know which command it is, and no more.
static bool share(const rank_replay *r, replayed *next, duet_error *err)
{
    ranks *all = &r->cluster->ranks;
    const duet_motion_def *def = duet_cluster_get_motion_def(r->cluster);
    *next = (replayed){0};
    if (!ranks_agree(all, all->self > 0 || replay_take(r->file, def, next, err), err))
        return false;
    uint32_t number = next->c.op ? next->c.op->number : 0;
    ranks_broadcast(all, &number, sizeof number);
    if (number > 0)
        next->c.op = command_op_at(number);
    return true;
}

static bool give(rank_replay *r, command *c, duet_error *err)
{
    duet_error why = {0};
    ++r->n_given;
    return cluster_give(r->cluster, c, &why) || replay_blame(r->path, r->n_given, r->n, &why, err);
}

bool rank_replay_before(rank_replay *r, duet_error *err)
{
    bool ok = true, given = r->path;
    while (ok && given) {
        replayed next;
        ok = share(r, &next, err);
        given = ok && next.c.op;
        ok = ok && (!given || give(r, &next.c, err));
        replayed_free(&next);
    }
    return ok;
}

// ---------------------------------------------------------------- steps

// Compares the state that a step left with the recorded one, if that was kept.
static bool compare_kept(const rank_replay *r, duet_error *err)
{
    ranks *all = &r->cluster->ranks;
    uint64_t hash = 0, kept = r->file && replay_has_hash(r->file);
    ranks_broadcast(all, &kept, sizeof kept);
    return !kept || (duet_cluster_get_state_hash(r->cluster, &hash, err) &&
                     ranks_agree(all, all->self > 0 || replay_check_hash(r->file, hash, err), err));
}

bool rank_replay_after(rank_replay *r, duet_error *err)
{
    if (!r->path)
        return true;
    if (r->file)
        replay_note_step(r->file);
    return compare_kept(r, err) && (--r->steps_left > 0 || rank_replay_before(r, err));
}

bool rank_replay_compare(rank_replay *r, duet_error *err)
{
    ranks *all = &r->cluster->ranks;
    uint64_t hash;
    return !r->path || r->steps_left > 0 ||
           (duet_cluster_get_state_hash(r->cluster, &hash, err) &&
            ranks_agree(all, all->self > 0 || replay_check_end(r->file, hash, err), err));
}
