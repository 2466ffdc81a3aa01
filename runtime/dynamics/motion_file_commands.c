// SPDX-License-Identifier: MIT
#include "runtime/dynamics/motion_file_commands.h"

#include "base/error.h"
#include "runtime/dynamics/motion_rows.h"
#include "runtime/dynamics/recording.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct saved_head {
    recorded_def def;
    uint32_t rows_stale;
    uint32_t n_targets;
    uint32_t pushed;
    uint32_t unused;
} saved_head;

typedef struct saved_place {
    duet_pose pose;
    recorded_body body;
    uint32_t generation, state;
    uint64_t user_data;
    int32_t cell[3];
    float radius; // 0 in files from before there were radii
} saved_place;

static_assert(sizeof(saved_head) == 160 && sizeof(saved_place) == 120 &&
                  sizeof(motion_target) == 32,
              "no byte of a file is left to chance");

enum { FORCE_WORDS = 8 };

// ---------------------------------------------------------------- saving

static saved_place place_of(const duet_motion *m, uint32_t place)
{
    const motion_commands *c = m->commands;
    saved_place s = {.pose = m->poses[place],
                     .body = recorded_body_of(&m->bodies[place]),
                     .generation = c->generations[place],
                     .state = c->states[place],
                     .user_data = c->user_data[place],
                     .radius = m->bodies[place].radius};
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

bool motion_add_commands(duet_motion *m, text *file, duet_error *err)
{
    const motion_commands *c = m->commands;
    const saved_head h = {.def = recorded_def_of(&m->def),
                          .rows_stale = motion_rows_are_stale(m),
                          .n_targets = c->n_targets,
                          .pushed = c->pushed};
    text_add_bytes(file, (const char *)&h, sizeof h);
    for (uint32_t place = 0; place < m->n; ++place) {
        saved_place s = place_of(m, place);
        text_add_bytes(file, (const char *)&s, sizeof s);
    }
    text_add_bytes(file, (const char *)c->targets, c->n_targets * sizeof *c->targets);
    return !c->pushed || add_forces(m, file, err);
}

// ---------------------------------------------------------------- reading

size_t motion_commands_size(const char *bytes, size_t length, uint32_t n)
{
    saved_head h;
    if (length < sizeof h)
        return sizeof h;
    memcpy(&h, bytes, sizeof h);
    return sizeof h + n * sizeof(saved_place) + h.n_targets * sizeof(motion_target) +
           (h.pushed ? (size_t)n * FORCE_WORDS * sizeof(float) : 0);
}

static bool bad_place(const char *path, uint32_t place, const char *what, duet_error *err)
{
    return error_set(err, DUET_STATUS_BAD_INPUT, "%s: the saved motion's place %u: %s", path, place,
                     what);
}

static bool take_head(duet_motion *as, const saved_head *h, const char *path, duet_error *err)
{
    duet_error why = {0};
    duet_motion_def *d = &as->def;
    bool pulled = d->attraction != 0.0;
    recorded_to_def(&h->def, d);
    if (!motion_check_def(d, &why))
        return error_set(err, DUET_STATUS_BAD_INPUT, "%s: the saved motion: %s", path, why.text);
    if (pulled != (d->attraction != 0.0))
        return error_set(err, DUET_STATUS_BAD_INPUT,
                         "%s: the saved motion's attraction is %g; expected none or both of the "
                         "file's and the motion's to be 0",
                         path, d->attraction);
    if (h->rows_stale)
        motion_alter_all(as);
    if (h->rows_stale > 1 || h->pushed > 1 || h->unused > 0 ||
        (h->pushed && !(as->effects & DUET_EFFECT_FORCES)))
        return error_set(err, DUET_STATUS_BAD_INPUT,
                         "%s: the saved motion's commands have no such word", path);
    return true;
}

static const char *place_fault(const duet_motion *as, const saved_place *s)
{
    uint32_t place_is_empty = s->state == PLACE_EMPTY || s->state == PLACE_LEFT;
    if (s->state >= PLACE_STATES || s->body.flags > (RECORDED_FIXED_ROTATION | RECORDED_SENSOR))
        return "there is no such word for its body";
    if (place_is_empty && s->body.mass != 0.0f)
        return "it is empty and has a mass";
    for (uint32_t k = 0; as->cells && k < as->def.dims; ++k)
        if (abs(s->cell[k] / 2) > 1 << 29)
            return "it is beyond 2^30 origin cells";
    return NULL;
}

static bool take_place(duet_motion *as, uint32_t place, const saved_place *s, const char *path,
                       duet_error *err)
{
    duet_body *b = &as->bodies[place];
    *b = recorded_to_body(&s->body, s->radius);
    as->poses[place] = s->pose;
    if (as->cells)
        memcpy(as->cells[place].s, s->cell, sizeof s->cell);
    motion_commands *c = as->commands;
    c->generations[place] = s->generation;
    c->states[place] = (uint8_t)s->state;
    c->user_data[place] = s->user_data;
    c->n_hidden += s->state != PLACE_ENABLED;
    c->any_left |= s->state == PLACE_LEFT;
    if (s->state == PLACE_EMPTY && place < c->first_empty)
        c->first_empty = place;
    const char *fault = place_fault(as, s);
    fault = fault ? fault : motion_pose_fault(&s->pose, as->def.dims);
    fault = fault ? fault : motion_body_fault(b);
    return !fault || bad_place(path, place, fault, err);
}

static bool take_target(const duet_motion *as, const motion_target *t, const char *path,
                        duet_error *err)
{
    duet_pose pose = {.half_extents = {0}};
    memcpy(pose.centre, t->pose.centre, sizeof pose.centre);
    memcpy(pose.rotation, t->pose.rotation, sizeof pose.rotation);
    bool ok = t->place < as->n && !motion_is_hidden(as, t->place) &&
              !(as->bodies[t->place].mass > 0.0f) && !motion_pose_fault(&pose, as->def.dims);
    return ok || bad_place(path, t->place, "no such body can have a target", err);
}

// What the objects call for is what the motion has; its kernels may still have to learn
// that bodies tumble.
static bool take_facts(duet_motion *as, const char *path, duet_error *err)
{
    const effect_facts before = as->facts;
    as->facts = (effect_facts){0};
    effect_facts_add(&as->facts, &as->def, as->poses, as->bodies, as->n);
    as->facts.reach = before.reach;
    if (effect_infer(&as->def, &as->facts) & ~as->effects)
        return error_set(err, DUET_STATUS_BAD_INPUT,
                         "%s: the saved motion's bodies need effects that the motion lacks", path);
    bool tumbles = as->facts.uneven && !before.uneven;
    as->facts.uneven |= before.uneven;
    return !tumbles || !(as->effects & DUET_EFFECT_ANGULAR_VELOCITY) ||
           motion_prepare_again(as, err);
}

static bool put_forces(duet_motion *as, const char *bytes, const char *path, duet_error *err)
{
    size_t n = (size_t)as->n * FORCE_WORDS;
    motion_rows rows;
    if (!motion_rows_open(as, FORCES, 0, as->n, &rows, err))
        return false;
    memcpy(rows.bytes, bytes, n * sizeof(float));
    bool ok = true;
    for (size_t i = 0; ok && i < n; ++i)
        ok = isfinite(((const float *)(void *)rows.bytes)[i]) ||
             bad_place(path, (uint32_t)(i / FORCE_WORDS), "a force is not finite", err);
    return motion_rows_close(as, &rows, err) && ok;
}

// ---------------------------------------------------------------- a copy

static bool reserve_copy(duet_motion *as, bool commands, duet_error *err)
{
    size_t n = (size_t)as->n + 1;
    bool placed = as->cells;
    as->poses = calloc(n, sizeof *as->poses);
    as->bodies = calloc(n, sizeof *as->bodies);
    as->cells = placed ? calloc(n, sizeof *as->cells) : NULL;
    as->commands = NULL;
    memset(as->buffers, 0, sizeof as->buffers);
    bool ok = as->poses && as->bodies && (as->cells || !placed);
    if (ok && commands)
        return motion_begin_commands(as, err);
    return ok || error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %u objects", as->n);
}

static void copy_given(duet_motion *as, const motion_given *given)
{
    memcpy(as->poses, given->poses, as->n * sizeof *as->poses);
    memcpy(as->bodies, given->bodies, as->n * sizeof *as->bodies);
    if (as->cells)
        memcpy(as->cells, given->cells, as->n * sizeof *as->cells);
}

static bool take_places(duet_motion *as, const char **at, const char *path, duet_error *err)
{
    bool ok = true;
    for (uint32_t place = 0; ok && place < as->n; ++place) {
        saved_place s;
        memcpy(&s, *at, sizeof s);
        *at += sizeof s;
        ok = take_place(as, place, &s, path, err);
    }
    return ok;
}

static bool take_targets(duet_motion *as, uint32_t n, const char **at, const char *path,
                         duet_error *err)
{
    motion_commands *c = as->commands;
    c->targets = malloc((size_t)n * sizeof *c->targets + 1);
    if (!c->targets)
        return error_set(err, DUET_STATUS_NO_MEMORY, "%s: no memory for %u targets", path, n);
    memcpy(c->targets, *at, n * sizeof *c->targets);
    *at += n * sizeof *c->targets;
    c->n_targets = n;
    bool ok = true;
    for (uint32_t i = 0; ok && i < n; ++i)
        ok = take_target(as, &c->targets[i], path, err);
    return ok;
}

bool motion_take_commands(duet_motion *as, const char *bytes, const char *path, duet_error *err)
{
    const motion_given *given = as->commands ? &as->commands->given : NULL;
    saved_head h = {.n_targets = 0};
    if (!reserve_copy(as, bytes, err))
        return false;
    if (!bytes) {
        as->def = given->def;
        copy_given(as, given);
        return take_facts(as, path, err) && motion_reset(as, err);
    }
    const char *at = bytes + sizeof h;
    memcpy(&h, bytes, sizeof h);
    bool ok = take_head(as, &h, path, err) && take_places(as, &at, path, err) &&
              take_targets(as, h.n_targets, &at, path, err) && take_facts(as, path, err) &&
              motion_reset(as, err) && (!h.pushed || put_forces(as, at, path, err));
    as->commands->pushed = h.pushed;
    return ok;
}

void motion_forget_copy(duet_motion *as)
{
    for (int which = 0; which < MOTION_BUFFERS; ++which)
        buffer_release(&as->buffers[which]);
    free(as->poses);
    free(as->bodies);
    free(as->cells);
    motion_forget_commands(as->commands);
}

// What a motion was made of stays known.
static void keep_given(duet_motion *before, duet_motion *as)
{
    if (!as->commands)
        return;
    motion_given given = as->commands->given;
    if (before->commands) {
        as->commands->given = before->commands->given;
        before->commands->given = given;
        return;
    }
    as->commands->given = (motion_given){.n = before->n,
                                         .def = before->def,
                                         .poses = before->poses,
                                         .cells = before->cells,
                                         .bodies = before->bodies};
    before->poses = given.poses;
    before->cells = given.cells;
    before->bodies = given.bodies;
}

void motion_adopt(duet_motion *m, duet_motion *as)
{
    duet_motion before = *m;
    keep_given(&before, as);
    for (int which = 0; which < MOTION_BUFFERS; ++which)
        if (!as->buffers[which].mem)
            buffer_swap(&as->buffers[which], &before.buffers[which]);
    *m = *as;
    motion_forget_copy(&before);
}
