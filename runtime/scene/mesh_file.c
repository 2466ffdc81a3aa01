// SPDX-License-Identifier: MIT
#include "runtime/scene/mesh_file.h"

#include "base/budget.h"
#include "base/error.h"
#include "base/list.h"
#include "base/text.h"
#include "base/text_file.h"
#include "runtime/narrowphase/mesh.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

enum { LINES_AT_ONCE = 1 << 12 }; // between two looks at the budget

typedef struct reading {
    const char *path;
    const char *unit; // "line" or "triangle", which `number` counts from 1
    uint64_t number;
    const char *at; // the next character
    double scale;
    float *vertices;
    uint32_t *triangles;
    uint32_t n_vertices, n_triangles;
    duet_error *err;
} reading;

static bool refuse(const reading *r, const char *fault, const char *expected)
{
    return bad_input(r->err, "%s: %s %llu: %s; expected %s", r->path, r->unit,
                     (unsigned long long)r->number, fault, expected);
}

// ---------------------------------------------------------------- what was read

static bool add_vertex(reading *r, const double at[3])
{
    if (r->n_vertices == 3 * DUET_MOST_TRIANGLES)
        return refuse(r, "one more vertex", "at most 50331648");
    float *vertices = list_room(r->vertices, r->n_vertices, 3 * sizeof *vertices, r->err);
    if (!vertices)
        return false;
    r->vertices = vertices;
    float *to = r->vertices + 3 * (size_t)r->n_vertices++;
    for (int k = 0; k < 3; ++k)
        to[k] = (float)(r->scale * at[k]);
    const char *fault = mesh_vertex_fault(to);
    return !fault || refuse(r, fault, "finite coordinates");
}

static bool add_triangle(reading *r, const uint32_t corners[3])
{
    if (r->n_triangles == DUET_MOST_TRIANGLES)
        return refuse(r, "one more triangle", "at most 16777216");
    uint32_t *triangles = list_room(r->triangles, r->n_triangles, 3 * sizeof *triangles, r->err);
    if (!triangles)
        return false;
    r->triangles = triangles;
    const float *v = r->vertices;
    memcpy(r->triangles + 3 * (size_t)r->n_triangles++, corners, 3 * sizeof *corners);
    const char *fault = mesh_triangle_fault(v + 3 * (size_t)corners[0], v + 3 * (size_t)corners[1],
                                            v + 3 * (size_t)corners[2]);
    return !fault || refuse(r, fault, "a triangle with an area");
}

// The triangle of the last three vertices.
static bool add_last_three(reading *r)
{
    uint32_t n = r->n_vertices;
    return add_triangle(r, (const uint32_t[]){n - 3, n - 2, n - 1});
}

// ---------------------------------------------------------------- words of a line

static bool is_blank(char c)
{
    return c != '\n' && isspace((unsigned char)c);
}

static void skip_blanks(reading *r)
{
    while (is_blank(*r->at))
        ++r->at;
}

static bool at_end_of_line(reading *r)
{
    skip_blanks(r);
    return *r->at == '\0' || *r->at == '\n';
}

static void skip_line(reading *r)
{
    while (*r->at && *r->at != '\n')
        ++r->at;
}

// Passes over a word in any case of its letters, if that is the next.
static bool takes_word(reading *r, const char *word)
{
    size_t length = strlen(word);
    skip_blanks(r);
    if (strncasecmp(r->at, word, length) != 0 || isgraph((unsigned char)r->at[length]))
        return false;
    r->at += length;
    return true;
}

static bool take_number(reading *r, double *value)
{
    char *after = NULL;
    if (at_end_of_line(r))
        return false;
    *value = strtod(r->at, &after);
    bool ok = after > r->at && !isgraph((unsigned char)*after);
    r->at = after;
    return ok;
}

static bool take_place(reading *r, double at[3])
{
    return (take_number(r, &at[0]) && take_number(r, &at[1]) && take_number(r, &at[2])) ||
           refuse(r, "no place", "three numbers");
}

// Goes to the next line that is not empty; false at the end, or once the budget is spent.
static bool next_line(reading *r)
{
    while (at_end_of_line(r)) {
        if (*r->at == '\0')
            return false;
        ++r->at;
        if (++r->number % LINES_AT_ONCE == 0 && !budget_check(r->err))
            return false;
    }
    return true;
}

// ---------------------------------------------------------------- OBJ

// A vertex of a face, as 7, 7/1, 7//3 or 7/1/3, from 1 on or back from -1.
static bool take_index(reading *r, uint32_t *vertex)
{
    char *after = NULL;
    skip_blanks(r);
    long long given = strtoll(r->at, &after, 10);
    long long from_0 = given < 0 ? r->n_vertices + given : given - 1;
    if (after == r->at || (isgraph((unsigned char)*after) && *after != '/'))
        return refuse(r, "a face's corner is no number", "numbers of vertices");
    if (given == 0 || from_0 < 0 || from_0 >= r->n_vertices)
        return refuse(r, "a face has a vertex that is not above it",
                      "numbers from 1 on, or from -1");
    while (isgraph((unsigned char)*after))
        ++after;
    r->at = after;
    *vertex = (uint32_t)from_0;
    return true;
}

// A face of more corners is a fan of triangles.
static bool take_face(reading *r)
{
    uint32_t t[3], n = 0;
    for (; !at_end_of_line(r); ++n) {
        if (!take_index(r, &t[n < 2 ? n : 2]))
            return false;
        if (n >= 2 && !add_triangle(r, t))
            return false;
        if (n >= 2)
            t[1] = t[2];
    }
    return n >= 3 || refuse(r, "a face of fewer than three corners", "three or more");
}

