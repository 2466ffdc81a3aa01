// SPDX-License-Identifier: MIT
#include "cli/vtk/vtk_ground.h"

#include "base/text.h"
#include "cli/vtk/vtk_file.h"

#include <inttypes.h>

static void write_points(FILE *to, const void *of)
{
    const duet_heights *h = of;
    for (uint32_t j = 0; j < h->ny; ++j)
        for (uint32_t i = 0; i < h->nx; ++i) {
            const double at[3] = {h->origin[0] + i * h->spacing[0],
                                  h->origin[1] + j * h->spacing[1],
                                  h->origin[2] + (double)h->heights[(size_t)j * h->nx + i]};
            fwrite(at, sizeof at, 1, to);
        }
}

// c a d b ...: the triangles c a d and a b d of a cell follow each other
// (kernels/dynamics/ground.clh).
static void write_connectivity(FILE *to, const void *of)
{
    const duet_heights *h = of;
    for (uint32_t j = 0; j + 1 < h->ny; ++j)
        for (uint32_t i = 0; i < h->nx; ++i) {
            vtk_write_int64(to, (int64_t)(j + 1) * h->nx + i);
            vtk_write_int64(to, (int64_t)j * h->nx + i);
        }
}

static void write_offsets(FILE *to, const void *of)
{
    const duet_heights *h = of;
    for (uint32_t j = 1; j < h->ny; ++j)
        vtk_write_int64(to, 2 * (int64_t)j * h->nx);
}

static bool write_file(const char *path, const duet_heights *h, double time, duet_error *err)
{
    const uint64_t points = (uint64_t)h->nx * h->ny, strips = h->ny - 1;
    const vtk_array arrays[] = {
        {"Points", "points", VTK_FLOAT64, 3, NULL, points, NULL, 0, write_points},
        {"Strips", "connectivity", VTK_INT64, 1, NULL, 2 * strips * h->nx, NULL, 0,
         write_connectivity},
        {"Strips", "offsets", VTK_INT64, 1, NULL, strips, NULL, 0, write_offsets},
    };
    char counts[96];
    snprintf(counts, sizeof counts, "NumberOfPoints=\"%" PRIu64 "\" NumberOfStrips=\"%" PRIu64 "\"",
             points, strips);
    const vtk_piece piece = {"PolyData", counts, time, arrays, sizeof arrays / sizeof *arrays, h};
    return vtk_file_write(path, &piece, err);
}

bool vtk_ground_write(const char *folder, const duet_heights *h, double time, duet_error *err)
{
    text path = {0};
    if (!h)
        return true;
    text_add(&path, "%s/ground.vtp", folder);
    bool ok = text_ok(&path, err) && write_file(text_chars(&path), h, time, err);
    text_free(&path);
    return ok;
}
