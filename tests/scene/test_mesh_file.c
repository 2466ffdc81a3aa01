// SPDX-License-Identifier: MIT
// Meshes from files and from scenes: what is read, and what is refused in one line.
#include "support/scene_file.h"
#include "support/test.h"

#include "base/text_file.h"
#include "runtime/scene/mesh_file.h"

static void put(const char *path, const char *bytes, size_t n)
{
    must(text_write_file(path, bytes, n, ERR));
}

static duet_mesh read_words(const char *path, const char *words, double scale)
{
    duet_mesh mesh;
    put(path, words, strlen(words));
    must(mesh_file_read(&mesh, path, scale, ERR));
    return mesh;
}

static void refuse_bytes(const char *path, const char *bytes, size_t n, const char *says)
{
    duet_mesh mesh;
    put(path, bytes, n);
    must_fail(mesh_file_read(&mesh, path, 1, ERR), DUET_STATUS_BAD_INPUT, says);
    mesh_file_free(&mesh);
}

static void refuse(const char *path, const char *words, const char *says)
{
    refuse_bytes(path, words, strlen(words), says);
}

static void assert_vertex(const duet_mesh *mesh, uint32_t i, float x, float y, float z)
{
    const float *v = mesh->vertices + 3 * i;
    if (!(v[0] == x && v[1] == y && v[2] == z))
        fail_msg("vertex %u is %g %g %g", i, (double)v[0], (double)v[1], (double)v[2]);
}

// ---------------------------------------------------------------- OBJ

static const char pyramid[] = "# a pyramid\r\n"
                              "o top\n"
                              "v -1 -1 0\nv 1 -1 0 1.0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvn 0 0 1\n"
                              "v 0 0 2\n\n"
                              "usemtl stone\ns off\n"
                              "f 4 3 2 1\n"
                              "f 1/1 2/1 -1/1\nf 2//1 3//1 5//1\nf 3/1/1 4/1/1 5/1/1\nf 4 1 5";

TEST(an_obj_has_faces_of_any_corners)
{
    duet_mesh mesh = read_words("pyramid.obj", pyramid, 0.5);
    static const uint32_t right[6][3] = {{3, 2, 1}, {3, 1, 0}, {0, 1, 4},
                                         {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
    assert_int_equal(mesh.n_vertices, 5);
    assert_int_equal(mesh.n_triangles, 6);
    assert_vertex(&mesh, 1, 0.5f, -0.5f, 0);
    assert_vertex(&mesh, 4, 0, 0, 1);
    assert_memory_equal(mesh.triangles, right, sizeof right);
    mesh_file_free(&mesh);
}

TEST(a_wrong_obj_is_refused_with_its_line)
{
    static const char *const cases[][2] = {
        {"v 1 2\n", "bad.obj: line 1: no place; expected three numbers"},
        {"v 1 2 3x\n", "line 1: no place"},
        {"v 1 2\n3\n", "line 1: no place"},
        {"v 0 0 0\nv nan 0 0\n", "line 2: a coordinate is not a number from -1e12 to 1e12"},
        {"v 0 0 0\n\nv 0 1e39 0\n", "line 3: a coordinate is not a number"},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\n", "line 4: a face of fewer than three corners"},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n",
         "line 4: a face has a vertex that is not above it"},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 0\n",
         "line 4: a face has a vertex that is not above it"},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -4\n", "line 4: a face has a vertex"},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99999999999999999999\n", "line 4: a face has a vertex"},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 x\n", "line 4: a face's corner is no number"},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 2\n", "line 4: two corners are less than 1e-9 apart"},
        {"v 0 0 0\nv 1 0 0\nv 3 0 0\nf 1 2 3\n", "line 4: the corners lie on a line"},
        {"v 0 0 0\nbox 3\n", "line 2: an unknown word; expected v, f"},
        {"", "bad.obj: no triangle; expected one or more"},
        {"v 0 0 0\n", "bad.obj: no triangle"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i)
        refuse("bad.obj", cases[i][0], cases[i][1]);
    refuse("mesh.ply", pyramid, "mesh.ply: no mesh; expected a file .stl or .obj");
}

// ---------------------------------------------------------------- STL

static const char facet[] = "solid of a name\n"
                            "  facet normal 0 0 1\n    outer loop\n      vertex 0 0 0\n"
                            "      vertex 2.5e-1 0 0\n      VERTEX 0 1 0\n    endloop\n  endfacet\n"
                            "endsolid of a name\n";

TEST(an_ascii_stl_has_facets)
{
    duet_mesh mesh = read_words("facet.STL", facet, 1);
    assert_int_equal(mesh.n_vertices, 3);
    assert_int_equal(mesh.n_triangles, 1);
    assert_vertex(&mesh, 1, 0.25f, 0, 0);
    mesh_file_free(&mesh);
}

