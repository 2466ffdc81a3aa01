// SPDX-License-Identifier: MIT
// Measures what levels of accuracy cost while a person looks on.
#ifndef CLI_LEVEL_COSTS_SHOW_H
#define CLI_LEVEL_COSTS_SHOW_H

#include "tuner/level_costs.h"

// Each device alone, with a progress line; Ctrl-C ends it with the whole rounds
// until then.
bool level_costs_show(level_costs *p, duet_device_pair *pair, const duet_scene *scene,
                      uint32_t rounds, duet_error *err);

#endif
