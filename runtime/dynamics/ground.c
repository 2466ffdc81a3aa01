// SPDX-License-Identifier: MIT
#include "runtime/dynamics/ground.h"

#include "base/error.h"
#include "kernels/dynamics/mesh_rows.h"
#include "runtime/bodies/ground_def.h"
#include "runtime/bodies/mesh_rows.h"
#include "runtime/narrowphase/heights.h"
#include "runtime/narrowphase/mesh.h"

#include <stdlib.h>

static arg_real4 real4_of(bool doubles, double x, double y, double z, double w)
{
    return doubles ? (arg_real4){.d = {{x, y, z, w}}}
                   : (arg_real4){.f = {{(float)x, (float)y, (float)z, (float)w}}};
}

static arg_real4 origin_of(bool doubles, const double at[3])
{
    return real4_of(doubles, at[0], at[1], at[2], 0.0);
}

// ---------------------------------------------------------------- copies

static bool copy_heights(motion_ground *ground, const duet_motion_def *def, duet_error *err)
{
    const duet_heights *h = def->heights;
    ground->origin = origin_of(def->doubles, h->origin);
    ground->spacing = real4_of(def->doubles, h->spacing[0], h->spacing[1], 1.0 / h->spacing[0],
                               1.0 / h->spacing[1]);
    ground->size = (cl_int4){{(cl_int)h->nx, (cl_int)h->ny}};
    return heights_copy(&ground->heights, h, err);
}

static bool copy_mesh(motion_ground *ground, const duet_motion_def *def, duet_error *err)
{
    const duet_mesh *m = def->mesh;
    ground->carrier = m->carrier > 0 ? m->carrier - 1 : 0;
    ground->origin = origin_of(def->doubles, m->origin);
    return mesh_copy(&ground->mesh, m, err);
}

bool ground_copy(motion_ground *ground, duet_motion_def *def, duet_error *err)
{
    ground->spacing = real4_of(def->doubles, 1.0, 1.0, 1.0, 1.0);
    if (!ground_def_is_given(def)) {
        ground->origin = real4_of(def->doubles, 1e30, 1e30, 1e30, 0.0);
        return true;
    }
    uint32_t material = ground_def_material(def);
    const duet_material *surface = &def->materials[material]; // [0] is not read
    ground->surface = (cl_float4){{surface->friction, surface->restitution, (float)material}};
    if (!(def->mesh ? copy_mesh(ground, def, err) : copy_heights(ground, def, err)))
        return false;
    ground_show(ground, def);
    return true;
}

bool ground_is_there(const motion_ground *ground)
{
    return ground->heights.heights || ground->mesh.vertices;
}

void ground_show(const motion_ground *ground, duet_motion_def *def)
{
    def->heights = ground->heights.heights ? &ground->heights : NULL;
    def->mesh = ground->mesh.vertices ? &ground->mesh : NULL;
}

// ---------------------------------------------------------------- the device's

static bool send(buffer *b, const device *d, const void *from, size_t bytes, duet_error *err)
{
    if (!buffer_reserve(b, d, bytes > 0 ? bytes : sizeof(float), err))
        return false;
    if (bytes == 0)
        return true;
    cl_int code = clEnqueueWriteBuffer(d->queue, b->mem, CL_TRUE, 0, bytes, from, 0, NULL, NULL);
    return code == CL_SUCCESS ||
           error_set_cl(err, code, "%s: sending %zu bytes of a ground", d->info.selector, bytes);
}

// Only the device keeps the rows.
static bool send_mesh(motion_ground *g, const device *d, duet_error *err)
{
    mesh_rows r;
    bool ok =
        mesh_rows_make(&r, &g->mesh, err) &&
        send(&g->buffers[GROUND_VALUES], d, g->mesh.vertices, mesh_vertex_bytes(&g->mesh), err) &&
        send(&g->buffers[GROUND_TRIANGLES], d, r.triangles,
             (size_t)r.n_triangles * MESH_TRIANGLE * sizeof *r.triangles, err) &&
        send(&g->buffers[GROUND_NODES], d, r.nodes, mesh_tree_size(&g->mesh) * sizeof *r.nodes,
             err);
    mesh_rows_free(&r);
    return ok;
}

bool ground_send(motion_ground *g, const device *d, duet_error *err)
{
    return g->mesh.vertices ? send_mesh(g, d, err)
                            : send(&g->buffers[GROUND_VALUES], d, g->heights.heights,
                                   heights_bytes(&g->heights), err);
}

void ground_close(motion_ground *ground)
{
    for (int i = 0; i < GROUND_BUFFERS; ++i)
        buffer_release(&ground->buffers[i]);
    free((void *)ground->heights.heights);
    free((void *)ground->mesh.vertices);
    free((void *)ground->mesh.triangles);
    *ground = (motion_ground){0};
}
