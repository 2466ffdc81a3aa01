// SPDX-License-Identifier: MIT
// duet picture, as a person calls it.
#include "support/program.h"
#include "support/test.h"

#include "base/text_file.h"

#define SCENE "test_picture.txt"
#define SVG "test_picture.svg"
#define PNG "test_picture.png"

// Colours as the SVG names them: of boxes that collide, and of those that do not.
static const char colliding[] = "fill:rgb(97%,62%,26%)";
static const char alone[] = "fill:rgb(66%,76%,88%)";

static void write_scene(const char *content)
{
    test_write_file(SCENE, content);
}

// Cairo 1.16 writes style="fill:rgb(1%,2%,3%)", Cairo 1.18 fill="rgb(1%, 2%, 3%)": both
// as fill:rgb(1%,2%,3%).
static void tell_alike(text *svg)
{
    size_t to = 0;
    for (size_t at = 0; at < svg->length; ++at) {
        bool equals = svg->chars[at] == '=' && svg->chars[at + 1] == '"';
        if (svg->chars[at] != ' ')
            svg->chars[to++] = equals ? ':' : svg->chars[at];
        at += equals;
    }
    svg->chars[to] = '\0';
    svg->length = to;
}

static text draw(const char *path, const char *options)
{
    text t = {0};
    program p = program_run("picture %s -o %s %s", SCENE, path, options);
    bool quiet = !*p.err || strstr(p.err, "test_picture: there are no objects\n");
    if (p.exit_code != 0 || !quiet || *p.out)
        fail_msg("picture %s: %s%s", options, p.out, p.err);
    must(text_read_file(&t, path, ERR));
    if (strcmp(path, SVG) == 0)
        tell_alike(&t);
    return t;
}

static int count(const text *svg, const char *fill)
{
    int n = 0;
    for (const char *at = svg->chars; (at = strstr(at, fill)); ++at)
        ++n;
    return n;
}

TEST(boxes_that_collide_are_filled_in_their_own_colour)
{
    write_scene("0 0 1 1\n0.5 0.5 1.5 1.5\n3 3 4 4\n5 3 6 4\n6 4 7 5\n9 9 9.5 9.5\n");
    own(text) svg = draw(SVG, "");
    assert_int_equal(count(&svg, colliding), 4);
    assert_int_equal(count(&svg, alone), 2);
}

TEST(of_a_box_in_3d_three_faces_are_seen)
{
    write_scene("0 0 0 1 1 1\n5 5 5 6 6 6\n");
    own(text) svg = draw(SVG, "");
    int faces = 0;
    for (const char *at = svg.chars; (at = strstr(at, "fill-opacity:0.62")); ++at)
        ++faces;
    assert_int_equal(faces, 6);
}

// A disc is a polygon of its fill; its bounds are those of the disc.
TEST(what_has_a_radius_is_round)
{
    write_scene("0 0 0 0 0 1 0.5\n3 0 1 0.2 0 1 0.3\n");
    own(text) svg = draw(SVG, "");
    assert_int_equal(count(&svg, alone), 2);
    const char *path = strstr(svg.chars, alone);
    assert_non_null(path);
    int corners = 0;
    for (const char *at = path; *at && *at != '>'; ++at)
        corners += *at == 'L';
    assert_true(corners >= 60);
}

TEST(a_sample_has_as_many_boxes_as_asked)
{
    own(text) boxes = {0};
    for (int i = 0; i < 50; ++i)
        text_add(&boxes, "%d 0 %d.5 1\n", i, i);
    write_scene(text_chars(&boxes));
    own(text) svg = draw(SVG, "--boxes 7");
    assert_int_equal(count(&svg, alone), 7);
}

// A box of edge 1 fills 860 pixels: a tenth of it is the greatest bar below 140.
TEST(a_bar_shows_the_scale)
{
    write_scene("0 0 1 1\n");
    own(text) svg = draw(SVG, "");
    assert_says(svg.chars, "M24908L110908");
}

TEST(a_png_has_the_asked_width)
{
    write_scene("0 0 1 1\n");
    own(text) png = draw(PNG, "--width 300");
    assert_true(png.length > 24);
    assert_memory_equal(png.chars, "\x89PNG\r\n", 6);
    assert_memory_equal(png.chars + 16, "\0\0\x01\x2c", 4);
}

TEST(extreme_scenes_are_drawn)
{
    static const char *const scenes[] = {
        "",
        "1 1 1 1\n",
        "0 0 0 0 0 0\n0 0 0 0 0 0\n",
        "-3e38 -3e38 3e38 3e38\n0 0 1 1\n",
        "0 0 0 1e-30 1e-30 1e-30\n1e30 0 0 1e30 1 1\n",
    };
    for (size_t i = 0; i < sizeof scenes / sizeof scenes[0]; ++i) {
        write_scene(scenes[i]);
        own(text) svg = draw(SVG, "");
        assert_says(svg.chars, "</svg>");
        if (strstr(svg.chars, "nan") || strstr(svg.chars, "inf"))
            fail_msg("a place of scene %zu is no number", i);
    }
}

TEST(what_cannot_be_drawn_is_one_line)
{
    write_scene("0 0 1 1\n");
    program_assert_refused(program_run("picture %s", SCENE), 2, "-o is missing");
    program_assert_refused(program_run("picture %s -o scene.jpg", SCENE), 2,
                           "'scene.jpg': a picture's name ends with .svg or .png");
    program_assert_refused(program_run("picture no/such.lua -o %s", SVG), 1, "no/such.lua");
    program_assert_refused(program_run("picture %s -o no/such/folder.svg", SCENE), 1,
                           "no/such/folder.svg");
}
