// SPDX-License-Identifier: MIT
#include "runtime/narrowphase/mesh.h"

#include "base/error.h"
#include "runtime/narrowphase/vector.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// Squares of coordinates and products of short edges are numbers in float then.
static const double farthest = 1e12, shortest = 1e-9;
static const double thinnest = 0x1p-20; // height over length

const char *mesh_vertex_fault(const float at[3])
{
    for (int k = 0; k < 3; ++k)
        if (!(fabs((double)at[k]) <= farthest))
            return "a coordinate is not a number from -1e12 to 1e12";
    return NULL;
}

static double square_between(const float a[3], const float b[3])
{
    double square = 0.0;
    for (int k = 0; k < 3; ++k)
        square += ((double)b[k] - (double)a[k]) * ((double)b[k] - (double)a[k]);
    return square;
}

// Sets the product of two edges.
static void set_product(const float a[3], const float b[3], const float c[3], double product[3])
{
    double u[3], v[3];
    for (int k = 0; k < 3; ++k) {
        u[k] = (double)b[k] - (double)a[k];
        v[k] = (double)c[k] - (double)a[k];
    }
    cross(product, u, v);
}

const char *mesh_triangle_fault(const float a[3], const float b[3], const float c[3])
{
    double ab = square_between(a, b), bc = square_between(b, c), ca = square_between(c, a);
    double product[3], least = fmin(ab, fmin(bc, ca)), most = fmax(ab, fmax(bc, ca));
    set_product(a, b, c, product);
    if (least < shortest * shortest)
        return "two corners are less than 1e-9 apart";
    if (!(sqrt(dot(product, product)) > thinnest * most))
        return "the corners lie on a line";
    return NULL;
}

void mesh_set_normal(const float a[3], const float b[3], const float c[3], double normal[3])
{
    set_product(a, b, c, normal);
    double length = sqrt(dot(normal, normal));
    for (int k = 0; k < 3; ++k)
        normal[k] /= length;
}

// ---------------------------------------------------------------- checks

static bool check_counts(const duet_mesh *m, duet_error *err)
{
    if (m->n_triangles == 0 || m->n_triangles > DUET_MOST_TRIANGLES ||
        m->n_vertices > 3 * DUET_MOST_TRIANGLES)
        return bad_argument(err,
                            "the mesh has %u vertices and %u triangles; expected 1 to %u "
                            "triangles, and at most 3 times as many vertices",
                            m->n_vertices, m->n_triangles, DUET_MOST_TRIANGLES);
    for (int k = 0; k < 3; ++k)
        if (!(fabs(m->origin[k]) <= 1e30))
            return bad_argument(err, "%c of the mesh's origin is %g; expected from -1e30 to 1e30",
                                "xyz"[k], m -> origin[k]);
    return true;
}

static bool check_triangle(const duet_mesh *m, uint32_t i, duet_error *err)
{
    const uint32_t *t = m->triangles + 3 * (size_t)i;
    for (int k = 0; k < 3; ++k)
        if (t[k] >= m->n_vertices)
            return bad_argument(
                err,
                "triangle %u of the mesh has the vertex %u; expected one of %u vertices, from 0 on",
                i, t[k], m->n_vertices);
    const char *fault =
        mesh_triangle_fault(mesh_vertex(m, t[0]), mesh_vertex(m, t[1]), mesh_vertex(m, t[2]));
    return !fault ||
           bad_argument(err, "triangle %u of the mesh: %s; expected a triangle with an area", i,
                        fault);
}

bool mesh_check(const duet_mesh *m, duet_error *err)
{
    if (!check_counts(m, err))
        return false;
    if (!m->vertices || !m->triangles)
        return bad_argument(err, "the mesh's %s are NULL", m->vertices ? "triangles" : "vertices");
    for (uint32_t i = 0; i < m->n_vertices; ++i) {
        const char *fault = mesh_vertex_fault(mesh_vertex(m, i));
        if (fault)
            return bad_argument(err, "vertex %u of the mesh: %s", i, fault);
    }
    for (uint32_t i = 0; i < m->n_triangles; ++i)
        if (!check_triangle(m, i, err))
            return false;
    return true;
}

// The least height of a triangle, over its longest edge.
static double height_of(const duet_mesh *m, uint32_t triangle)
{
    const uint32_t *t = m->triangles + 3 * (size_t)triangle;
    const float *a = mesh_vertex(m, t[0]), *b = mesh_vertex(m, t[1]), *c = mesh_vertex(m, t[2]);
    double product[3];
    set_product(a, b, c, product);
    return sqrt(dot(product, product) /
                fmax(square_between(a, b), fmax(square_between(b, c), square_between(c, a))));
}

bool mesh_check_places(const duet_mesh *m, duet_error *err)
{
    double least = INFINITY;
    for (uint32_t i = 0; i < m->n_triangles; ++i)
        least = fmin(least, height_of(m, i));
    for (int k = 0; k < 3; ++k)
        if (fabs(m->origin[k]) > 0x1p40 * least)
            return bad_argument(err,
                                "the mesh's origin is %g along %c; expected at most 2^40 times the "
                                "least height of its triangles, %g, for queries",
                                m->origin[k], "xyz"[k], least);
    return true;
}

void mesh_place_vertex(const duet_mesh *m, uint32_t vertex, double at[3])
{
    const float *v = mesh_vertex(m, vertex);
    for (int k = 0; k < 3; ++k)
        at[k] = m->origin[k] + (double)v[k];
}

void mesh_place(const duet_mesh *m, uint32_t triangle, uint32_t corner, double at[3])
{
    mesh_place_vertex(m, m->triangles[3 * (size_t)triangle + corner], at);
}

bool mesh_copy(duet_mesh *to, const duet_mesh *mesh, duet_error *err)
{
    const size_t vertex_bytes = mesh_vertex_bytes(mesh), triangle_bytes = mesh_triangle_bytes(mesh);
    float *vertices = malloc(vertex_bytes);
    uint32_t *triangles = malloc(triangle_bytes);
    if (!vertices || !triangles) {
        free(vertices);
        free(triangles);
        return no_memory(err, "a ground of %zu bytes", vertex_bytes + triangle_bytes);
    }
    *to = *mesh;
    to->vertices = memcpy(vertices, mesh->vertices, vertex_bytes);
    to->triangles = memcpy(triangles, mesh->triangles, triangle_bytes);
    return true;
}

bool mesh_carry(duet_mesh *to, const duet_mesh *mesh, const duet_state *carrier, duet_error *err)
{
    const double *q = carrier->rotation;
    float *vertices = malloc(mesh_vertex_bytes(mesh));
    if (!vertices)
        return no_memory(err, "a mesh of %u vertices", mesh->n_vertices);
    for (uint32_t i = 0; i < mesh->n_vertices; ++i) {
        double at[3], once[3], twice[3];
        mesh_place_vertex(mesh, i, at);
        cross(once, q, at);
        cross(twice, q, once);
        for (int k = 0; k < 3; ++k)
            vertices[3 * (size_t)i + k] = (float)(at[k] + 2.0 * (q[3] * once[k] + twice[k]));
    }
    *to = *mesh;
    to->vertices = vertices;
    to->carrier = 0;
    memcpy(to->origin, carrier->centre, sizeof to->origin);
    return true;
}

size_t mesh_vertex_bytes(const duet_mesh *mesh)
{
    return (size_t)mesh->n_vertices * 3 * sizeof *mesh->vertices;
}

size_t mesh_triangle_bytes(const duet_mesh *mesh)
{
    return (size_t)mesh->n_triangles * 3 * sizeof *mesh->triangles;
}
