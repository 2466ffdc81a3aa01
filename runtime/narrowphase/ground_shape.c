// SPDX-License-Identifier: MIT
#include "runtime/narrowphase/ground_shape.h"

#include "base/error.h"
#include "runtime/narrowphase/heights.h"
#include "runtime/narrowphase/mesh.h"
#include "runtime/narrowphase/mesh_meet.h"

#include <stdlib.h>

static bool copy_heights(ground_shape *ground, const duet_heights *h, duet_error *err)
{
    return heights_check_places(h, err) && heights_copy(&ground->heights, h, err);
}

static bool copy_mesh(ground_shape *ground, const duet_mesh *m, duet_error *err)
{
    if (!mesh_check_places(m, err) || !mesh_copy(&ground->mesh, m, err))
        return false;
    ground->tree = mesh_tree_make(m);
    return ground->tree || no_memory(err, "a ground of %u triangles", m->n_triangles);
}

bool ground_shape_copy(ground_shape *ground, const duet_heights *heights, const duet_mesh *mesh,
                       duet_error *err)
{
    *ground = (ground_shape){0};
    bool ok =
        (!heights || copy_heights(ground, heights, err)) && (!mesh || copy_mesh(ground, mesh, err));
    if (!ok)
        ground_shape_free(ground);
    return ok;
}

void ground_shape_free(ground_shape *ground)
{
    free((void *)ground->heights.heights);
    free((void *)ground->mesh.vertices);
    free((void *)ground->mesh.triangles);
    free(ground->tree);
    *ground = (ground_shape){0};
}

bool ground_shape_is_there(const ground_shape *ground)
{
    return ground->heights.heights || ground->tree;
}

bool ground_shape_meet(const ground_shape *ground, const ground_probe *probe, ground_entry *entry)
{
    return ground->tree ? mesh_meet(&ground->mesh, ground->tree, probe, entry)
                        : heights_meet(&ground->heights, probe, entry);
}

bool ground_shape_contain(const ground_shape *ground, const float at[3])
{
    const duet_ray still = {.origin = {at[0], at[1], at[2]}};
    const ground_probe probe = ground_probe_of_ray(&still);
    ground_entry entry;
    return ground_shape_meet(ground, &probe, &entry);
}

double ground_shape_distance(const ground_shape *ground, const float at[3])
{
    if (ground_shape_contain(ground, at))
        return 0.0;
    return ground->tree ? mesh_distance(&ground->mesh, ground->tree, at)
                        : heights_distance(&ground->heights, at);
}
