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
                 .cluster_call = "duet_cluster_" #name,              \
                 .form = COMMAND_##form_,                            \
                 .bodies = COMMAND_##bodies_,                        \
                 .effect = effect_,                                  \
                 .check = check_##name,                              \
                 .act = act_##name},
static const command_op ops[] = {
#include "runtime/commands/commands.inl"
};

const command_op *command_op_at(uint32_t number)
{
    return number < sizeof ops / sizeof *ops && ops[number].act ? &ops[number] : NULL;
}

bool command_check_given(const command *c, duet_error *err)
{
    return !c->op->rows || c->list.n == 0 || error_given(c->rows, c->call, c->op->rows, err);
}

bool command_look(duet_motion *m, command *c, duet_error *err)
{
    return motion_needs(m, c->op->effect, c->call, err) && c->op->check(m, c, err);
}

bool command_give(duet_motion *m, command *c, duet_error *err)
{
    PUBLIC_CALL(err);
    const command_op *op = c->op;
    c->call = op->call;
    bool ok = command_check_given(c, err) && command_open(m, c, err) && command_look(m, c, err);
    effect_facts facts = ok ? m->facts : 0;
    ok = ok && command_add_facts(m, c, &facts, err) && command_admit(m, facts, err) &&
         motion_keep_whole(m, op->act(m, c, err));
    if (ok)
        recording_add(m, c);
    command_close(c);
    return ok;
}

// ---------------------------------------------------------------- calls

#define GIVE(number, ...)                                                         \
    {                                                                             \
        return command_give(m, &(command){.op = &ops[number], __VA_ARGS__}, err); \
    }
#define CALL(name) duet_motion_##name
#define SUBJECT duet_motion *m
#include "runtime/commands/command_calls.inl"

// ---------------------------------------------------------------- what is asked

const duet_motion_def *duet_motion_get_def(const duet_motion *m)
{
    return m ? &m->def : NULL;
}

bool duet_motion_get_user_data(duet_motion *m, duet_body_list list, uint64_t *data, duet_error *err)
{
    PUBLIC_CALL(err);
    command c = {.op = &(command_op){0}, .call = __func__, .list = list};
    bool ok = (list.n == 0 || error_given(data, __func__, "data", err)) && command_open(m, &c, err);
    for (uint32_t i = 0; ok && i < list.n; ++i)
        data[i] = m->commands->user_data[c.places[i]];
    command_close(&c);
    return ok;
}
