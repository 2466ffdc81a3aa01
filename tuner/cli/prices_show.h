// SPDX-License-Identifier: MIT
// Measures what levels of accuracy cost while a person looks on.
#ifndef CLI_PRICES_SHOW_H
#define CLI_PRICES_SHOW_H

#include "tuner/prices.h"

// Each device alone, with a progress line; Ctrl-C ends it with the whole rounds
// until then.
bool prices_show(prices *p, duet_device_pair *pair, const duet_scene *scene, uint32_t rounds,
                 duet_error *err);

#endif
