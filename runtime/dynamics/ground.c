// SPDX-License-Identifier: MIT
#include "runtime/dynamics/ground.h"

#include "base/error.h"

#include <stdlib.h>
#include <string.h>

static size_t bytes_of(const duet_heights *h)
{
    return (size_t)h->nx * h->ny * sizeof *h->heights;
}

static arg_real4 real4_of(bool doubles, double x, double y, double z, double w)
{
    return doubles ? (arg_real4){.d = {{x, y, z, w}}}
                   : (arg_real4){.f = {{(float)x, (float)y, (float)z, (float)w}}};
}

bool ground_copy(motion_ground *ground, duet_motion_def *def, duet_error *err)
{
    if (!def->heights) {
        ground->origin = real4_of(def->doubles, 1e30, 1e30, 1e30, 0.0);
        ground->spacing = real4_of(def->doubles, 1.0, 1.0, 1.0, 1.0);
        return true;
    }
    duet_heights h = *def->heights;
    ground->values = malloc(bytes_of(&h));
    if (!ground->values)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %u x %u heights", h.nx, h.ny);
    memcpy(ground->values, h.heights, bytes_of(&h));
    h.heights = ground->values;
    ground->heights = h;
    ground->origin = real4_of(def->doubles, h.origin[0], h.origin[1], h.origin[2], 0.0);
    ground->spacing =
        real4_of(def->doubles, h.spacing[0], h.spacing[1], 1.0 / h.spacing[0], 1.0 / h.spacing[1]);
    const duet_material *surface = &def->materials[h.material]; // [0] is not read
    ground->surface = (cl_float4){{surface->friction, surface->restitution, (float)h.material}};
    ground->size = (cl_int4){{(cl_int)h.nx, (cl_int)h.ny}};
    def->heights = &ground->heights;
    return true;
}

bool ground_send(motion_ground *ground, const device *d, duet_error *err)
{
    size_t bytes = bytes_of(&ground->heights);
    if (!buffer_reserve(&ground->buffer, d, bytes > 0 ? bytes : sizeof(float), err))
        return false;
    if (bytes == 0)
        return true;
    cl_int code = clEnqueueWriteBuffer(d->queue, ground->buffer.mem, CL_TRUE, 0, bytes,
                                       ground->values, 0, NULL, NULL);
    return code == CL_SUCCESS ||
           error_set_cl(err, code, "%s: sending %zu bytes of heights", d->info.selector, bytes);
}

void ground_close(motion_ground *ground)
{
    buffer_release(&ground->buffer);
    free(ground->values);
    *ground = (motion_ground){0};
}
