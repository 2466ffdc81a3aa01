// SPDX-License-Identifier: MIT
#include "runtime/bodies/mesh_rows.h"

#include "base/error.h"
#include "kernels/dynamics/mesh_rows.h"
#include "runtime/narrowphase/mesh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

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

// ---------------------------------------------------------------- tree

// Triangles in the order of their middles along a curve that fills space.
typedef struct leaf {
    uint64_t key;
    uint32_t triangle;
} leaf;

static int compare_leaves(const void *left, const void *right)
{
    const leaf *p = left, *q = right;
    if (p->key != q->key)
        return p->key < q->key ? -1 : 1;
    return (p->triangle > q->triangle) - (p->triangle < q->triangle);
}

static float corner_of(const duet_mesh *mesh, uint32_t triangle, int corner, int axis)
{
    return mesh_vertex(mesh, mesh->triangles[3 * (size_t)triangle + corner])[axis];
}

static void set_bounds(const duet_mesh *mesh, uint32_t triangle, float bounds[6])
{
    for (int k = 0; k < 3; ++k) {
        float a = corner_of(mesh, triangle, 0, k), b = corner_of(mesh, triangle, 1, k);
        float c = corner_of(mesh, triangle, 2, k);
        bounds[k] = fminf(a, fminf(b, c));
        bounds[3 + k] = fmaxf(a, fmaxf(b, c));
    }
}

static void widen(float bounds[6], const float more[6])
{
    for (int k = 0; k < 3; ++k) {
        bounds[k] = fminf(bounds[k], more[k]);
        bounds[3 + k] = fmaxf(bounds[3 + k], more[3 + k]);
    }
}

// Spreads the low 21 bits to every third bit.
static uint64_t spread(uint64_t x)
{
    x = (x | x << 32) & 0x1F00000000FFFF;
    x = (x | x << 16) & 0x1F0000FF0000FF;
    x = (x | x << 8) & 0x100F00F00F00F00F;
    x = (x | x << 4) & 0x10C30C30C30C30C3;
    return (x | x << 2) & 0x1249249249249249;
}

static uint64_t key_of(const float bounds[6], const float all[6])
{
    uint64_t key = 0;
    for (int k = 0; k < 3; ++k) {
        double middle = 0.5 * ((double)bounds[k] + (double)bounds[3 + k]) - (double)all[k];
        double size = (double)all[3 + k] - (double)all[k];
        key |= spread(size > 0.0 ? (uint64_t)(middle / size * 0x1FFFFF) : 0) << k;
    }
    return key;
}

static void sort_leaves(const duet_mesh *mesh, leaf *leaves)
{
    float all[6], bounds[6];
    set_bounds(mesh, 0, all);
    for (uint32_t i = 1; i < mesh->n_triangles; ++i) {
        set_bounds(mesh, i, bounds);
        widen(all, bounds);
    }
    for (uint32_t i = 0; i < mesh->n_triangles; ++i) {
        set_bounds(mesh, i, bounds);
        leaves[i] = (leaf){.key = key_of(bounds, all), .triangle = i};
    }
    qsort(leaves, mesh->n_triangles, sizeof *leaves, compare_leaves);
}

// Puts a node of n leaves, then those under it; sets its bounds.
static void put_node(mesh_rows *rows, const duet_mesh *mesh, const leaf *leaves, uint32_t n,
                     float bounds[6])
{
    uint32_t *node = rows->nodes + (size_t)MESH_NODE * rows->n_nodes++;
    float more[6];
    if (n == 1) {
        set_bounds(mesh, leaves->triangle, bounds);
    } else {
        put_node(rows, mesh, leaves, n / 2, bounds);
        put_node(rows, mesh, leaves + n / 2, n - n / 2, more);
        widen(bounds, more);
    }
    memcpy(node, bounds, 6 * sizeof *bounds);
    node[MESH_SKIP] = rows->n_nodes;
    node[MESH_LEAF] = n == 1 ? leaves->triangle : MESH_NONE;
}

static bool make_tree(mesh_rows *rows, const duet_mesh *mesh)
{
    float bounds[6];
    size_t most = 2 * (size_t)mesh->n_triangles - 1;
    leaf *leaves = malloc(mesh->n_triangles * sizeof *leaves);
    rows->nodes = malloc(most * MESH_NODE * sizeof *rows->nodes);
    bool ok = leaves && rows->nodes;
    if (ok) {
        sort_leaves(mesh, leaves);
        put_node(rows, mesh, leaves, mesh->n_triangles, bounds);
    }
    free(leaves);
    return ok;
}

// ---------------------------------------------------------------- both

bool mesh_rows_make(mesh_rows *rows, const duet_mesh *mesh, duet_error *err)
{
    *rows = (mesh_rows){.n_triangles = mesh->n_triangles};
    return (make_triangles(rows, mesh) && make_tree(rows, mesh)) ||
           error_set(err, DUET_STATUS_NO_MEMORY, "no memory for a mesh of %u triangles",
                     mesh->n_triangles);
}

void mesh_rows_free(mesh_rows *rows)
{
    free(rows->triangles);
    free(rows->nodes);
    *rows = (mesh_rows){0};
}
