// SPDX-License-Identifier: MIT
// Each place of a saved motion: its body, and the state that commands left.
#include "runtime/commands/saved_motion.h"

#include "base/error.h"
#include "runtime/dynamics/motion_rows.h"
#include "runtime/dynamics/motion_state.h"
#include "runtime/dynamics/motion_targets.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct saved_place {
    uint64_t user_data;
    duet_pose pose;
    packed_body body;
    uint32_t generation, state;
    int32_t cell[3];
} saved_place;

static_assert(sizeof(saved_place) == 136 && sizeof(motion_target) == 32,
              "no byte of a file is left to chance");

enum { FORCE_WORDS = 8 };

// ---------------------------------------------------------------- saving

static saved_place place_of(const duet_motion *m, uint32_t place)
{
    const motion_commands *c = m->commands;
    saved_place s = {.user_data = c ? c->user_data[place] : 0,
                     .pose = m->poses[place],
                     .body = packed_body_of(&m->bodies[place]),
                     .generation = c ? c->generations[place] : 0,
                     .state = c ? c->states[place] : PLACE_ENABLED};
    if (m->cells)
        memcpy(s.cell, m->cells[place].s, sizeof s.cell);
    return s;
}

static bool add_forces(duet_motion *m, text *file, duet_error *err)
{
    motion_rows rows;
    if (!motion_rows_open(m, FORCES, 0, m->n, &rows, err))
        return false;
    text_add_bytes(file, rows.bytes, rows.size);
    motion_rows_drop(&rows);
    return true;
}

bool saved_places_add(duet_motion *m, text *file, duet_error *err)
{
    const motion_commands *c = m->commands;
    for (uint32_t place = 0; place < m->n; ++place) {
        saved_place s = place_of(m, place);
        text_add_bytes(file, (const char *)&s, sizeof s);
    }
    if (c && c->n_targets > 0)
        text_add_bytes(file, (const char *)c->targets, c->n_targets * sizeof *c->targets);
    return !c || c->n_pushed == 0 || add_forces(m, file, err);
}

// ---------------------------------------------------------------- reading

size_t saved_places_size(const saved_head *h)
{
    return h->n * sizeof(saved_place) + h->n_targets * sizeof(motion_target) +
           (h->pushed ? (size_t)h->n * FORCE_WORDS * sizeof(float) : 0);
}

static bool bad_place(const char *path, uint32_t place, const char *what, duet_error *err)
{
    return bad_input(err, "%s: the saved motion's place %u: %s", path, place, what);
}

static bool take_head(duet_motion *copy, const saved_head *h, const char *path, duet_error *err)
{
    duet_error why = {0};
    duet_motion_def *d = &copy->def;
    bool pulled = d->attraction != 0.0;
    packed_to_def(&h->def, d);
    if (!motion_check_def(d, &why))
        return bad_input(err, "%s: the saved motion: %s", path, why.text);
    if (pulled != (d->attraction != 0.0))
        return bad_input(err,
                         "%s: the saved motion's attraction is %g; expected none or both of the "
                         "file's and the motion's to be 0",
                         path, d->attraction);
    if (h->rows_stale > 1 || h->pushed > 1 || (h->pushed && !(copy->effects & DUET_EFFECT_FORCES)))
        return bad_input(err, "%s: the saved motion's head has no such word", path);
    return true;
}

static const char *place_fault(const duet_motion *copy, const saved_place *s)
{
    uint32_t place_is_empty = s->state == PLACE_EMPTY || s->state == PLACE_LEFT;
    if (s->state >= PLACE_STATES || s->body.flags > PACKED_FLAGS)
        return "there is no such word for its body";
    if (place_is_empty && s->body.mass != 0.0f)
        return "it is empty and has a mass";
    for (uint32_t k = 0; copy->cells && k < copy->def.dims; ++k)
        if (abs(s->cell[k] / 2) > 1 << 29)
            return "it is beyond 2^30 origin cells";
    return NULL;
}

static bool take_place(duet_motion *copy, uint32_t place, const saved_place *s, const char *path,
                       duet_error *err)
{
    duet_body *b = &copy->bodies[place];
    *b = packed_to_body(&s->body);
    copy->poses[place] = s->pose;
    if (copy->cells)
        memcpy(copy->cells[place].s, s->cell, sizeof s->cell);
    motion_commands *c = copy->commands;
    c->generations[place] = s->generation;
    c->states[place] = (uint8_t)s->state;
    c->user_data[place] = s->user_data;
    c->n_hidden += s->state != PLACE_ENABLED;
    c->n_left += s->state == PLACE_LEFT;
    if (s->state == PLACE_EMPTY && place < c->first_empty)
        c->first_empty = place;
    const char *fault = place_fault(copy, s);
    fault = fault ? fault : motion_pose_fault(&s->pose, copy->def.dims);
    fault = fault ? fault : motion_body_fault(&copy->def, b);
    return !fault || bad_place(path, place, fault, err);
}

// A target is put where it is without another look.
static bool is_in_cells(const duet_motion *copy, const motion_target *t)
{
    cl_int4 cell;
    duet_pose aimed = motion_aim(copy, copy->poses[t->place], &t->pose);
    return !copy->cells || motion_place_pose(copy, &aimed, &cell);
}

