// SPDX-License-Identifier: MIT
// A command on its way: what the caller gave, and copies of the bodies that it changes.
//
// command_give (commands.h) opens it: each listed body is there, and enabled if it must be. The
// command's own function then checks all the rest before it changes anything. A failure after that
// breaks the motion (motion_keep_whole).
#ifndef RUNTIME_COMMAND_H
#define RUNTIME_COMMAND_H

#include "runtime/dynamics/motion_commands.h"

typedef struct command command;

typedef enum command_form {
    COMMAND_LIST,
    COMMAND_ROWS,
    COMMAND_FIELDS,
    COMMAND_ADD,
    COMMAND_DEF
} command_form;

typedef enum command_bodies { COMMAND_ANY, COMMAND_ENABLED } command_bodies;

// A row of commands.inl.
typedef struct command_op {
    uint32_t number;
    const char *call; // "duet_motion_set_poses"
    command_form form;
    command_bodies bodies;
    uint32_t effect;
    const char *rows; // the argument's name; NULL: none
    size_t row;       // bytes of one
    bool (*run)(duet_motion *m, command *c, duet_error *err);
} command_op;

static inline bool command_has_list(const command_op *op)
{
    return op->form != COMMAND_ADD && op->form != COMMAND_DEF;
}

struct command {
    const command_op *op;
    duet_body_list list; // COMMAND_ADD, COMMAND_DEF: n alone
    uint32_t fields;
    const void *rows;            // [n]
    const duet_body *new_bodies; // [n] that come; NULL: duet_default_body each
    uint64_t *new_ids;           // [n] of those; NULL: not asked for

    uint64_t *ids;    // [n] listed, if the motion is recorded
    uint32_t *places; // [n] listed, or of those that come
    duet_pose *poses; // [n] as they will be, from command_copy on
    duet_body *bodies;
    cl_int4 *cells; // from command_settle on; NULL without origin cells
};

// Finds the places of the listed bodies. BAD_ARGUMENT if the motion or a body of the list is wrong.
bool command_open(duet_motion *m, command *c, duet_error *err);
void command_close(command *c);

// Copies the poses and bodies at the places; of those that come, what was given.
bool command_copy(const duet_motion *m, command *c, duet_error *err);

// BAD_OBJECT if a pose is wrong, or a body, of whichever these parts are.
bool command_check(const duet_motion *m, const command *c, uint32_t parts, duet_error *err);

// Turns centres into offsets in origin cells, if the motion has some. BAD_OBJECT beyond 2^30 cells.
bool command_settle(const duet_motion *m, command *c, duet_error *err);

// Whether the bodies call for no effect that the motion lacks. The motion then knows of them.
bool command_admit(duet_motion *m, const command *c, duet_error *err);

// Makes the poses the motion's, to be sent.
void command_keep_poses(duet_motion *m, const command *c);

// BAD_OBJECT for body i of the list.
bool command_refuse(const command *c, uint32_t i, const char *fault, duet_error *err);

#define COMMAND(number, name, form, bodies, effect, type, rows) \
    bool command_##name(duet_motion *m, command *c, duet_error *err);
#include "runtime/commands/commands.inl"

#endif
