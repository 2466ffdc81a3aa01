// SPDX-License-Identifier: MIT
// Loads a scene: what a path means, and which reader its source is for.
#define _POSIX_C_SOURCE 200809L
#include "runtime/scene/scene_load.h"

#include "base/error.h"
#include "base/text_file.h"
#include "runtime/scene/scene_source.h"
#include "runtime/scene/shipped.h"

#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define STDIN_NAME "stdin"

static const char *file_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

// "boxes" for "data/boxes.csv".
static bool name_after_file(duet_scene *scene, const char *path, duet_error *err)
{
    const char *name = file_name(path);
    const char *dot = strrchr(name, '.');
    return scene_set_name(scene, name, dot && dot > name ? (size_t)(dot - name) : strlen(name),
                          err);
}

static bool has_ending(const char *path, const char *ending)
{
    size_t length = strlen(path);
    size_t n = strlen(ending);
    return length >= n && strcmp(path + length - n, ending) == 0;
}

// Settings of a file that is data alone: origin=cell, and the cells' edge.
static bool read_origin(const char *path, const duet_setting *settings, uint32_t n_settings,
                        double *edge, duet_error *err)
{
    bool wanted = false;
    double given = 1.0;
    for (uint32_t i = 0; i < n_settings; ++i) {
        const duet_setting *s = &settings[i];
        if (strcmp(s->name, "origin") == 0 && strcmp(s->value, "cell") == 0)
            wanted = true;
        else if (strcmp(s->name, "origin_edge") == 0)
            given = strtod(s->value, NULL);
        else
            return bad_argument(err,
                                "%s: '%s' cannot be chosen, since this is data and no .lua scene; "
                                "only origin=cell and origin_edge can be set",
                                path, s->name);
    }
    *edge = wanted ? given : 0.0;
    return true;
}

// ----------------------------------------------------------------- sources

typedef enum source_kind { SOURCE_LUA, SOURCE_NPY, SOURCE_TEXT } source_kind;

// A file says it by its ending, stdin by what it holds.
static source_kind kind_of(const scene_source *source)
{
    if (strcmp(source->name, STDIN_NAME) != 0)
        return has_ending(source->name, ".lua")   ? SOURCE_LUA
               : has_ending(source->name, ".npy") ? SOURCE_NPY
                                                  : SOURCE_TEXT;
    if (source->length > 0 && source->bytes[0] == '\x93')
        return SOURCE_NPY;
    return scene_is_text(source) ? SOURCE_TEXT : SOURCE_LUA;
}

static bool refuse_path(const char *path, const duet_error *why, duet_error *err)
{
    shipped_scene near;
    if (why->status != DUET_STATUS_NOT_FOUND || strpbrk(path, "/."))
        return error_copy(err, why);
    if (shipped_find_nearest(path, &near))
        return bad_argument(err, "%s: no such file or scene; did you mean '%s'?", path, near.name);
    return bad_argument(err, "%s: no such file or scene; 'duet scenes' lists the scenes", path);
}

// A mesh and a kernel's text belong to a scene or a task; their ending tells them from one.
static bool check_ending(const char *path, duet_error *err)
{
    if (access(path, F_OK) != 0)
        return true;
    if (has_ending(path, ".stl") || has_ending(path, ".obj"))
        return bad_input(err,
                         "%s: a mesh, which is the ground of a scene; expected boxes as text, .npy "
                         "or a .lua scene with mesh = { file = \"%s\" }",
                         path, file_name(path));
    if (has_ending(path, ".cl"))
        return bad_input(err, "%s: the text of a kernel, which a task file names; expected a scene",
                         path);
    return true;
}

// Only the kept rows of a .npy file are read, so it stays where it is.
static bool open_rows(const char *path, scene_source *source)
{
    struct stat info;
    int file = has_ending(path, ".npy") ? open(path, O_RDONLY | O_CLOEXEC) : -1;
    if (file >= 0 && fstat(file, &info) == 0 && S_ISREG(info.st_mode)) {
        *source = (scene_source){.name = path, .length = (size_t)info.st_size, .file = file};
        return true;
    }
    if (file >= 0)
        close(file);
    return false;
}

// The meaning of a path: a scene that comes with Duet by its name, also by its path in the source
// tree where that is not; "-", which is stdin; or a file. The bytes of the last two are in *file.
static bool open_source(const char *path, scene_source *source, text *file, duet_error *err)
{
    shipped_scene shipped;
    const blob *carried = shipped_find(path, &shipped) ? shipped.file
                          : access(path, F_OK) != 0    ? blob_find(path)
                                                       : NULL;
    if (carried) {
        *source = (scene_source){carried->path, carried->bytes, carried->length, -1};
        return true;
    }
    if (open_rows(path, source))
        return true;
    duet_error why = {0};
    if (!text_read_lines(file, path, &why))
        return refuse_path(path, &why, err);
    *source = (scene_source){strcmp(path, "-") == 0 ? STDIN_NAME : path, text_chars(file),
                             file->length, -1};
    return true;
}