static bool take_target(const duet_motion *copy, const motion_target *t, const char *path,
                        duet_error *err)
{
    duet_pose pose = {.half_extents = {0}};
    memcpy(pose.centre, t->pose.centre, sizeof pose.centre);
    memcpy(pose.rotation, t->pose.rotation, sizeof pose.rotation);
    bool ok = t->place < copy->n && !motion_is_hidden(copy, t->place) &&
              !(copy->bodies[t->place].mass > 0.0f) && !motion_pose_fault(&pose, copy->def.dims) &&
              is_in_cells(copy, t);
    return ok || bad_place(path, t->place, "no such body can have a target", err);
}

// Refuses objects that call for an effect that the motion lacks; the motion's kernels may still
// have to learn that bodies tumble.
static bool take_facts(duet_motion *copy, const char *path, duet_error *err)
{
    const effect_facts before = copy->facts;
    copy->facts = 0;
    effect_facts_add(&copy->facts, &copy->def, copy->poses, copy->bodies, copy->n);
    copy->facts = effect_facts_as_fast(copy->facts, before);
    if (effect_infer(&copy->def, copy->facts) & ~copy->effects)
        return bad_input(err, "%s: the saved motion's bodies need effects that the motion lacks",
                         path);
    bool tumbles = copy->facts & ~before & FACT_UNEVEN;
    copy->facts |= before & FACT_UNEVEN;
    return !tumbles || !(copy->effects & DUET_EFFECT_ANGULAR_VELOCITY) ||
           motion_prepare_again(copy, err);
}

static bool put_forces(duet_motion *copy, const char *bytes, const char *path, duet_error *err)
{
    size_t n = (size_t)copy->n * FORCE_WORDS;
    motion_rows rows;
    if (!motion_rows_open(copy, FORCES, 0, copy->n, &rows, err))
        return false;
    memcpy(rows.bytes, bytes, n * sizeof(float));
    bool ok = true;
    for (size_t i = 0; ok && i < n; ++i)
        ok = isfinite(((const float *)(void *)rows.bytes)[i]) ||
             bad_place(path, (uint32_t)(i / FORCE_WORDS), "a force is not finite", err);
    return motion_rows_close(copy, &rows, err) && ok;
}

static bool reserve_places(duet_motion *copy, duet_error *err)
{
    size_t n = (size_t)copy->n + 1;
    copy->poses = calloc(n, sizeof *copy->poses);
    copy->bodies = calloc(n, sizeof *copy->bodies);
    copy->cells = copy->def.origin_edge > 0.0f ? calloc(n, sizeof *copy->cells) : NULL;
    if (copy->poses && copy->bodies && (copy->cells || copy->def.origin_edge == 0.0f))
        return motion_begin_commands(copy, err);
    return no_memory(err, "%u objects", copy->n);
}

static bool take_places(duet_motion *copy, const char **at, const char *path, duet_error *err)
{
    bool ok = true;
    for (uint32_t place = 0; ok && place < copy->n; ++place) {
        saved_place s;
        memcpy(&s, *at, sizeof s);
        *at += sizeof s;
        ok = take_place(copy, place, &s, path, err);
    }
    return ok;
}

static bool take_targets(duet_motion *copy, uint32_t n, const char **at, const char *path,
                         duet_error *err)
{
    motion_commands *c = copy->commands;
    c->targets = malloc((size_t)n * sizeof *c->targets + 1);
    if (!c->targets)
        return no_memory(err, "%u targets of %s", n, path);
    memcpy(c->targets, *at, n * sizeof *c->targets);
    *at += n * sizeof *c->targets;
    c->n_targets = n;
    bool ok = true;
    for (uint32_t i = 0; ok && i < n; ++i)
        ok = take_target(copy, &c->targets[i], path, err);
    return ok;
}

bool saved_places_take(duet_motion *copy, const saved_head *h, const char *bytes, const char *path,
                       duet_error *err)
{
    saved_ground_seen seen;
    bool ok = saved_ground_see(copy, &seen, h, bytes + saved_places_size(h), path, err) &&
              reserve_places(copy, err) && take_head(copy, h, path, err) &&
              saved_ground_take(copy, h, err) && take_places(copy, &bytes, path, err) &&
              take_targets(copy, h->n_targets, &bytes, path, err) && take_facts(copy, path, err) &&
              motion_reset(copy, err) && (!h->pushed || put_forces(copy, bytes, path, err));
    if (ok)
        copy->commands->n_pushed = h->pushed;
    return ok;
}

// ---------------------------------------------------------------- a copy

duet_motion saved_copy_begin(const duet_motion *m, uint32_t n)
{
    duet_motion copy = *m;
    copy.n = n;
    copy.poses = NULL;
    copy.bodies = NULL;
    copy.cells = NULL;
    copy.commands = NULL;
    memset(copy.buffers, 0, sizeof copy.buffers);
    copy.ground = (motion_ground){0};
    return copy;
}

void saved_copy_free(duet_motion *copy)
{
    for (int which = 0; which < MOTION_BUFFERS; ++which)
        buffer_release(&copy->buffers[which]);
    free(copy->poses);
    free(copy->bodies);
    free(copy->cells);
    motion_forget_commands(copy->commands);
    ground_close(&copy->ground);
}

void saved_copy_adopt(duet_motion *m, duet_motion *copy)
{
    duet_motion before = *m;
    for (int which = 0; which < MOTION_BUFFERS; ++which)
        if (!copy->buffers[which].mem)
            buffer_swap(&copy->buffers[which], &before.buffers[which]);
    if (!ground_is_there(&copy->ground)) { // the file has none
        copy->ground = before.ground;
        before.ground = (motion_ground){0};
    }
    *m = *copy;
    ground_show(&m->ground, &m->def);
    saved_copy_free(&before);
}
