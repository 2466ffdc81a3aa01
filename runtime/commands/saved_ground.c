// SPDX-License-Identifier: MIT
// The ground of a saved motion: origin, spacing and heights, the last part of a file.
#include "runtime/commands/saved_motion.h"

#include <assert.h>
#include <string.h>

typedef struct saved_ground {
    double origin[3], spacing[2];
} saved_ground;

static_assert(sizeof(saved_ground) == 40, "no byte of a file is left to chance");

bool saved_ground_is_kept(const duet_motion *m)
{
    return m->def.heights && (m->effects & DUET_EFFECT_HEIGHTS);
}

static size_t bytes_of_heights(uint32_t nx, uint32_t ny)
{
    return (size_t)nx * ny * sizeof(float);
}

size_t saved_ground_size(const saved_head *h)
{
    if (h->nx == 0)
        return 0;
    return (uint64_t)h->nx * h->ny > DUET_MOST_HEIGHTS
               ? SIZE_MAX / 2 // no file is that long
               : sizeof(saved_ground) + bytes_of_heights(h->nx, h->ny);
}

void saved_ground_add(const duet_motion *m, text *file)
{
    if (!saved_ground_is_kept(m))
        return;
    const duet_heights *h = m->def.heights;
    saved_ground s;
    memcpy(s.origin, h->origin, sizeof s.origin);
    memcpy(s.spacing, h->spacing, sizeof s.spacing);
    text_add_bytes(file, (const char *)&s, sizeof s);
    text_add_bytes(file, (const char *)h->heights, bytes_of_heights(h->nx, h->ny));
}

void saved_ground_see(duet_motion *copy, const saved_head *h, const char *bytes)
{
    saved_ground s;
    if (h->nx == 0)
        return;
    memcpy(&s, bytes, sizeof s);
    duet_heights *seen = &copy->ground.heights;
    *seen = (duet_heights){.nx = h->nx,
                           .ny = h->ny,
                           .material = copy->def.heights->material,
                           .heights = (const float *)(const void *)(bytes + sizeof s)};
    memcpy(seen->origin, s.origin, sizeof s.origin);
    memcpy(seen->spacing, s.spacing, sizeof s.spacing);
    copy->def.heights = seen;
}

bool saved_ground_take(duet_motion *copy, const saved_head *h, duet_error *err)
{
    return h->nx == 0 || (ground_copy(&copy->ground, &copy->def, err) &&
                          ground_send(&copy->ground, copy->device, err));
}
