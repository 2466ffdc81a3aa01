// SPDX-License-Identifier: MIT
#include "support/kernels.h"

#include "base/blob.h"
#include "base/text.h"
#include "support/test.h"

#include <sys/stat.h>

// Gives the path of a file within the folder; its own folder is made.
static void file_path(text *path, const char *folder, const char *file)
{
    const char *slash = strrchr(file, '/');
    text_add(path, "%s/%.*s", folder, (int)(slash ? slash - file : 0), file);
    mkdir(folder, 0777);
    mkdir(path->chars, 0777);
    text_free(path);
    text_add(path, "%s/%s", folder, file);
}

void test_kernels_write(const char *folder, const char *changed, const char *before,
                        const char *after)
{
    for (const blob *b = blobs; b->path; ++b) {
        if (strncmp(b->path, "kernels/", 8) != 0)
            continue;
        own(text) path = {0};
        bool other = strcmp(b->path + 8, changed) == 0;
        file_path(&path, folder, b->path + 8);
        FILE *file = fopen(path.chars, "w");
        assert_non_null(file);
        fputs(other ? before : "", file);
        fwrite(b->bytes, 1, b->length, file);
        fputs(other ? after : "", file);
        fclose(file);
    }
}
