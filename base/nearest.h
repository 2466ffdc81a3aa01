// SPDX-License-Identifier: MIT
// Which of some names a mistyped one was probably meant to be.
//
//     nearest n = nearest_begin("devcies");
//     nearest_try(&n, "devices");
//     n.name; // "devices", or NULL
#ifndef BASE_NEAREST_H
#define BASE_NEAREST_H

typedef struct nearest {
    const char *typed;
    const char *name; // NULL: none is near enough
    unsigned edits;   // fewer are nearer
} nearest;

nearest nearest_begin(const char *typed);
void nearest_try(nearest *n, const char *name);

#endif
