// SPDX-License-Identifier: MIT
// A command on its way: what the caller gave, and copies of the bodies that it changes.
//
// command_give (commands.h) opens it: each listed body is there, and enabled if it must be. Its
// check looks at all the rest and changes nothing. Its act then changes the motion, and a failure
// of that breaks the motion (motion_keep_whole).
//
// A motion over ranks gives each of its domains a part of a command: the bodies that the domain
// has. All parts are checked before one acts.
#ifndef RUNTIME_COMMAND_H
#define RUNTIME_COMMAND_H

#include "runtime/dynamics/motion_rows.h"
#include "runtime/dynamics/motion_state.h"
#include "runtime/dynamics/motion_targets.h"

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
    const char *call, *cluster_call; // "duet_motion_set_poses", "duet_cluster_set_poses"
    command_form form;
    command_bodies bodies;
    uint32_t effect;
    const char *rows; // the argument's name; NULL: none
    size_t row;       // bytes of one
    bool (*check)(duet_motion *m, command *c, duet_error *err);
    bool (*act)(duet_motion *m, command *c, duet_error *err);
} command_op;

static inline bool command_has_list(const command_op *op)
{
    return op->form != COMMAND_ADD && op->form != COMMAND_DEF;
}

// Rows that forces and impulses read and change, open from their check to their act. The last three
// are empty if nothing turns.
typedef struct command_pushed {
    motion_rows forces;
    motion_rows velocities, angular_velocities, rotations, inertias;
} command_pushed;

struct command {
    const command_op *op;
    const char *call;    // "duet_motion_set_poses"
    duet_body_list list; // COMMAND_ADD, COMMAND_DEF: n alone
    const uint32_t *of;  // [n] a part: which of all listed bodies each is; NULL: it is no part
    uint32_t n_all;      // among these
    uint32_t *blamed;    // gets which of these a failure names; NULL: it is not asked for
    uint32_t fields;
    const void *rows;            // [n]
    const duet_body *new_bodies; // [n] that come; NULL: duet_default_body each
    uint64_t *new_ids;           // [n] of those; NULL: not asked for

    uint64_t *ids;    // [n] listed, if the motion is recorded
    uint32_t *places; // [n] listed, or of those that come
    duet_pose *poses; // [n] as they will be, from command_copy on
    duet_body *bodies;
    cl_int4 *cells; // from command_settle on; NULL without origin cells

    command_pushed pushed;
};

// Finds the places of the listed bodies. BAD_ARGUMENT if the motion or a body of the list is wrong.
bool command_open(duet_motion *m, command *c, duet_error *err);

// Whether the id of body i of the list is one that a motion with so many places can have given.
bool command_check_id(const command *c, uint32_t i, uint32_t n_places, duet_error *err);

// Whether body i of the list, which lies at a place, is there, and enabled if it must be.
bool command_check_place(const duet_motion *m, const command *c, uint32_t i, uint32_t place,
                         duet_error *err);
void command_close(command *c);

// Copies the poses and bodies at the places; of those that come, what was given.
bool command_copy(const duet_motion *m, command *c, duet_error *err);

// BAD_OBJECT if a pose is wrong, or a body, of whichever these parts are.
bool command_check(const duet_motion *m, const command *c, uint32_t parts, duet_error *err);

// Turns centres into offsets in origin cells, if the motion has some. BAD_OBJECT beyond 2^30 cells.
bool command_settle(const duet_motion *m, command *c, duet_error *err);

// Adds to *facts what the bodies of a command, if it has some, say. BAD_ARGUMENT if they call for
// an effect that the motion lacks.
bool command_add_facts(const duet_motion *m, const command *c, effect_facts *facts,
                       duet_error *err);

// Makes facts the motion's, whose kernels may have to know more then.
bool command_admit(duet_motion *m, effect_facts facts, duet_error *err);

// Makes the poses the motion's, to be sent.
void command_keep_poses(duet_motion *m, const command *c);

// How many bodies all of the command lists.
static inline uint32_t command_count(const command *c)
{
    return c->of ? c->n_all : c->list.n;
}

// Fails with a line that names body i of the list; returns false. command_refuse: BAD_OBJECT.
__attribute__((format(printf, 5, 6))) bool command_fail(const command *c, uint32_t i,
                                                        duet_status status, duet_error *err,
                                                        const char *format, ...);
bool command_refuse(const command *c, uint32_t i, const char *fault, duet_error *err);

#define COMMAND(number, name, form, bodies, effect, type, rows)     \
    bool check_##name(duet_motion *m, command *c, duet_error *err); \
    bool act_##name(duet_motion *m, command *c, duet_error *err);
#include "runtime/commands/commands.inl"

// The check of a command whose list is all that can be wrong.
#define CHECKS_ITS_LIST(name)                                      \
    bool check_##name(duet_motion *m, command *c, duet_error *err) \
    {                                                              \
        return (void)m, (void)c, (void)err, true;                  \
    }

#endif
