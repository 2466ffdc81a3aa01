// SPDX-License-Identifier: MIT
// Files of the source tree that are carried inside the library: kernels,
// cards, templates, the store's schema. gen/embed.cmake writes the table.
#ifndef BASE_BLOB_H
#define BASE_BLOB_H

#include <stddef.h>

typedef struct blob {
    const char *path;  // path in the source tree: "kernels/narrowphase/narrow.cl"
    const char *bytes; // followed by a NUL
    size_t length;
    const char *sha256; // hash of the bytes, lower-case hex
} blob;

extern const blob blobs[]; // ends with a NULL path

const blob *blob_find(const char *path); // NULL if none is carried

#endif
