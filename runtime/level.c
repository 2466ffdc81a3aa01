// SPDX-License-Identifier: MIT
#include "runtime/level.h"

#include "runtime/meeting.h"
#include "runtime/narrow.h"

#include <math.h>
#include <string.h>

#define SLACK (NARROW_SLACK * 0x1p-24f)
// What the textbook adds to each cosine, lest nearly parallel edges separate.
#define TEXTBOOK_EPSILON 1e-6f

typedef bool (*level_test)(const duet_pose *a, const duet_pose *b, uint32_t dims);

static bool all_collide(const duet_pose *a, const duet_pose *b, uint32_t dims)
{
    (void)a, (void)b, (void)dims;
    return true;
}

static bool test_faces(const duet_pose *a, const duet_pose *b, uint32_t dims)
{
    meeting m = meeting_of(a, b, dims);
    return !(m.trusted && meeting_face_gap(&m) > SLACK * m.size);
}

static bool test_as_the_textbook(const duet_pose *a, const duet_pose *b, uint32_t dims)
{
    meeting m = meeting_of(a, b, dims);
    for (uint32_t i = 0; i < dims; ++i)
        for (uint32_t j = 0; j < dims; ++j)
            m.size_c[i][j] += TEXTBOOK_EPSILON;
    float gap = meeting_face_gap(&m);
    for (int i = 0; dims == 3 && i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            gap = fmaxf(gap, meeting_edge_gap(&m, i, j));
    return !(m.trusted && gap > 0);
}

static bool test_in_double(const duet_pose *a, const duet_pose *b, uint32_t dims)
{
    return !(narrow_gap(a, b, dims) > 0);
}

#define SLACK_IN_DOUBLE (NARROW_SLACK * 0x1p-53)

static const struct {
    level_info info;
    level_test test;
} levels[LEVEL_COUNT] = {
    [LEVEL_CERTIFIED] = {{"certified", "float with an error bound, then double, then integers", 0,
                          0},
                         narrow_decide},
    [LEVEL_AABB] = {{"aabb", "bounds, in float", 0, INFINITY}, all_collide},
    [LEVEL_SPHERE] = {{"sphere", "bounding spheres, in float", 0, INFINITY}, meeting_spheres},
    [LEVEL_SAT6] = {{"sat6", "axes of faces, in float with an error bound", 0, INFINITY},
                    test_faces},
    [LEVEL_SAT15] = {{"sat15", "15 axes in float, with 1e-6 added to cosines", SLACK,
                      SLACK + TEXTBOOK_EPSILON},
                     test_as_the_textbook},
    [LEVEL_DOUBLE] = {{"double", "15 axes in double", SLACK_IN_DOUBLE, SLACK_IN_DOUBLE},
                      test_in_double},
};

const level_info *level_describe(level l)
{
    return &levels[l].info;
}

level level_named(const char *name)
{
    int l = 0;
    while (l < LEVEL_COUNT && strcmp(levels[l].info.name, name) != 0)
        ++l;
    return (level)l;
}

static bool is_exact_when_upright(level l)
{
    return l != LEVEL_AABB && l != LEVEL_SPHERE;
}

bool level_collide(level l, const duet_pose *a, const duet_pose *b, uint32_t dims, bool rotated)
{
    duet_bounds bounds_a = meeting_bounds(a, dims, rotated);
    duet_bounds bounds_b = meeting_bounds(b, dims, rotated);
    if (!narrow_bounds(&bounds_a, &bounds_b, dims))
        return false;
    return !rotated && is_exact_when_upright(l) ? narrow_decide(a, b, dims)
                                                : levels[l].test(a, b, dims);
}
