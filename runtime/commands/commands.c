// SPDX-License-Identifier: MIT
#include "runtime/commands/commands.h"

#include "base/error.h"
#include "runtime/commands/recording.h"

// ---------------------------------------------------------------- the list

#define ROW_LIST(type, rows_)
#define ROW_ROWS(type, rows_) .rows = #rows_, .row = sizeof(type),
#define ROW_FIELDS ROW_ROWS
#define ROW_ADD ROW_ROWS
#define ROW_DEF ROW_ROWS

#define COMMAND(number_, name, form_, bodies_, effect_, type, rows_) \
    [number_] = {ROW_##form_(type, rows_).number = number_,          \
                 .call = "duet_motion_" #name,                       \
                 .form = COMMAND_##form_,                            \
                 .bodies = COMMAND_##bodies_,                        \
                 .effect = effect_,                                  \
                 .run = command_##name},
static const command_op ops[] = {
#include "runtime/commands/commands.inl"
};

const command_op *command_op_at(uint32_t number)
{
    return number < sizeof ops / sizeof *ops && ops[number].run ? &ops[number] : NULL;
}

bool command_give(duet_motion *m, command *c, duet_error *err)
{
    PUBLIC_CALL(err);
    const command_op *op = c->op;
    bool ok = (!op->rows || c->list.n == 0 || error_given(c->rows, op->call, op->rows, err)) &&
              command_open(m, c, err) && motion_needs(m, op->effect, op->call, err) &&
              op->run(m, c, err);
    if (ok)
        recording_add(m, c);
    command_close(c);
    return ok;
}

// ---------------------------------------------------------------- calls

#define CALL_LIST(number, name, type, rows_)                                       \
    bool duet_motion_##name(duet_motion *m, duet_body_list list, duet_error *err)  \
    {                                                                              \
        return command_give(m, &(command){.op = &ops[number], .list = list}, err); \
    }
#define CALL_ROWS(number, name, type, rows_)                                                      \
    bool duet_motion_##name(duet_motion *m, duet_body_list list, const type *rows_,               \
                            duet_error *err)                                                      \
    {                                                                                             \
        return command_give(m, &(command){.op = &ops[number], .list = list, .rows = rows_}, err); \
    }
#define CALL_FIELDS(number_, name, type, rows_)                                           \
    bool duet_motion_##name(duet_motion *m, duet_body_list list, uint32_t fields,         \
                            const type *rows_, duet_error *err)                           \
    {                                                                                     \
        command c = {.op = &ops[number_], .list = list, .fields = fields, .rows = rows_}; \
        return command_give(m, &c, err);                                                  \
    }
#define CALL_ADD(number_, name, type, rows_)                                            \
    bool duet_motion_##name(duet_motion *m, const type *rows_, const duet_body *bodies, \
                            uint32_t n, uint64_t *ids, duet_error *err)                 \
    {                                                                                   \
        command c = {.op = &ops[number_],                                               \
                     .list.n = n,                                                       \
                     .rows = rows_,                                                     \
                     .new_bodies = bodies,                                              \
                     .new_ids = ids};                                                   \
        return command_give(m, &c, err);                                                \
    }
#define CALL_DEF(number_, name, type, rows_)                                                  \
    bool duet_motion_##name(duet_motion *m, const duet_motion_def *rows_, duet_error *err)    \
    {                                                                                         \
        PUBLIC_CALL(err);                                                                     \
        if (!motion_is_whole(m, __func__, err) || !motion_check_def(rows_, err) ||            \
            !check_same(rows_, &m->def, __func__, err))                                       \
            return false;                                                                     \
        const type packed = packed_def_of(rows_);                                             \
        return command_give(m, &(command){.op = &ops[number_], .list.n = 1, .rows = &packed}, \
                            err);                                                             \
    }

// That only the members differ which a command can change.
static bool check_same(const duet_motion_def *a, const duet_motion_def *b, const char *call,
                       duet_error *err)
{
    const struct {
        const char *name;
        double of, motion;
    } same[] = {
        {"dims", a->dims, b->dims},
        {"wants", a->wants, b->wants},
        {"doubles", a->doubles, b->doubles},
        {"origin[0]", a->origin[0], b->origin[0]},
        {"origin[1]", a->origin[1], b->origin[1]},
        {"origin[2]", a->origin[2], b->origin[2]},
        {"origin_edge", a->origin_edge, b->origin_edge},
        {"boundary", a->boundary, b->boundary},
        {"dt", a->dt, b->dt},
        {"substeps", a->substeps, b->substeps},
        {"integrator", a->integrator, b->integrator},
        {"skin", a->skin, b->skin},
        {"slop", a->slop, b->slop},
        {"hit_speed", a->hit_speed, b->hit_speed},
        {"event_mask", a->event_mask, b->event_mask},
    };
    for (size_t i = 0; i < sizeof same / sizeof same[0]; ++i)
        if (same[i].of != same[i].motion)
            return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                             "%s: %s is %g; expected the motion's %g, which cannot change", call,
                             same[i].name, same[i].of, same[i].motion);
    return a->pair == b->pair ||
           error_set(err, DUET_STATUS_BAD_ARGUMENT,
                     "%s: pair is another; expected the motion's, which cannot change", call);
}

#define COMMAND(number, name, form, bodies, effect, type, rows) \
    CALL_##form(number, name, type, rows)
#include "runtime/commands/commands.inl"

// ---------------------------------------------------------------- what is asked

const duet_motion_def *duet_motion_get_def(const duet_motion *m)
{
    return m ? &m->def : NULL;
}

bool duet_motion_get_user_data(duet_motion *m, duet_body_list list, uint64_t *data, duet_error *err)
{
    PUBLIC_CALL(err);
    command c = {.op = &(command_op){.call = __func__}, .list = list};
    bool ok = (list.n == 0 || error_given(data, __func__, "data", err)) && command_open(m, &c, err);
    for (uint32_t i = 0; ok && i < list.n; ++i)
        data[i] = m->commands->user_data[c.places[i]];
    command_close(&c);
    return ok;
}
