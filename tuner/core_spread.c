// SPDX-License-Identifier: MIT
#include "tuner/core_spread.h"

#include "duet_device.h"

uint32_t core_spread(const duet_device_pair *pair)
{
    uint32_t units = 0, most = 1;
    for (int device = duet_device_pair_is_one(pair) ? 1 : 0; device < 2; ++device) {
        const duet_device_info *info = duet_device_pair_get_info(pair, device);
        uint32_t own = info->kind == DUET_KIND_CPU ? info->units : 0;
        units += own;
        most = own > most ? own : most;
    }
    return most > 1 ? units : 1;
}