static bool read_objects(duet_scene *scene, const scene_source *source,
                         const duet_setting *settings, uint32_t n_settings, duet_error *err)
{
    switch (kind_of(source)) {
    case SOURCE_LUA:
        return scene_read_lua(scene, source, settings, n_settings, err);
    case SOURCE_NPY:
        return scene_read_npy(scene, source, err);
    case SOURCE_TEXT:
        return scene_read_text(scene, source, err);
    }
    return false;
}

// A script says only after its objects whether they are to be placed.
static bool read_source(duet_scene *scene, const scene_source *source, const duet_setting *settings,
                        uint32_t n_settings, duet_error *err)
{
    bool lua = kind_of(source) == SOURCE_LUA;
    double edge = 0.0;
    if (lua && scene->per_row == 2)
        return bad_argument(err, "%s: pairs are read from .npy or text", source->name);
    if (!lua && !read_origin(source->name, settings, n_settings, &edge, err))
        return false;
    scene->keep_centres = lua || edge != 0.0;
    bool ok =
        scene_reserve(scene, 1, err) && read_objects(scene, source, settings, n_settings, err) &&
        (edge == 0.0 || scene_set_origin(scene, NULL, edge, err)) && scene_settle_radii(scene, err);
    scene_forget_centres(scene);
    return ok;
}

static bool read_path(duet_scene *scene, const char *path, const duet_setting *settings,
                      uint32_t n_settings, duet_error *err)
{
    text file = {0};
    scene_source source = {.file = -1};
    bool ok = check_ending(path, err) && open_source(path, &source, &file, err) &&
              name_after_file(scene, source.name, err) &&
              read_source(scene, &source, settings, n_settings, err);
    text_free(&file);
    if (source.file >= 0)
        close(source.file);
    return ok;
}

// Which objects of a source are kept, and how many it has.
typedef struct scene_range {
    uint64_t first, end;
    uint64_t n;
    bool defers;
    uint64_t n_deferred;
} scene_range;

static duet_scene *load(const char *path, uint32_t per_row, scene_range *range,
                        const duet_setting *settings, uint32_t n_settings, duet_error *err)
{
    duet_scene *scene = scene_new(err);
    bool ok = scene;
    if (ok) {
        scene->per_row = per_row;
        scene->first = range->first;
        scene->end = range->end;
        scene->defers = range->defers;
        ok = read_path(scene, path, settings, n_settings, err);
        range->n = scene->n_read;
        range->n_deferred = scene->n_deferred;
    }
    if (ok)
        return scene;
    duet_scene_destroy(scene);
    return NULL;
}

duet_scene *scene_load_range(const char *path, const duet_setting *settings, uint32_t n_settings,
                             uint64_t first, uint64_t end, uint64_t *n, duet_error *err)
{
    scene_range range = {.first = first, .end = end};
    duet_scene *scene = load(path, 1, &range, settings, n_settings, err);
    *n = range.n;
    return scene;
}

static bool check_settings(const duet_setting *settings, uint32_t n, const char *call,
                           duet_error *err)
{
    bool ok = n == 0 || error_given(settings, call, "settings", err);
    for (uint32_t i = 0; ok && i < n; ++i)
        ok = error_given(settings[i].name, call, "a setting's name", err) &&
             error_given(settings[i].value, call, "a setting's value", err);
    return ok;
}

duet_scene *scene_load_deferred(const char *path, const duet_setting *settings, uint32_t n_settings,
                                uint64_t *n, uint64_t *deferred, duet_error *err)
{
    scene_range range = {.end = UINT64_MAX, .defers = true};
    bool ok = check_settings(settings, n_settings, "duet_cluster_load_scene", err);
    duet_scene *scene = ok ? load(path, 1, &range, settings, n_settings, err) : NULL;
    *n = range.n;
    *deferred = range.n_deferred;
    return scene;
}

duet_scene *duet_scene_load(const char *path, const duet_setting *settings, uint32_t n_settings,
                            duet_error *err)
{
    PUBLIC_CALL(err);
    scene_range all = {.end = UINT64_MAX};
    bool ok = error_given(path, __func__, "path", err) &&
              check_settings(settings, n_settings, __func__, err);
    return ok ? load(path, 1, &all, settings, n_settings, err) : NULL;
}

duet_scene *duet_scene_load_pairs(const char *path, duet_error *err)
{
    PUBLIC_CALL(err);
    scene_range all = {.end = UINT64_MAX};
    return error_given(path, __func__, "path", err) ? load(path, 2, &all, NULL, 0, err) : NULL;
}
