// SPDX-License-Identifier: MIT
#include "runtime/narrowphase/mesh_tree.h"

#include "runtime/narrowphase/mesh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

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

// Puts a node of n leaves, then those under it, behind the n_nodes that are there.
static void put_node(mesh_node *nodes, uint32_t *n_nodes, const duet_mesh *mesh, const leaf *leaves,
                     uint32_t n)
{
    mesh_node *node = &nodes[(*n_nodes)++];
    if (n == 1) {
        set_bounds(mesh, leaves->triangle, node->bounds);
    } else {
        put_node(nodes, n_nodes, mesh, leaves, n / 2);
        uint32_t second = *n_nodes;
        put_node(nodes, n_nodes, mesh, leaves + n / 2, n - n / 2);
        memcpy(node->bounds, node[1].bounds, sizeof node->bounds);
        widen(node->bounds, nodes[second].bounds);
    }
    node->skip = *n_nodes;
    node->triangle = n == 1 ? leaves->triangle : MESH_NO_TRIANGLE;
}

mesh_node *mesh_tree_make(const duet_mesh *mesh)
{
    leaf *leaves = malloc(mesh->n_triangles * sizeof *leaves);
    mesh_node *nodes = malloc(mesh_tree_size(mesh) * sizeof *nodes);
    uint32_t n_nodes = 0;
    if (leaves && nodes) {
        sort_leaves(mesh, leaves);
        put_node(nodes, &n_nodes, mesh, leaves, mesh->n_triangles);
    } else {
        free(nodes);
        nodes = NULL;
    }
    free(leaves);
    return nodes;
}
