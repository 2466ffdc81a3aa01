// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L
#include "cli/prompt.h"

#include <editline/readline.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

bool prompt_is_terminal(void)
{
    return isatty(STDIN_FILENO) && isatty(STDOUT_FILENO);
}

char *prompt_line(const char *prompt)
{
    if (prompt_is_terminal())
        return readline(prompt);
    char *line = NULL;
    size_t capacity = 0;
    ssize_t length = getline(&line, &capacity, stdin);
    if (length < 0) {
        free(line);
        return NULL;
    }
    if (length > 0 && line[length - 1] == '\n')
        line[length - 1] = '\0';
    return line;
}

void prompt_remember(const char *typed)
{
    if (*typed && prompt_is_terminal())
        add_history(typed);
}
