// SPDX-License-Identifier: MIT
// Contacts by colour: those of one colour share no body that moves.
#ifndef RUNTIME_COLOURING_H
#define RUNTIME_COLOURING_H

#include "kernels/dynamics/records.h"

#include <CL/cl.h>
#include <stdint.h>

// Keys that contacts are sorted by: several of a colour.
enum { KEYS = COLOURS * COLOUR_KEYS, KEY_BITS = 8 };

// Contacts of one colour: where in the list, and where in blocks. A uint4 on devices.
typedef struct colour_span {
    cl_uint first;
    cl_uint count;
    cl_uint slot;
    cl_uint spare;
} colour_span;

typedef struct colouring {
    colour_span spans[COLOUR_OVERFLOW + 1];
    uint32_t n_used;     // colours that are not empty
    uint32_t n_contacts; // of all colours: those that push
    uint32_t n_blocks;
    uint32_t rounds; // that the next colouring sends at once; 0: the device is asked first
} colouring;

#endif
