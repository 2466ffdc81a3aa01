// SPDX-License-Identifier: MIT
// Commands to a motion over ranks. Rank 0 gives a command, and each domain gets the part of it that
// names its bodies, its ghosts included.
#ifndef CLUSTER_MOVING_COMMANDS_H
#define CLUSTER_MOVING_COMMANDS_H

#include "cluster/moving.h"
#include "runtime/commands/command.h"

typedef enum given_command {
    COMMAND_DONE,
    COMMAND_REFUSED, // and nothing has changed
    COMMAND_BROKE,   // the motion is not whole any more
} given_command;

// Gives the motion rank 0's command; of those of other ranks op, call and new_ids count.
// Collective.
given_command moving_give(moving *m, command *c, duet_error *own);

// Makes data [n of rank 0's list] the user data of its bodies, on all ranks. Collective.
bool moving_get_user_data(moving *m, duet_body_list list, const char *call, uint64_t **data,
                          uint32_t *n, duet_error *own);

// The def of all domains, the same on all ranks apart from its pair and plan.
const duet_motion_def *moving_get_def(const moving *m);

#endif
