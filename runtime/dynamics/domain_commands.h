// SPDX-License-Identifier: MIT
// The state that commands left of a domain's bodies, as the end of each body's state.
#ifndef RUNTIME_DOMAIN_COMMANDS_H
#define RUNTIME_DOMAIN_COMMANDS_H

#include "runtime/duet.h"

// The ends of states, so many bytes one behind the other.
typedef struct domain_left {
    char *rows;
    size_t stride;
} domain_left;

// 0 before the first command.
size_t domain_command_bytes(const duet_motion *m);

// Whether the first of them is of a body that was removed or is disabled.
bool domain_left_hidden(const duet_motion *m, domain_left left);

// Reads those of bodies at n ascending places. Takes those of all, before the bodies are sent, and
// then the forces among them.
bool domain_read_commands(duet_motion *m, domain_left left, const uint32_t *places, uint32_t n,
                          duet_error *err);
bool domain_take_commands(duet_motion *m, domain_left left, duet_error *err);
bool domain_take_forces(duet_motion *m, domain_left left, duet_error *err);

#endif
