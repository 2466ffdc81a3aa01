// SPDX-License-Identifier: MIT
// The view of the global ids. A device keeps the ids from step to step and is sent only those that
// changed.
#ifndef RUNTIME_PART_IDS_H
#define RUNTIME_PART_IDS_H

#include "runtime/broadphase/part.h"

// Makes the view equal to the ids: by the changes if it has the generation before, else by all.
bool part_update_ids(part *p, const global_ids *ids, duet_error *err);

#endif
