// SPDX-License-Identifier: MIT
#include "cli/vtk/vtk_ground.h"

#include "base/text.h"
#include "cli/vtk/vtk_file.h"
#include "runtime/narrowphase/mesh.h"

static void write_places(FILE *to, const void *of)
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
static void write_strips(FILE *to, const void *of)
{
    const duet_heights *h = of;
    for (uint32_t j = 0; j + 1 < h->ny; ++j)
        for (uint32_t i = 0; i < h->nx; ++i) {
            vtk_write_int64(to, (int64_t)(j + 1) * h->nx + i);
            vtk_write_int64(to, (int64_t)j * h->nx + i);
        }
}

static bool write_heights(const char *path, const duet_heights *h, double time, duet_error *err)
{
    const uint64_t points = (uint64_t)h->nx * h->ny, strips = h->ny - 1;
    const int64_t strip = 2 * (int64_t)h->nx;
    const vtk_array arrays[] = {
        {"Points", "points", VTK_FLOAT64, 3, .n = points, .write = write_places},
        {"Strips", "connectivity", VTK_INT64, 1, .n = 2 * strips * h->nx, .write = write_strips},
        {"Strips", "offsets", VTK_INT64, 1, .n = strips, .first = strip, .step = strip},
    };
    const vtk_piece piece = {"PolyData", points, "Strips", strips, time, arrays, 3, h};
    return vtk_file_write(path, &piece, err);
}

// ---------------------------------------------------------------- a mesh

static void write_vertices(FILE *to, const void *of)
{
    const duet_mesh *m = of;
    for (uint32_t i = 0; i < m->n_vertices; ++i) {
        double at[3];
        mesh_place_vertex(m, i, at);
        fwrite(at, sizeof at, 1, to);
    }
}

static void write_corners(FILE *to, const void *of)
{
    const duet_mesh *m = of;
    for (uint64_t i = 0; i < 3 * (uint64_t)m->n_triangles; ++i)
        vtk_write_int64(to, m->triangles[i]);
}

static bool write_mesh(const char *path, const duet_mesh *m, double time, duet_error *err)
{
    const vtk_array arrays[] = {
        {"Points", "points", VTK_FLOAT64, 3, .n = m->n_vertices, .write = write_vertices},
        {"Polys", "connectivity", VTK_INT64, 1, .n = 3 * (uint64_t)m->n_triangles,
         .write = write_corners},
        {"Polys", "offsets", VTK_INT64, 1, .n = m->n_triangles, .first = 3, .step = 3},
    };
    const vtk_piece piece = {"PolyData", m->n_vertices, "Polys", m->n_triangles,
                             time,       arrays,        3,       m};
    return vtk_file_write(path, &piece, err);
}

// ---------------------------------------------------------------- both

bool vtk_ground_write(const char *path, const duet_motion_def *def, double time, duet_error *err)
{
    return def->mesh ? write_mesh(path, def->mesh, time, err)
                     : write_heights(path, def->heights, time, err);
}

bool vtk_ground_write_once(const char *folder, const duet_motion_def *def, double time,
                           duet_error *err)
{
    text path = {0};
    if (!def->heights && !def->mesh)
        return true;
    text_add(&path, "%s/ground.vtp", folder);
    bool ok = text_ok(&path, err) && vtk_ground_write(text_chars(&path), def, time, err);
    text_free(&path);
    return ok;
}