TEST(a_wrong_ascii_stl_is_refused_with_its_line)
{
    static const char *const cases[][2] = {
        {"solid\nfacet normal 0 0 1\nvertex 0 0 0\n",
         "bad.stl: line 3: another word; expected outer loop"},
        {"solid\nfacet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\n",
         "line 6: another word; expected vertex"},
        {"solid\nfacet\nouter loop\nvertex 0 0 0\nvertex 1 0\n",
         "line 5: no place; expected three numbers"},
        {"solid\nfacet\nouter loop\nvertex 0 0 inf\n", "line 4: a coordinate is not a number"},
        {"solid\nfacet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 2 0 0\n",
         "line 6: the corners lie on a line"},
        {"solid\nfacet\nouter loop\n", "the file ends; expected vertex"},
        {"solid\nfacets\n", "line 2: another word; expected facet or endsolid"},
        {"solid\nendsolid\n", "bad.stl: no triangle"},
        {"v 0 0 0\n", "bad.stl: no STL of 8 bytes; expected 'solid', or 84 bytes and 50"},
        {"", "bad.stl: no STL of 0 bytes"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i)
        refuse("bad.stl", cases[i][0], cases[i][1]);
}

// A binary file of n triangles, each moved by one; its header may begin as one of ASCII does.
static size_t fill_binary(char *bytes, uint32_t n)
{
    memset(bytes, 0, 84 + 50 * (size_t)n);
    memcpy(bytes, "solid", 5);
    memcpy(bytes + 80, &n, sizeof n);
    for (uint32_t i = 0; i < n; ++i) {
        const float corners[9] = {(float)i, 0, 0, (float)i + 1, 0, 0, (float)i, 1, 0};
        memcpy(bytes + 84 + 50 * i + 12, corners, sizeof corners);
    }
    return 84 + 50 * (size_t)n;
}

TEST(a_binary_stl_is_told_by_its_length)
{
    char bytes[84 + 50 * 3];
    size_t n = fill_binary(bytes, 3);
    duet_mesh mesh;
    put("b.stl", bytes, n);
    must(mesh_file_read(&mesh, "b.stl", 2, ERR));
    assert_int_equal(mesh.n_triangles, 3);
    assert_vertex(&mesh, 7, 6, 0, 0);
    mesh_file_free(&mesh);
    const float wrong[] = {NAN, INFINITY, 1e13f};
    for (int i = 0; i < 3; ++i) {
        fill_binary(bytes, 3);
        memcpy(bytes + 84 + 50 + 12, &wrong[i], sizeof *wrong);
        refuse_bytes("b.stl", bytes, n, "b.stl: triangle 2: a coordinate is not a number");
    }
    fill_binary(bytes, 3);
    memcpy(bytes + 84 + 100 + 24, bytes + 84 + 100 + 12, 12);
    refuse_bytes("b.stl", bytes, n, "b.stl: triangle 3: two corners are less than 1e-9 apart");
    fill_binary(bytes, 3);
    refuse_bytes("b.stl", bytes, n - 1, "b.stl: no STL of 233 bytes");
    memset(bytes + 80, 0xFF, 4);
    refuse_bytes("b.stl", bytes, n, "b.stl: no STL of 234 bytes");
    fill_binary(bytes, 0);
    refuse_bytes("b.stl", bytes, 84, "b.stl: no triangle");
}

// ---------------------------------------------------------------- scenes

static const char begin[] =
    "add{centre = {0, 0, 1}, half_extents = {1, 1, 1}}\nreturn {dims = 3, mesh = ";

static duet_scene *scene_with(const char *mesh, duet_error *err)
{
    char chars[512];
    snprintf(chars, sizeof chars, "%s%s}", begin, mesh);
    return scene_from_text("meshed.lua", chars, err);
}

TEST(a_scene_has_a_mesh_of_lists_or_of_a_file)
{
    duet_scene *s =
        must(scene_with("{vertices = {0, 0, 0, 1, 0, 0, 0, 1, 0.5}, triangles = {0, 1, 2}, "
                        "origin = {0, 0, 9}}",
                        ERR));
    const duet_mesh *mesh = duet_scene_motion_def(s, NULL).mesh;
    assert_non_null(mesh);
    assert_true(mesh->n_vertices == 3 && mesh->n_triangles == 1 && mesh->origin[2] == 9);
    assert_vertex(mesh, 2, 0, 1, 0.5f);
    put("pyramid.obj", pyramid, strlen(pyramid));
    s = must(scene_with("{file = 'pyramid.obj', scale = 2}", ERR));
    mesh = duet_scene_motion_def(s, NULL).mesh;
    assert_int_equal(mesh->n_triangles, 6);
    assert_vertex(mesh, 4, 0, 0, 4);
}

TEST(a_scene_with_a_wrong_mesh_is_refused_in_a_line)
{
    static const char *const cases[][2] = {
        {"3", "mesh"},
        {"{}", "a mesh has a file and its scale, or vertices and triangles"},
        {"{file = 3}", "mesh: file is 3; expected the name of a file"},
        {"{file = '/etc/passwd.stl'}", "; expected the name of a file"},
        {"{file = '../x.stl'}", "; expected the name of a file"},
        {"{file = 'a/../../x.stl'}", "; expected the name of a file"},
        {"{file = 'none.stl'}", "none.stl: No such file"},
        {"{file = 'x.stl', scale = 0}", "mesh: scale is 0; expected a number above 0"},
        {"{file = 'x.stl', vertices = {}}", "mesh: vertices is a table; expected a list"},
        {"{vertex = {}}", "mesh has no field 'vertex'; its fields are file, scale"},
        {"{vertices = {1, 2}, triangles = {0, 1, 2}}",
         "mesh: vertices is a list of 2; expected a list of numbers, three a vertex"},
        {"{vertices = {1, 2, 3}, triangles = {0, 1}}",
         "mesh: triangles is a list of 2; expected a list"},
        {"{vertices = {1, 2, 'x'}, triangles = {0, 1, 2}}", "mesh: vertices must be numbers"},
        {"{vertices = {1, 2, 3}, triangles = {0, -1, 2}}", "mesh: triangles must be whole numbers"},
        {"{vertices = {1, 2, 3}, triangles = {0, 0.5, 2}}",
         "mesh: triangles must be whole numbers"},
        {"{vertices = {1, 2, 3}, triangles = {0, 0, 0}, origin = 3}",
         "mesh: origin is 3; expected three numbers"},
        {"{vertices = {1, 2, 3}, triangles = {0, 0, 0}, material = 16}",
         "mesh: material is 16; expected the number of one of"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i)
        must_fail(scene_with(cases[i][0], ERR), ANY_FAILURE, cases[i][1]);
}
