// SPDX-License-Identifier: MIT
// What a driver says about a device, as a duet_device_info.
#ifndef RUNTIME_DEVICE_INFO_H
#define RUNTIME_DEVICE_INFO_H

#include "runtime/duet.h"

#include <CL/cl.h>

// Everything but the selector, which is the list's to give. What a driver does
// not answer stays empty or 0.
void device_info_read(cl_device_id id, duet_device_info *info);

#endif
