// SPDX-License-Identifier: MIT
#include "cli/vtk/vtk_contacts.h"

#include "base/error.h"
#include "cli/vtk/vtk_file.h"

#include <inttypes.h>
#include <stdlib.h>

// A point at which a touches b.
typedef struct row {
    double at[3];
    int64_t a, b; // ids
    float normal[3];
    float separation;
    float force[3]; // on b
} row;

typedef struct touches {
    const body_states *bodies;
    double substep; // seconds, in which a contact's impulse acts
    row *rows;      // [n]
    uint64_t n;
} touches;

// Walls are -1, -2 ... in the order of their places behind the bodies.
static int64_t id_at(const body_states *b, uint32_t place)
{
    return place < b->n ? (int64_t)b->ids[place] : -1 - (int64_t)(place - b->n);
}

static row row_of(const touches *t, const duet_contact *c, uint32_t point)
{
    row r = {.a = id_at(t->bodies, c->a),
             .b = id_at(t->bodies, c->b),
             .separation = c->points[point].separation};
    double force = (double)c->points[point].normal_impulse / t->substep;
    for (int k = 0; k < 3; ++k) {
        r.at[k] = t->bodies->states[c->a].centre[k] + (double)c->points[point].anchor[k];
        r.normal[k] = c->normal[k];
        r.force[k] = (float)(force * (double)c->normal[k]);
    }
    return r;
}

static bool make_rows(touches *t, const duet_contact *contacts, uint64_t n, duet_error *err)
{
    uint64_t points = 0;
    for (uint64_t i = 0; i < n; ++i)
        points += contacts[i].n;
    t->rows = calloc(points + 1, sizeof *t->rows);
    if (!t->rows)
        return no_memory(err, "a frame of %" PRIu64 " contacts", n);
    for (uint64_t i = 0; i < n; ++i)
        for (uint32_t point = 0; point < contacts[i].n; ++point)
            t->rows[t->n++] = row_of(t, &contacts[i], point);
    return true;
}

// ---------------------------------------------------------------- the file

#define ROWS(section, name, member, type, components, labels)                                      \
    {                                                                                              \
        section, name, type, components, labels, t->n, &t->rows->member, .stride = sizeof *t->rows \
    }

static bool write_points(const char *path, const touches *t, bool pushes, double time,
                         duet_error *err)
{
    const vtk_array arrays[] = {
        ROWS("Points", "points", at, VTK_FLOAT64, 3, NULL),
        {"Verts", "connectivity", VTK_INT64, 1, .n = t->n, .step = 1},
        {"Verts", "offsets", VTK_INT64, 1, .n = t->n, .first = 1, .step = 1},
        ROWS("PointData", "a", a, VTK_INT64, 1, NULL),
        ROWS("PointData", "b", b, VTK_INT64, 1, NULL),
        ROWS("PointData", "normal", normal, VTK_FLOAT32, 3, "x y z"),
        ROWS("PointData", "separation", separation, VTK_FLOAT32, 1, NULL),
        ROWS("PointData", "force", force, VTK_FLOAT32, 3, "x y z"), // if contacts push
    };
    const uint32_t all = sizeof arrays / sizeof *arrays;
    const vtk_piece piece = {"PolyData", t->n, "Verts", t->n, time, arrays, pushes ? all : all - 1,
                             t};
    return vtk_file_write(path, &piece, err);
}

bool vtk_contacts_write(const char *path, duet_motion *motion, const body_states *bodies,
                        double time, duet_error *err)
{
    const duet_motion_def *def = duet_motion_get_def(motion);
    bool pushes = duet_motion_get_effects(motion) & DUET_EFFECT_CONTACT_RESPONSE;
    duet_contact *contacts = NULL;
    uint64_t n = 0;
    touches t = {.bodies = bodies, .substep = def->dt / def->substeps};
    bool ok = duet_motion_get_contacts(motion, &contacts, &n, err) &&
              make_rows(&t, contacts, n, err) && write_points(path, &t, pushes, time, err);
    duet_free(contacts);
    free(t.rows);
    return ok;
}
