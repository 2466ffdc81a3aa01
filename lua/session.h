// SPDX-License-Identifier: MIT
// A Lua state with the module `duet` in it, for `duet lua`.
//
// One that is not trusted is a private state of gen/sandbox.h: it computes,
// prints, and uses devices; it changes no file (policy.h) and ends at its
// limits. A trusted one has the whole language.
#ifndef LUA_SESSION_H
#define LUA_SESSION_H

#include "base/text.h"
#include "duet_error.h"

#include <stdbool.h>
#include <stddef.h>

typedef struct session session;

typedef struct session_def {
    bool trusted;
    bool prompt;                  // session_enter and session_complete are called
    size_t memory_bytes;          // bytes of the state, if not trusted
    double seconds;               // time of one run, if not trusted
    const char *const *arguments; // the global arg, [0] the script; borrowed
    int n_arguments;
} session_def;

session_def session_default_def(void); // not trusted, 256 MiB, 60 s

session *session_open(const session_def *def, duet_error *err);
void session_close(session *s);

// Both: BAD_INPUT with file:line where the script raises an error or passes a
// limit. A first line that begins with # is passed over.
bool session_run_file(session *s, const char *path, duet_error *err);
bool session_run_text(session *s, const char *name, const char *chars, duet_error *err);

// Runs what was typed: an expression's values are printed. *more is set, and
// nothing run, where the text is only the beginning of something.
bool session_enter(session *s, const char *chars, bool *more, duet_error *err);

// The names that begin with "duet.de" or "pair:wo", whole and in order, a line each. False
// if there is no such object.
bool session_complete(session *s, const char *word, text *words);

#endif
