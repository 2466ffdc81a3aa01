// SPDX-License-Identifier: MIT
// The ground of a saved motion, the last part of a file: origin, spacing and heights, or origin,
// vertices and triangles.
#include "runtime/commands/saved_motion.h"

#include "base/error.h"
#include "runtime/bodies/ground_def.h"
#include "runtime/narrowphase/heights.h"
#include "runtime/narrowphase/mesh.h"

#include <assert.h>
#include <string.h>

typedef struct saved_ground {
    double origin[3], spacing[2]; // a mesh has its carrier for the one, and 0
} saved_ground;

static_assert(sizeof(saved_ground) == 40, "no byte of a file is left to chance");

bool saved_ground_is_kept(const duet_motion *m)
{
    return ground_def_is_given(&m->def) && (m->effects & DUET_EFFECT_GROUND);
}

void saved_ground_count(const duet_motion *m, saved_head *h)
{
    if (!saved_ground_is_kept(m))
        return;
    const duet_heights *heights = m->def.heights;
    const duet_mesh *mesh = m->def.mesh;
    h->ground[0] = mesh ? mesh->n_vertices : heights->nx;
    h->ground[1] = mesh ? mesh->n_triangles : heights->ny;
    h->has_mesh = mesh != NULL;
}

// The arrays that a head says of; SIZE_MAX / 2 if no file is that long.
static size_t bytes_of_arrays(const saved_head *h)
{
    const duet_mesh mesh = {.n_vertices = h->ground[0], .n_triangles = h->ground[1]};
    const duet_heights heights = {.nx = h->ground[0], .ny = h->ground[1]};
    if (h->has_mesh)
        return mesh_vertex_bytes(&mesh) + mesh_triangle_bytes(&mesh);
    return (uint64_t)heights.nx * heights.ny > DUET_MOST_HEIGHTS ? SIZE_MAX / 2
                                                                 : heights_bytes(&heights);
}

size_t saved_ground_size(const saved_head *h)
{
    return h->ground[0] == 0 ? 0 : sizeof(saved_ground) + bytes_of_arrays(h);
}

// ---------------------------------------------------------------- writing

static void add_begin(text *file, const double origin[3], const double spacing[2])
{
    saved_ground s;
    memcpy(s.origin, origin, sizeof s.origin);
    memcpy(s.spacing, spacing, sizeof s.spacing);
    text_add_bytes(file, (const char *)&s, sizeof s);
}

static void add_mesh(const duet_mesh *mesh, text *file)
{
    add_begin(file, mesh->origin, (const double[2]){mesh->carrier, 0.0});
    text_add_bytes(file, (const char *)mesh->vertices, mesh_vertex_bytes(mesh));
    text_add_bytes(file, (const char *)mesh->triangles, mesh_triangle_bytes(mesh));
}

static void add_heights(const duet_heights *h, text *file)
{
    add_begin(file, h->origin, h->spacing);
    text_add_bytes(file, (const char *)h->heights, heights_bytes(h));
}

void saved_ground_add(const duet_motion *m, text *file)
{
    if (!saved_ground_is_kept(m))
        return;
    if (m->def.mesh)
        add_mesh(m->def.mesh, file);
    else
        add_heights(m->def.heights, file);
}

// ---------------------------------------------------------------- reading

static void see_heights(saved_ground_seen *seen, const saved_head *h, const saved_ground *s,
                        const void *arrays)
{
    duet_heights *heights = &seen->heights;
    *heights = (duet_heights){.nx = h->ground[0], .ny = h->ground[1], .heights = arrays};
    memcpy(heights->origin, s->origin, sizeof s->origin);
    memcpy(heights->spacing, s->spacing, sizeof s->spacing);
}

static void see_mesh(saved_ground_seen *seen, const saved_head *h, const saved_ground *s,
                     const char *arrays)
{
    duet_mesh *mesh = &seen->mesh;
    *mesh = (duet_mesh){
        .n_vertices = h->ground[0], .n_triangles = h->ground[1], .vertices = (const void *)arrays};
    mesh->triangles = (const void *)(arrays + mesh_vertex_bytes(mesh));
    memcpy(mesh->origin, s->origin, sizeof s->origin);
}

// A mesh goes on with the body that carried it.
static bool check_carrier(const duet_motion *copy, const saved_head *h, const saved_ground *s,
                          const char *path, duet_error *err)
{
    const double carrier = ground_def_carrier(&copy->def);
    return !h->has_mesh || s->spacing[0] == carrier ||
           bad_input(err,
                     "%s: carrier of the mesh: %.10g in the file, %.10g in the motion; expected a "
                     "motion saved of the same scene",
                     path, s->spacing[0], carrier);
}

bool saved_ground_see(duet_motion *copy, saved_ground_seen *seen, const saved_head *h,
                      const char *bytes, const char *path, duet_error *err)
{
    saved_ground s;
    if (h->ground[0] == 0)
        return true;
    memcpy(&s, bytes, sizeof s);
    if (!check_carrier(copy, h, &s, path, err))
        return false;
    if (h->has_mesh)
        see_mesh(seen, h, &s, bytes + sizeof s);
    else
        see_heights(seen, h, &s, bytes + sizeof s);
    seen->mesh.material = seen->heights.material = ground_def_material(&copy->def);
    seen->mesh.carrier = ground_def_carrier(&copy->def);
    copy->def.heights = h->has_mesh ? NULL : &seen->heights;
    copy->def.mesh = h->has_mesh ? &seen->mesh : NULL;
    return true;
}

bool saved_ground_take(duet_motion *copy, const saved_head *h, duet_error *err)
{
    return h->ground[0] == 0 || (ground_copy(&copy->ground, &copy->def, err) &&
                                 ground_send(&copy->ground, copy->device, err));
}
