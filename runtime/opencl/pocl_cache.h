// SPDX-License-Identifier: MIT
// The folder that PoCL keeps built kernels in. Where it cannot make that folder, PoCL
// lists no device and does not say why.
#ifndef RUNTIME_OPENCL_POCL_CACHE_H
#define RUNTIME_OPENCL_POCL_CACHE_H

#include "base/error.h"

// Makes the folder, as PoCL does. NO_DEVICE with the reason where that is not possible.
bool pocl_cache_check(duet_error *err);

#endif
