// SPDX-License-Identifier: MIT
#include "lua/cluster_library.h"

#include "base/error.h"
#include "runtime/duet.h"

#include <dlfcn.h>
#include <stddef.h>
#include <string.h>

#define CALL(member, name)                      \
    {                                           \
        name, offsetof(cluster_library, member) \
    }

static const struct {
    const char *name;
    size_t place;
} calls[] = {
    CALL(version, "duet_version"),
    CALL(default_def, "duet_default_cluster_def"),
    CALL(create, "duet_cluster_create"),
    CALL(destroy, "duet_cluster_destroy"),
    CALL(get_rank, "duet_cluster_get_rank"),
    CALL(get_rank_count, "duet_cluster_get_rank_count"),
    CALL(load_scene, "duet_cluster_load_scene"),
    CALL(get_scene_info, "duet_cluster_get_scene_info"),
    CALL(set_objects, "duet_cluster_set_objects"),
    CALL(map_homes, "duet_cluster_map_homes"),
    CALL(set_plan, "duet_cluster_set_plan"),
    CALL(load_profile, "duet_cluster_load_profile"),
    CALL(set_level, "duet_cluster_set_level"),
    CALL(step, "duet_cluster_step"),
    CALL(get_own_pairs, "duet_cluster_get_own_pairs"),
    CALL(get_ranks, "duet_cluster_get_ranks"),
    CALL(save_pairs, "duet_cluster_save_pairs"),
};

_Static_assert(sizeof(cluster_library) == sizeof calls / sizeof *calls * sizeof(void *),
               "a name for each call");

// All of them, or the name of the first that is not there.
static const char *find_calls(void *library, cluster_library *found)
{
    for (size_t i = 0; i < sizeof calls / sizeof *calls; ++i) {
        void *call = dlsym(library, calls[i].name);
        if (!call)
            return calls[i].name;
        memcpy((char *)found + calls[i].place, &call, sizeof call);
    }
    return NULL;
}

// It stays until the process ends, for MPI may have threads in it. Its own calls bind to itself
// (module.cmake), so that two copies of Duet never share a function.
const cluster_library *cluster_library_load(duet_error *err)
{
    static cluster_library known;
    cluster_library found;
    if (known.version)
        return &known;
    void *library = dlopen(CLUSTER_LIBRARY, RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
    if (!library) {
        error_set(err, DUET_STATUS_NOT_FOUND,
                  "%s; on Debian it is in the package duet-cluster, and a Duet that was built "
                  "without MPI has none",
                  dlerror());
        return NULL;
    }
    const char *lacking = find_calls(library, &found);
    if (lacking || strcmp(found.version(), duet_version()) != 0) {
        error_set(err, DUET_STATUS_NOT_FOUND, "%s is of another version%s%s; expected %s",
                  CLUSTER_LIBRARY, lacking ? ", without " : " of Duet, ",
                  lacking ? lacking : found.version(), duet_version());
        return NULL;
    }
    known = found;
    return &known;
}
