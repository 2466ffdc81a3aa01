// SPDX-License-Identifier: MIT
// Rows of one number as NumPy reads them; runtime/scene/scene_npy.c reads.
#ifndef BASE_NPY_H
#define BASE_NPY_H

#include "base/error.h"

#include <stdbool.h>
#include <stdint.h>

typedef enum npy_type { NPY_UINT8, NPY_FLOAT64 } npy_type;

// Writes an array of shape (n,). The file appears whole or not at all.
bool npy_write(const char *path, npy_type type, const void *values, uint64_t n, duet_error *err);

#endif
