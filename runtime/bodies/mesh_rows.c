// SPDX-License-Identifier: MIT
#include "runtime/bodies/mesh_rows.h"

#include "base/error.h"
#include "kernels/dynamics/mesh_rows.h"
#include "runtime/narrowphase/mesh.h"

#include <stdlib.h>
#include <string.h>

_Static_assert(sizeof(mesh_node) == MESH_NODE * sizeof(uint32_t) &&
                   offsetof(mesh_node, skip) == MESH_SKIP * sizeof(uint32_t) &&
                   offsetof(mesh_node, triangle) == MESH_LEAF * sizeof(uint32_t) &&
                   MESH_NO_TRIANGLE == MESH_NONE,
               "a node is a row");

// ---------------------------------------------------------------- vertices at one place

typedef struct place {
    float at[3];
    uint32_t vertex;
} place;

static int compare_places(const void *left, const void *right)
{
    const place *p = left, *q = right;
    for (int k = 0; k < 3; ++k)
        if (p->at[k] != q->at[k])
            return p->at[k] < q->at[k] ? -1 : 1;
    return (p->vertex > q->vertex) - (p->vertex < q->vertex);
}

static bool is_one_place(const place *p, const place *q)
{
    return p->at[0] == q->at[0] && p->at[1] == q->at[1] && p->at[2] == q->at[2];
}

// Sets for each vertex the first of those at its place.
static bool find_first(const duet_mesh *mesh, uint32_t *first)
{
    place *places = malloc(mesh->n_vertices * sizeof *places);
    if (!places)
        return false;
    for (uint32_t i = 0; i < mesh->n_vertices; ++i) {
        memcpy(places[i].at, mesh_vertex(mesh, i), sizeof places[i].at);
        places[i].vertex = i;
    }
    qsort(places, mesh->n_vertices, sizeof *places, compare_places);
    for (uint32_t i = 0, begin = 0; i < mesh->n_vertices; ++i) {
        if (!is_one_place(&places[i], &places[begin]))
            begin = i;
        first[places[i].vertex] = places[begin].vertex;
    }
    free(places);
    return true;
}

// ---------------------------------------------------------------- triangles

// Adds corner k of triangle i to the ring of its vertex, of which one is any corner.
static void add_to_ring(uint32_t *triangles, uint32_t *one, uint32_t i, uint32_t k)
{
    uint32_t *row = triangles + (size_t)MESH_TRIANGLE * i, *any = &one[row[k]];
    uint32_t corner = 3 * i + k;
    if (*any == MESH_NONE) {
        *any = row[MESH_NEXT + k] = corner;
        return;
    }
    uint32_t *before = triangles + (size_t)MESH_TRIANGLE * (*any / 3) + MESH_NEXT + *any % 3;
    row[MESH_NEXT + k] = *before;
    *before = corner;
}

static void set_row(uint32_t *row, const duet_mesh *mesh, uint32_t i, const uint32_t *first)
{
    const uint32_t *t = mesh->triangles + 3 * (size_t)i;
    double normal[3];
    mesh_set_normal(mesh_vertex(mesh, t[0]), mesh_vertex(mesh, t[1]), mesh_vertex(mesh, t[2]),
                    normal);
    for (int k = 0; k < 3; ++k) {
        float along = (float)normal[k];
        row[k] = first[t[k]];
        memcpy(&row[MESH_NORMAL + k], &along, sizeof along);
    }
}

static bool make_triangles(mesh_rows *rows, const duet_mesh *mesh)
{
    uint32_t *first = malloc(2 * mesh->n_vertices * sizeof *first);
    rows->triangles = malloc((size_t)mesh->n_triangles * MESH_TRIANGLE * sizeof *rows->triangles);
    bool ok = first && rows->triangles && find_first(mesh, first);
    uint32_t *one = first + mesh->n_vertices;
    if (ok)
        memset(one, 0xFF, mesh->n_vertices * sizeof *one);
    for (uint32_t i = 0; ok && i < mesh->n_triangles; ++i) {
        set_row(rows->triangles + (size_t)MESH_TRIANGLE * i, mesh, i, first);
        for (uint32_t k = 0; k < 3; ++k)
            add_to_ring(rows->triangles, one, i, k);
    }
    free(first);
    return ok;
}

// ---------------------------------------------------------------- both

bool mesh_rows_make(mesh_rows *rows, const duet_mesh *mesh, duet_error *err)
{
    *rows = (mesh_rows){.n_triangles = mesh->n_triangles};
    rows->nodes = mesh_tree_make(mesh);
    return (rows->nodes && make_triangles(rows, mesh)) ||
           no_memory(err, "a mesh of %u triangles", mesh->n_triangles);
}

void mesh_rows_free(mesh_rows *rows)
{
    free(rows->triangles);
    free(rows->nodes);
    *rows = (mesh_rows){0};
}
