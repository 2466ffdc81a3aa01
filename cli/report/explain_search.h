// SPDX-License-Identifier: MIT
// What `duet explain` tells of a still scene: what of it is compiled in, which
// kernels find its pairs, and which are left out.
#ifndef CLI_EXPLAIN_SEARCH_H
#define CLI_EXPLAIN_SEARCH_H

#include "runtime/duet.h"

struct cJSON;

// Steps the scene once in such a world. With o it adds "search" to that object,
// else it prints.
bool explain_search(const duet_world_def *def, const duet_scene *scene, struct cJSON *o,
                    duet_error *err);

#endif
