// SPDX-License-Identifier: MIT
#include "base/blob.h"

#include <string.h>

const blob *blob_find(const char *path)
{
    for (const blob *b = blobs; b->path; ++b)
        if (strcmp(b->path, path) == 0)
            return b;
    return NULL;
}
