// SPDX-License-Identifier: MIT
#include "cli/vtk/vtk_bodies.h"

#include "base/error.h"
#include "cli/vtk/vtk_file.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

// A body, as its cell's data have it.
typedef struct row {
    uint32_t place;
    uint8_t asleep;
    int64_t id;
    float velocity[3];
    float angular_velocity[3];
    float half_extents[3];
    float radius;
    float orientation[4]; // w first, as VTK's glyphs take a quaternion
} row;

typedef struct grid {
    const body_states *bodies;
    const solid *solids;
    uint32_t dims;
    row *rows;         // [n]
    uint64_t n;        // bodies that are there
    uint64_t n_points; // all cells have
    uint64_t n_words;  // the faces of all polyhedra have
} grid;

static const solid *solid_of(const grid *g, uint64_t i)
{
    return &g->solids[solid_kind(&g->bodies->boxes[g->rows[i].place], g->dims)];
}

// How many faces a polyhedron has, then each.
static uint64_t words_of(const solid *s)
{
    return s->n_faces > 0 ? 1 + s->n_words : 0;
}

static row row_of(const body_states *b, uint32_t place)
{
    const duet_state *state = &b->states[place];
    const duet_rounded_box *box = &b->boxes[place];
    row r = {.place = place,
             .asleep = b->asleep[place],
             .id = (int64_t)b->ids[place],
             .radius = box->radius};
    for (int k = 0; k < 3; ++k) {
        r.velocity[k] = (float)state->velocity[k];
        r.angular_velocity[k] = (float)state->angular_velocity[k];
        r.half_extents[k] = box->pose.half_extents[k];
    }
    for (int k = 0; k < 4; ++k)
        r.orientation[k] = (float)state->rotation[(k + 3) % 4];
    return r;
}

static bool make_rows(grid *g, duet_error *err)
{
    g->rows = calloc((size_t)g->bodies->n + 1, sizeof *g->rows);
    if (!g->rows)
        return no_memory(err, "a frame of %" PRIu32 " objects", g->bodies->n);
    for (uint32_t place = 0; place < g->bodies->n; ++place) {
        if (!body_states_has(g->bodies, place))
            continue;
        g->rows[g->n] = row_of(g->bodies, place);
        const solid *s = solid_of(g, g->n++);
        g->n_points += s->n_points;
        g->n_words += words_of(s);
    }
    return true;
}

// ---------------------------------------------------------------- cells

static void write_points(FILE *to, const void *of)
{
    const grid *g = of;
    double at[SOLID_POINTS][3];
    for (uint64_t i = 0; i < g->n; ++i) {
        const solid *s = solid_of(g, i);
        uint32_t place = g->rows[i].place;
        solid_place(s, &g->bodies->boxes[place], &g->bodies->states[place], at);
        fwrite(at, sizeof *at, s->n_points, to);
    }
}

static void write_offsets(FILE *to, const void *of)
{
    const grid *g = of;
    int64_t end = 0;
    for (uint64_t i = 0; i < g->n; ++i)
        vtk_write_int64(to, end += solid_of(g, i)->n_points);
}

static void write_types(FILE *to, const void *of)
{
    const grid *g = of;
    for (uint64_t i = 0; i < g->n; ++i)
        putc(solid_of(g, i)->cell, to);
}

// The words of a polyhedron whose points begin at `first`.
static void write_polyhedron(FILE *to, const solid *s, int64_t first)
{
    vtk_write_int64(to, s->n_faces);
    for (uint32_t at = 0; at < s->n_words; at += s->words[at] + 1u) {
        vtk_write_int64(to, s->words[at]);
        for (uint32_t i = 1; i <= s->words[at]; ++i)
            vtk_write_int64(to, first + s->words[at + i]);
    }
}

static void write_faces(FILE *to, const void *of)
{
    const grid *g = of;
    int64_t first = 0;
    for (uint64_t i = 0; i < g->n; ++i) {
        const solid *s = solid_of(g, i);
        if (s->n_faces > 0)
            write_polyhedron(to, s, first);
        first += s->n_points;
    }
}

// Ends of the cells' faces; -1: a cell has none.
static void write_face_offsets(FILE *to, const void *of)
{
    const grid *g = of;
    int64_t end = 0;
    for (uint64_t i = 0; i < g->n; ++i) {
        uint64_t words = words_of(solid_of(g, i));
        end += (int64_t)words;
        vtk_write_int64(to, words > 0 ? end : -1);
    }
}

// ---------------------------------------------------------------- the file

#define DATA(member, type, components, labels)                                 \
    {                                                                          \
        "CellData", #member, type, components, labels, g->n, &g->rows->member, \
            .stride = sizeof *g->rows                                          \
    }
#define MADE(section, name, type, components, count, by)         \
    {                                                            \
        section, name, type, components, .n = count, .write = by \
    }

enum { ARRAYS = 13 };

// Bodies share no points, so that a cell's follow those of the one before it.
static void list_arrays(const grid *g, vtk_array arrays[ARRAYS])
{
    const vtk_array all[ARRAYS] = {
        DATA(id, VTK_INT64, 1, NULL),
        DATA(velocity, VTK_FLOAT32, 3, "x y z"),
        DATA(angular_velocity, VTK_FLOAT32, 3, "x y z"),
        DATA(asleep, VTK_UINT8, 1, NULL),
        DATA(half_extents, VTK_FLOAT32, 3, "x y z"),
        DATA(radius, VTK_FLOAT32, 1, NULL),
        DATA(orientation, VTK_FLOAT32, 4, "w x y z"),
        MADE("Points", "points", VTK_FLOAT64, 3, g->n_points, write_points),
        {"Cells", "connectivity", VTK_INT64, 1, .n = g->n_points, .step = 1},
        MADE("Cells", "offsets", VTK_INT64, 1, g->n, write_offsets),
        MADE("Cells", "types", VTK_UINT8, 1, g->n, write_types),
        MADE("Cells", "faces", VTK_INT64, 1, g->n_words, write_faces), // if there are polyhedra
        MADE("Cells", "faceoffsets", VTK_INT64, 1, g->n, write_face_offsets),
    };
    memcpy(arrays, all, sizeof all);
}

static bool write_grid(const char *path, const grid *g, double time, duet_error *err)
{
    vtk_array arrays[ARRAYS];
    list_arrays(g, arrays);
    const vtk_piece piece = {"UnstructuredGrid",
                             g->n_points,
                             "Cells",
                             g->n,
                             time,
                             arrays,
                             g->n_words > 0 ? ARRAYS : ARRAYS - 2,
                             g};
    return vtk_file_write(path, &piece, err);
}

bool vtk_bodies_write(const char *path, const body_states *bodies, const solid solids[SOLID_KINDS],
                      uint32_t dims, double time, duet_error *err)
{
    grid g = {.bodies = bodies, .solids = solids, .dims = dims};
    bool ok = make_rows(&g, err) && write_grid(path, &g, time, err);
    free(g.rows);
    return ok;
}

bool vtk_bodies_write_parallel(const char *path, const char *stem, uint32_t n, double time,
                               duet_error *err)
{
    row none = {0};
    const grid g = {.rows = &none};
    vtk_array arrays[ARRAYS];
    list_arrays(&g, arrays);
    const vtk_piece piece = {
        .kind = "UnstructuredGrid", .time = time, .arrays = arrays, .n = ARRAYS, .of = &g};
    return vtk_file_write_parallel(path, &piece, stem, n, err);
}
