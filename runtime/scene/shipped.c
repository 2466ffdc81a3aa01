// SPDX-License-Identifier: MIT
#include "runtime/scene/shipped.h"

#include "base/nearest.h"

#include <stdio.h>
#include <string.h>

static const char folder[] = "lua/scenes/";

enum { FOLDER = sizeof folder - 1 };

static void describe(const blob *file, shipped_scene *scene)
{
    const char *name = file->path + FOLDER;
    const char *line = strchr(file->bytes, '\n') + 1; // behind the one with the licence
    line += strspn(line, "- ");
    *scene = (shipped_scene){.file = file};
    snprintf(scene->name, sizeof scene->name, "%.*s", (int)strcspn(name, "."), name);
    snprintf(scene->about, sizeof scene->about, "%.*s", (int)strcspn(line, "\n"), line);
}

bool shipped_at(unsigned i, shipped_scene *scene)
{
    for (const blob *b = blobs; b->path; ++b) {
        if (strncmp(b->path, folder, FOLDER) != 0 || i-- > 0)
            continue;
        describe(b, scene);
        return true;
    }
    return false;
}

bool shipped_find(const char *name, shipped_scene *scene)
{
    for (unsigned i = 0; shipped_at(i, scene); ++i)
        if (strcmp(scene->name, name) == 0)
            return true;
    return false;
}

bool shipped_find_nearest(const char *typed, shipped_scene *scene)
{
    nearest n = nearest_begin(typed);
    shipped_scene other;
    for (unsigned i = 0; shipped_at(i, &other); ++i) {
        nearest_try(&n, other.name);
        if (n.name == other.name) {
            *scene = other;
            n.name = scene->name;
        }
    }
    return n.name;
}
