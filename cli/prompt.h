// SPDX-License-Identifier: MIT
// Lines that a person types, with editing and history; or those of a file or a
// pipe, without a prompt.
#ifndef CLI_PROMPT_H
#define CLI_PROMPT_H

#include <stdbool.h>

// The next line without its end, given back by free; NULL at the end.
char *prompt_line(const char *prompt);

// What was typed, all its lines, for the arrow keys.
void prompt_remember(const char *typed);

bool prompt_is_terminal(void);

#endif
