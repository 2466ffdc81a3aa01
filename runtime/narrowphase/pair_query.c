// SPDX-License-Identifier: MIT
// The narrow phase alone: answers of pairs that the caller brings.
//
// Each device takes its pairs a chunk at a time, so that any number fits, and what
// float leaves open of a chunk is decided before the next one.
#include "base/budget.h"
#include "base/clock.h"
#include "base/error.h"
#include "runtime/narrowphase/narrow.h"
#include "runtime/opencl/shared_work.h"

#include <stdlib.h>

enum { COOKIE = 0x0d0e7007 };

// Some 20 MB of poses: launches cost nothing beside it, and few devices lack it.
enum { CHUNK = 1 << 18 };

// Answers of a device for a pair besides 0 and 1, as in kernels/narrowphase/pair_query.cl.
enum { UNDECIDED = 2, NO_BOX = 3 };

// One device, and what it does of a call.
typedef struct side {
    work_side work;
    kernel *kernel;
    buffer poses;
    buffer found;
    cl_uint n; // the pairs launched last
    uint32_t dims;

    const duet_pose *all_poses; // the caller's poses
    uint8_t *answers;
    double *separations;
    uint64_t colliding, undecided;
} side;

static const binding side_bindings[] = {BIND_BUFFER(side, "poses", "float *", poses),
                                        BIND_BUFFER(side, "answers", "uchar *", found),
                                        BIND_VALUE(side, "n", n),
                                        {0}};

struct duet_pair_query {
    shared_work work;
    side sides[2]; // A, B
};

duet_pair_query_def duet_default_pair_query_def(void)
{
    return (duet_pair_query_def){.dims = 3, .cookie = COOKIE};
}

// ---------------------------------------------------------------- owner

static bool check_def(const duet_pair_query_def *def, duet_error *err)
{
    if (!error_def(def && def->cookie == COOKIE, "query", "duet_default_pair_query_def", err) ||
        !error_def_pair(def->pair, "query", err) || !error_def_dims(def->dims, err))
        return false;
    if (!duet_level_get_info(def->level))
        return bad_argument(err, "level is %d; expected a duet_level", (int)def->level);
    return shared_work_check(def->share, err);
}

static bool open_side(side *s, const duet_pair_query_def *def, duet_error *err)
{
    const gen_setting settings[] = {{"DIMS", def->dims}, {"ACCURACY", def->level}};
    work_side *w = &s->work;
    s->dims = def->dims;
    if (!w->device)
        return true;
    s->kernel = program_set_kernel(w->programs, "pair_query", "pair_query", settings, 2,
                                   side_bindings, err);
    return s->kernel && program_set_build(w->programs, err) &&
           buffer_reserve(&s->found, w->device, CHUNK, err);
}

duet_pair_query *duet_pair_query_create(const duet_pair_query_def *def, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!check_def(def, err))
        return NULL;
    duet_pair_query *query = calloc(1, sizeof *query);
    if (!query)
        return null_no_memory(err, "a pair query");
    side *a = &query->sides[0], *b = &query->sides[1];
    if (!shared_work_open(&query->work, def->pair, def->pair->kernel_dir, def->share, &a->work,
                          &b->work, err) ||
        !open_side(a, def, err) || !open_side(b, def, err)) {
        duet_pair_query_destroy(query);
        return NULL;
    }
    return query;
}

void duet_pair_query_destroy(duet_pair_query *query)
{
    if (!query)
        return;
    for (int which = 0; which < 2; ++which) {
        buffer_release(&query->sides[which].poses);
        buffer_release(&query->sides[which].found);
    }
    shared_work_close(&query->work);
    free(query);
}

// ---------------------------------------------------------------- a chunk

static bool send_poses(side *s, const duet_pose *poses, size_t bytes)
{
    return buffer_hold(&s->poses, s->work.device, (void *)poses, bytes, &s->work.err) &&
           timeline_write(&s->work.times, "send poses", &s->poses, poses, bytes, &s->work.err);
}

static bool ask_device(side *s, uint64_t first, uint32_t n)
{
    size_t bytes = 2 * (size_t)n * sizeof(duet_pose);
    s->n = n;
    return send_poses(s, s->all_poses + 2 * first, bytes) &&
           timeline_launch(&s->work.times, "test", s->kernel, n, s, &s->work.err) &&
           timeline_read(&s->work.times, "fetch answers", &s->found, s->answers + first, n,
                         &s->work.err);
}

static bool refuse(side *s, uint64_t pair)
{
    bool first_is_box = narrow_is_box(&s->all_poses[2 * pair], s->dims);
    return error_set(&s->work.err, DUET_STATUS_BAD_OBJECT,
                     "pair %llu: the %s pose is not a number, infinite, negative or without "
                     "rotation",
                     (unsigned long long)pair, first_is_box ? "second" : "first");
}

// The device's word is the last one but where float is undecided.
static bool decide(side *s, uint64_t pair)
{
    const duet_pose *poses = s->all_poses + 2 * pair;
    uint8_t *answer = &s->answers[pair];
    if (*answer == NO_BOX)
        return refuse(s, pair);
    if (*answer == UNDECIDED) {
        *answer = narrow_decide(&poses[0], &poses[1], s->dims);
        ++s->undecided;
    }
    s->colliding += *answer;
    return true;
}

static bool test_chunk(side *s, uint64_t first, uint32_t n)
{
    if (!ask_device(s, first, n))
        return false;
    for (uint64_t pair = first; pair < first + n; ++pair)
        if (!decide(s, pair))
            return false;
    for (uint64_t pair = first; s->separations && pair < first + n; ++pair)
        s->separations[pair] =
            duet_poses_separation(&s->all_poses[2 * pair], &s->all_poses[2 * pair + 1], s->dims);
    return true;
}

// ---------------------------------------------------------------- all pairs

static bool test_part(work_side *w)
{
    side *s = (side *)w;
    bool ok = true;
    for (uint64_t first = w->first; ok && first < w->last; first += CHUNK) {
        uint64_t left = w->last - first;
        ok = budget_check(&w->err) && test_chunk(s, first, left < CHUNK ? (uint32_t)left : CHUNK);
    }
    return ok;
}

bool duet_pair_query_run(duet_pair_query *query, const duet_pose *poses, uint64_t n,
                         uint8_t *answers, double *separations, duet_pair_query_result *result,
                         duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_given(query, __func__, "query", err) ||
        !error_given(result, __func__, "result", err))
        return false;
    uint64_t begun = clock_steady_ns();
    if (n > 0 && (!poses || !answers))
        return bad_argument(err, "%llu pairs, but no memory for their %s", (unsigned long long)n,
                            poses ? "answers" : "poses");
    side *a = &query->sides[0], *b = &query->sides[1];
    for (int which = 0; which < 2; ++which) {
        side *s = &query->sides[which];
        s->all_poses = poses;
        s->answers = answers;
        s->separations = separations;
        s->colliding = s->undecided = 0;
    }
    bool ok = shared_work_run(&query->work, n, test_part, err);
    for (int which = 0; which < 2; ++which)
        if (query->sides[which].poses.borrowed) // the caller may free it
            buffer_release(&query->sides[which].poses);
    if (!ok)
        return false;
    *result = (duet_pair_query_result){.colliding = a->colliding + b->colliding,
                                       .undecided = a->undecided + b->undecided,
                                       .total_ms = clock_ms_since(begun),
                                       .device_ms = {a->work.wall_ms, b->work.wall_ms}};
    return true;
}
