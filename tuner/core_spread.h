// SPDX-License-Identifier: MIT
// Over how many threads a device pair spreads a piece of work.
#ifndef TUNER_CORE_SPREAD_H
#define TUNER_CORE_SPREAD_H

#include "duet_device.h"

#include <stdint.h>

// The units of its CPUs, if one of these has several, which share its work as they come; 1: each
// CPU is one thread, or there is none.
uint32_t core_spread(const duet_device_pair *pair);

#endif
