// SPDX-License-Identifier: MIT
// What a script finds in its state: cards, templates, scene files and tune files
// can compute and nothing else. There are no files, no processes, no clock, no
// bytecode, no metatables, no coroutines, no pcall, and the result is the same on
// every run.
#ifndef GEN_SANDBOX_H
#define GEN_SANDBOX_H

#include "gen/script.h"

// A script with these globals, closed by script_close. limits may be NULL for the
// default ones. NULL with NO_MEMORY, or limits.failure where they are too tight.
script *sandbox_open(const script_limits *limits, duet_error *err);

#endif
