// SPDX-License-Identifier: MIT
// duet source --list
#ifndef CLI_SOURCE_LIST_H
#define CLI_SOURCE_LIST_H

#include "gen/gen.h"

// kernel NULL: all of them.
bool source_list(gen *g, const char *kernel, const gen_limits *limits, bool json, duet_error *err);

#endif
