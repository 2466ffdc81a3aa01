// SPDX-License-Identifier: MIT
// Rows of one number as NumPy reads them; runtime/scene/scene_npy.c reads.
#ifndef BASE_NPY_H
#define BASE_NPY_H

#include "base/error.h"
#include "base/text.h"

#include <stdbool.h>
#include <stdint.h>

typedef enum npy_type { NPY_UINT8, NPY_FLOAT64, NPY_UINT64 } npy_type;

// Writes an array of shape (n,). The file appears whole or not at all.
bool npy_write(const char *path, npy_type type, const void *values, uint64_t n, duet_error *err);

// Adds what comes before the values: of shape (rows,) for 0 columns, else (rows, columns).
void npy_add_header(text *file, npy_type type, uint64_t rows, uint32_t columns);

#endif
