// SPDX-License-Identifier: MIT
// Both lists are read off the kernels that were built, so that they cannot tell
// otherwise than what ran.
#include "runtime/broadphase/world_explain.h"

#include <stdio.h>
#include <string.h>

// ---------------------------------------------------------------- facts

static const struct {
    const char *name;
    const char *parameter;
    const char *means[6]; // by the parameter's value
} facts[] = {
    {"dimensions", "DIMS", {[2] = "z is left out", [3] = "x, y and z"}},
    {"objects",
     "SHAPE",
     {"poses: boxes are made of them and tested", "bounds: tests are left out",
      "rounded boxes: distances are tested against radii",
      "spheres: one distance is tested against radii"}},
    {"rotation",
     "ROTATED",
     {"none: rotations are not read, and bounds decide up to rounding",
      "some: axes of both boxes are tested"}},
    {"level",
     "ACCURACY",
     {"certified: float with a bound on its error, and the host for what is left",
      "aabb: bounds alone", "sphere: circumscribed spheres", "sat6: axes of the faces",
      "sat15: all axes in float", "double: all axes in double"}},
    {"grid", "GRID", {"dense: an entry for each cell", "hashed: mixed keys, compared cells"}},
    {"sizes", "LEVELS", {"alike: coarser cells are left out", "several: coarser cells are walked"}},
    {"capacity",
     "ROOMY",
     {"some axis has few cells: borders are looked after",
      "three cells or more an axis: borders are left out"}},
};

// False if the kernel's name does not say it.
static bool read_parameter(const kernel *k, const char *parameter, int64_t *value)
{
    char dotted[32];
    snprintf(dotted, sizeof dotted, ".%s", parameter);
    if (!k || !strstr(k->name, dotted))
        return false;
    *value = kernel_param(k, parameter);
    return true;
}

static bool decided(const part_kernels *k, const char *parameter, int64_t *value)
{
    const kernel *deciding[] = {k->hash, k->place, k->candidates, k->narrow};
    for (size_t i = 0; i < sizeof deciding / sizeof deciding[0]; ++i)
        if (read_parameter(deciding[i], parameter, value))
            return true;
    return false;
}

bool world_fact_at(const duet_world *world, int side, uint32_t i, world_fact *fact)
{
    if (!world_is_prepared(world, side))
        return false;
    const part_kernels *k = &world->parts[side].kernels;
    for (size_t row = 0; row < sizeof facts / sizeof facts[0]; ++row) {
        int64_t value = 0;
        if (!decided(k, facts[row].parameter, &value) || i-- > 0)
            continue;
        *fact = (world_fact){facts[row].name, facts[row].parameter, value, facts[row].means[value]};
        return true;
    }
    // A range, which no kernel's name says.
    *fact =
        (world_fact){"positions", "ORIGIN", 1,
                     "in origin cells: an object takes 16 bytes more, its sorted bounds and box "
                     "32 (lanes: 44)"};
    return i == 0 && world->def.origin_edge > 0.0f;
}

// ---------------------------------------------------------------- kernels

// Why a kernel may be left out.
typedef enum reason { NEVER, BY_SORT, BY_SEARCH, BY_TEST } reason;

static const struct {
    const char *name;
    const char *called_by;
    reason left_out;
} kernels[] = {
    {"clear", "the first step, and where the one before left no zeros", NEVER},
    {"hash", "every step: the cell of each object", NEVER},
    {"scan", "every step: places are sums of counts", NEVER},
    {"scatter", "sort=counting: ids to their places", BY_SORT},
    {"radix", "sort=radix, passes over the keys", BY_SORT},
    {"cell_start", "sort=radix: where cells begin", BY_SORT},
    {"reorder", "search gpu:  cell order", BY_SEARCH},
    {"reorder_simd", "search simd: cell order", BY_SEARCH},
    {"bounds", "search paper: bounds by id", BY_SEARCH},
    {"pair_search_gpu", "search gpu", BY_SEARCH},
    {"pair_search_simd", "search simd", BY_SEARCH},
    {"pair_search_paper", "search paper", BY_SEARCH},
    {"narrow", "candidates that are listed", BY_TEST},
    {"narrow_simd", "candidates that are listed", BY_TEST},
};

static const char *why_not(const part *p, reason left_out)
{
    static const char *const searches[] = {[SEARCH_GPU] = "the search is gpu",
                                           [SEARCH_SIMD] = "the search is simd",
                                           [SEARCH_PAPER] = "the search is paper"};
    if (left_out == BY_SORT && p->variant.sort == SORT_RADIX)
        return "the sort is radix";
    if (left_out == BY_SORT && !(p->facts & PART_BY_IDS))
        return "objects go to their places without sorted ids";
    if (left_out == BY_SORT)
        return "the sort is counting: its sums are where cells begin";
    if (left_out == BY_TEST && !(p->facts & PART_TESTS_BOXES))
        return "bounds that overlap are the answer";
    if (left_out == BY_TEST && !p->kernels.narrow)
        return "candidates are tested where they are found";
    return searches[p->variant.search];
}

// The kernel of that name, if the part launches it.
static const kernel *launched(const part *p, const char *name)
{
    const kernel *k = part_kernel(p, name);
    return k != p->kernels.scatter || (p->facts & PART_BY_IDS) ? k : NULL;
}

bool world_kernel_at(const duet_world *world, int side, uint32_t i, world_kernel *k)
{
    if (!world_is_prepared(world, side) || i >= sizeof kernels / sizeof kernels[0])
        return false;
    const part *p = &world->parts[side];
    const kernel *ran = launched(p, kernels[i].name);
    *k = (world_kernel){
        .name = ran ? ran->name : kernels[i].name,
        .runs = ran,
        .why = ran ? kernels[i].called_by : why_not(p, kernels[i].left_out),
    };
    return true;
}
