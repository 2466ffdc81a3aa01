// SPDX-License-Identifier: MIT
#define _POSIX_C_SOURCE 200809L
#include "runtime/opencl/pocl_cache.h"

#include "base/output.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static void add_folder(text *path)
{
    static const struct {
        const char *variable;
        const char *below;
    } places[] = {{"POCL_CACHE_DIR", ""},
                  {"XDG_CACHE_HOME", "/pocl/kcache"},
                  {"HOME", "/.cache/pocl/kcache"}};
    for (size_t i = 0; i < sizeof places / sizeof places[0]; ++i) {
        const char *value = getenv(places[i].variable);
        if (value && *value) {
            text_add(path, "%s%s", value, places[i].below);
            return;
        }
    }
    text_add(path, "/tmp/pocl/kcache");
}

static bool make_folder(const char *path)
{
    return output_make_folders(path, 0700, NULL) && (mkdir(path, 0700) == 0 || errno == EEXIST);
}

bool pocl_cache_check(duet_error *err)
{
    text path = {0};
    add_folder(&path);
    bool ok = text_ok(&path, err);
    if (ok && (!make_folder(path.chars) || access(path.chars, W_OK | X_OK) != 0))
        ok = error_set(err, DUET_STATUS_NO_DEVICE,
                       "PoCL lists no device, since its cache folder %s cannot be written: %s; set "
                       "POCL_CACHE_DIR to a folder that can be written",
                       path.chars, strerror(errno));
    text_free(&path);
    return ok;
}