static bool take_obj_line(reading *r)
{
    static const char *const others[] = {"vt", "vn", "vp",     "o",      "g",
                                         "s",  "l",  "usemtl", "mtllib", "p"};
    double at[3];
    if (takes_word(r, "v")) {
        if (!take_place(r, at) || !add_vertex(r, at))
            return false;
        skip_line(r); // weights and colours
        return true;
    }
    if (takes_word(r, "f"))
        return take_face(r);
    bool known = *r->at == '#';
    for (size_t i = 0; i < sizeof others / sizeof *others && !known; ++i)
        known = takes_word(r, others[i]);
    skip_line(r);
    return known || refuse(r, "an unknown word", "v, f or another word of OBJ");
}

static bool read_obj(reading *r)
{
    while (next_line(r))
        if (!take_obj_line(r))
            return false;
    return true;
}

// ---------------------------------------------------------------- STL

static bool take_words(reading *r, const char *const words[2], const char *expected)
{
    if (!next_line(r))
        return refuse(r, "the file ends", expected);
    return (takes_word(r, words[0]) && (!words[1] || takes_word(r, words[1]))) ||
           refuse(r, "another word", expected);
}

// facet normal x y z, outer loop, three times vertex x y z, endloop, endfacet. Normals are those of
// the corners.
static bool take_facet(reading *r)
{
    double at[3];
    if (!take_words(r, (const char *const[]){"facet", NULL}, "facet or endsolid"))
        return false;
    skip_line(r);
    if (!take_words(r, (const char *const[]){"outer", "loop"}, "outer loop"))
        return false;
    for (int k = 0; k < 3; ++k)
        if (!take_words(r, (const char *const[]){"vertex", NULL}, "vertex") || !take_place(r, at) ||
            !add_vertex(r, at))
            return false;
    return add_last_three(r) && take_words(r, (const char *const[]){"endloop", NULL}, "endloop") &&
           take_words(r, (const char *const[]){"endfacet", NULL}, "endfacet");
}

static bool read_ascii_stl(reading *r)
{
    while (next_line(r)) {
        if (takes_word(r, "solid") || takes_word(r, "endsolid"))
            skip_line(r);
        else if (!take_facet(r))
            return false;
    }
    return true;
}

enum { STL_COUNT = 80, STL_HEAD = 84, STL_TRIANGLE = 50 };

static uint32_t word_of(const char *bytes)
{
    const unsigned char *b = (const unsigned char *)bytes;
    return b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

static float float_of(const char *bytes)
{
    uint32_t word = word_of(bytes);
    float value;
    memcpy(&value, &word, sizeof value);
    return value;
}

static bool read_binary_stl(reading *r, uint32_t n)
{
    r->unit = "triangle";
    for (r->number = 1; r->number <= n; ++r->number) {
        const char *corners = r->at + STL_HEAD + (r->number - 1) * STL_TRIANGLE + 12;
        if (r->number % LINES_AT_ONCE == 0 && !budget_check(r->err))
            return false;
        for (int k = 0; k < 3; ++k) {
            double at[3];
            for (int axis = 0; axis < 3; ++axis)
                at[axis] = (double)float_of(corners + 4 * (3 * k + axis));
            if (!add_vertex(r, at))
                return false;
        }
        if (!add_last_three(r))
            return false;
    }
    return true;
}

// A file is binary if it is as long as its count of triangles says; many such begin with "solid".
static bool read_stl(reading *r, const text *file)
{
    uint64_t n = file->length >= STL_HEAD ? word_of(file->chars + STL_COUNT) : 0;
    if (file->length >= STL_HEAD && file->length == STL_HEAD + n * STL_TRIANGLE)
        return read_binary_stl(r, (uint32_t)n);
    skip_blanks(r);
    if (strlen(file->chars) != file->length || strncasecmp(r->at, "solid", 5) != 0)
        return bad_input(
            r->err,
            "%s: no STL of %zu bytes; expected 'solid', or 84 bytes and 50 for each triangle",
            r->path, file->length);
    return read_ascii_stl(r);
}

// ---------------------------------------------------------------- files

static bool read_bytes(reading *r, const text *file)
{
    r->at = file->chars ? file->chars : "";
    bool ok = text_ends_with(r->path, ".stl") ? read_stl(r, file) : read_obj(r);
    return ok && budget_check(r->err) &&
           (r->n_triangles > 0 ||
            bad_input(r->err, "%s: no triangle; expected one or more", r->path));
}

bool mesh_file_read(duet_mesh *mesh, const char *path, double scale, duet_error *err)
{
    text file = {0};
    reading r = {.path = path, .unit = "line", .number = 1, .scale = scale, .err = err};
    *mesh = (duet_mesh){0};
    if (!text_ends_with(path, ".stl") && !text_ends_with(path, ".obj"))
        return bad_input(err, "%s: no mesh; expected a file .stl or .obj", path);
    bool ok = text_read_file(&file, path, err) && read_bytes(&r, &file);
    text_free(&file);
    mesh->n_vertices = r.n_vertices;
    mesh->n_triangles = r.n_triangles;
    mesh->vertices = r.vertices;
    mesh->triangles = r.triangles;
    return ok;
}

void mesh_file_free(duet_mesh *mesh)
{
    free((void *)mesh->vertices);
    free((void *)mesh->triangles);
    *mesh = (duet_mesh){0};
}
