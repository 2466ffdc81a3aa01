// SPDX-License-Identifier: MIT
#include "runtime/narrowphase/level.h"

#include "runtime/narrowphase/narrow.h"
#include "runtime/narrowphase/rounded.h"
#include "runtime/narrowphase/sat_frame.h"

#include <math.h>
#include <string.h>

#define SLACK (NARROW_SLACK * 0x1p-24f)
// The textbook adds this to each cosine, lest nearly parallel edges separate.
#define TEXTBOOK_EPSILON 1e-6f

typedef bool (*level_test)(const duet_pose *a, const duet_pose *b, const double shift[3],
                           uint32_t dims);

static bool all_collide(const duet_pose *a, const duet_pose *b, const double shift[3],
                        uint32_t dims)
{
    (void)a, (void)b, (void)shift, (void)dims;
    return true;
}

static bool test_faces(const duet_pose *a, const duet_pose *b, const double shift[3], uint32_t dims)
{
    sat_frame m = sat_frame_of(a, b, shift, dims);
    return !(m.trusted && sat_frame_face_separation(&m) > SLACK * m.size);
}

static bool test_as_the_textbook(const duet_pose *a, const duet_pose *b, const double shift[3],
                                 uint32_t dims)
{
    sat_frame m = sat_frame_of(a, b, shift, dims);
    for (uint32_t i = 0; i < dims; ++i)
        for (uint32_t j = 0; j < dims; ++j)
            m.size_c[i][j] += TEXTBOOK_EPSILON;
    float separation = sat_frame_face_separation(&m);
    for (int i = 0; dims == 3 && i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            separation = fmaxf(separation, sat_frame_edge_separation(&m, i, j));
    return !(m.trusted && separation > 0);
}

static bool test_in_double(const duet_pose *a, const duet_pose *b, const double shift[3],
                           uint32_t dims)
{
    return !(narrow_separation_apart(a, b, shift, dims) > 0);
}

#define SLACK_IN_DOUBLE (NARROW_SLACK * 0x1p-53)

static const struct {
    duet_level_info info;
    level_test test;
} levels[DUET_LEVELS] = {
    [DUET_LEVEL_CERTIFIED] = {{"certified", "float with an error bound, then double, then integers",
                               0, 0},
                              narrow_decide_apart},
    [DUET_LEVEL_AABB] = {{"aabb", "bounds, in float", 0, INFINITY}, all_collide},
    [DUET_LEVEL_SPHERE] = {{"sphere", "bounding spheres, in float", 0, INFINITY},
                           sat_spheres_overlap},
    [DUET_LEVEL_SAT6] = {{"sat6", "axes of faces, in float with an error bound", 0, INFINITY},
                         test_faces},
    [DUET_LEVEL_SAT15] = {{"sat15", "15 axes in float, with 1e-6 added to cosines", SLACK,
                           SLACK + TEXTBOOK_EPSILON},
                          test_as_the_textbook},
    [DUET_LEVEL_DOUBLE] = {{"double", "15 axes in double", SLACK_IN_DOUBLE, SLACK_IN_DOUBLE},
                           test_in_double},
};

const duet_level_info *duet_level_get_info(duet_level level)
{
    return level >= 0 && level < DUET_LEVELS ? &levels[level].info : NULL;
}

bool duet_level_from_name(const char *name, duet_level *level)
{
    for (int l = 0; name && level && l < DUET_LEVELS; ++l) {
        if (strcmp(levels[l].info.name, name) != 0)
            continue;
        *level = (duet_level)l;
        return true;
    }
    return false;
}

bool duet_level_covers(duet_level level, duet_level other)
{
    const duet_level_info *own = duet_level_get_info(level), *others = duet_level_get_info(other);
    return own && others && own->missed <= others->missed && own->added <= others->added;
}

bool level_tests_upright(duet_level level)
{
    return level == DUET_LEVEL_AABB || level == DUET_LEVEL_SPHERE;
}

// Whether a is above b along x; if that is equal along y, then z.
static bool is_above(const duet_pose *a, const duet_pose *b, const double shift[3], uint32_t dims)
{
    for (uint32_t k = 0; k < dims; ++k) {
        float way = (float)shift[k] + (b->centre[k] - a->centre[k]);
        if (way != 0.0f)
            return way < 0.0f;
    }
    return false;
}

// Float may see (a, b) other than (b, a): the lower box comes first, as in the kernels.
static bool test_in_order(level_test test, const duet_pose *a, const duet_pose *b,
                          const double shift[3], uint32_t dims)
{
    const double back[3] = {-shift[0], -shift[1], -shift[2]};
    return is_above(a, b, shift, dims) ? test(b, a, back, dims) : test(a, b, shift, dims);
}

bool level_collide(duet_level level, const duet_pose *a, const duet_pose *b, const double shift[3],
                   uint32_t dims, bool rotated)
{
    duet_bounds bounds_a = sat_bounds(a, dims, rotated);
    duet_bounds bounds_b = sat_bounds(b, dims, rotated);
    if (!sat_bounds_overlap(&bounds_a, &bounds_b, shift, dims))
        return false;
    return rotated || level_tests_upright(level)
               ? test_in_order(levels[level].test, a, b, shift, dims)
               : narrow_decide_apart(a, b, shift, dims);
}

bool level_collide_rounded(duet_level level, const duet_rounded_box *a, const duet_rounded_box *b,
                           uint32_t dims, bool rotated)
{
    duet_bounds bounds_a = sat_rounded_bounds(a, dims, rotated);
    duet_bounds bounds_b = sat_rounded_bounds(b, dims, rotated);
    if (!sat_bounds_overlap(&bounds_a, &bounds_b, narrow_here, dims))
        return false;
    return level == DUET_LEVEL_AABB ||
           (level == DUET_LEVEL_SPHERE ? sat_rounded_spheres_overlap(a, b, dims)
                                       : rounded_decide(a, b, dims));
}
