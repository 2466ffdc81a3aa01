// SPDX-License-Identifier: MIT
#include "runtime/broadphase/world.h"

#include "base/error.h"
#include "runtime/narrowphase/accuracy.h"
#include "runtime/narrowphase/origin.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { COOKIE = 0x0d0e7002 };

const char *duet_mode_name(duet_mode mode)
{
    switch (mode) {
    case DUET_MODE_SHARED:
        return "shared";
    case DUET_MODE_OWN:
        return "own";
    case DUET_MODE_SLAB:
        return "slab";
    case DUET_MODE_DEFAULT:
        return "default";
    }
    return NULL;
}

// Parts of one CPU, or two equal devices, do work in proportion to their units;
// how unequal ones compare is not known before it is measured.
static bool are_alike(const duet_device_pair *pair)
{
    const duet_device_info *a = &pair->devices[0].info, *b = &pair->devices[1].info;
    return a->kind == b->kind && strcmp(a->name, b->name) == 0 && !duet_device_pair_is_one(pair);
}

static uint32_t default_share(const duet_device_pair *pair)
{
    uint64_t a = pair->devices[0].info.units, b = pair->devices[1].info.units;
    return are_alike(pair) && a + b > 0 ? (uint32_t)(DUET_SHARE_ONE * a / (a + b)) : 0;
}

static const char *default_variant(const duet_device_info *info)
{
    return info->kind == DUET_KIND_CPU ? "simd" : "auto";
}

// What a plan leaves to the device pair.
static duet_plan resolve_plan(duet_plan plan, const duet_device_pair *pair)
{
    if (plan.share == DUET_SHARE_DEFAULT)
        plan.share = default_share(pair);
    if (!*plan.variant_a)
        strcpy(plan.variant_a, default_variant(&pair->devices[0].info));
    if (!*plan.variant_b)
        strcpy(plan.variant_b, default_variant(&pair->devices[1].info));
    return plan;
}

duet_plan duet_default_plan(const duet_device_pair *pair)
{
    duet_plan plan = {.share = DUET_SHARE_DEFAULT, .mode = DUET_MODE_DEFAULT};
    return pair ? resolve_plan(plan, pair) : plan;
}

duet_world_def duet_default_world_def(void)
{
    return (duet_world_def){
        .plan = duet_default_plan(NULL), .dims = 3, .rotated = true, .cookie = COOKIE};
}

// ---------------------------------------------------------------- kinds of objects

static const world_kind kinds[] = {
    [DUET_OBJECT_POSES] = {DUET_OBJECT_POSES, "poses", sizeof(duet_pose)},
    [DUET_OBJECT_BOUNDS] = {DUET_OBJECT_BOUNDS, "bounds", sizeof(duet_bounds)},
    [DUET_OBJECT_LARGE_POSES] = {DUET_OBJECT_LARGE_POSES, "large poses", sizeof(duet_large_pose)},
    [DUET_OBJECT_TRANSFORMS] = {DUET_OBJECT_TRANSFORMS, "transforms", sizeof(duet_transform)},
    [DUET_OBJECT_SIZES] = {DUET_OBJECT_SIZES, "sizes", sizeof(duet_size)},
    [DUET_OBJECT_COMPACT_TRANSFORMS] = {DUET_OBJECT_COMPACT_TRANSFORMS, "compact transforms",
                                        sizeof(duet_compact_transform)},
    [DUET_OBJECT_ROUNDED_BOXES] = {DUET_OBJECT_ROUNDED_BOXES, "rounded boxes",
                                   sizeof(duet_rounded_box)},
    [DUET_OBJECT_SPHERES] = {DUET_OBJECT_SPHERES, "spheres", sizeof(duet_sphere)},
};

// What a world is made for.
static duet_object_kind kind_of(const duet_world_def *def)
{
    static const duet_object_kind of_shape[DUET_SHAPES] = {
        [DUET_SHAPE_POSES] = DUET_OBJECT_POSES,
        [DUET_SHAPE_BOUNDS] = DUET_OBJECT_BOUNDS,
        [DUET_SHAPE_ROUNDED_BOXES] = DUET_OBJECT_ROUNDED_BOXES,
        [DUET_SHAPE_SPHERES] = DUET_OBJECT_SPHERES,
    };
    if (def->shape != DUET_SHAPE_POSES)
        return of_shape[def->shape];
    return def->origin_edge > 0.0f   ? DUET_OBJECT_LARGE_POSES
           : def->compact_transforms ? DUET_OBJECT_COMPACT_TRANSFORMS
           : def->separate_sizes     ? DUET_OBJECT_TRANSFORMS
                                     : DUET_OBJECT_POSES;
}

// ---------------------------------------------------------------- checks

static bool check_world_box(const duet_world_def *def, duet_error *err)
{
    for (uint32_t k = 0; def->has_world && k < def->dims; ++k)
        if (!isfinite(def->lower[k]) || !isfinite(def->upper[k]) || def->lower[k] > def->upper[k])
            return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                             "the world's %c runs from %g to %g; expected finite and rising",
                             "xyz"[k], def -> lower[k], def -> upper[k]);
    return true;
}

static bool check_origin(const duet_world_def *def, duet_error *err)
{
    if (!origin_is_edge(def->origin_edge))
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "origin_edge is %g; expected 0, or a power of "
                         "two from 2^-100 to 2^100",
                         (double)def->origin_edge);
    return def->origin_edge == 0.0f || def->shape == DUET_SHAPE_POSES ||
           error_set(err, DUET_STATUS_BAD_ARGUMENT,
                     "origin cells are for poses; expected an origin_edge of 0 for %s",
                     kinds[kind_of(def)].name);
}

static bool check_sizes_apart(const duet_world_def *def, duet_error *err)
{
    bool plain = def->shape == DUET_SHAPE_POSES && def->origin_edge == 0.0f;
    duet_world_def plain_def = *def;
    plain_def.separate_sizes = plain_def.compact_transforms = false;
    return plain || !(def->separate_sizes || def->compact_transforms) ||
           error_set(err, DUET_STATUS_BAD_ARGUMENT, "%s is for poses; expected false for %s",
                     def->compact_transforms ? "compact_transforms" : "separate_sizes",
                     kinds[kind_of(&plain_def)].name);
}

bool world_check_def(const duet_world_def *def, duet_error *err)
{
    if (!def || def->cookie != COOKIE)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "the world's def does not come from duet_default_world_def");
    if (def->dims != 2 && def->dims != 3)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT, "dims is %u; expected 2 or 3", def->dims);
    if (def->shape < DUET_SHAPE_POSES || def->shape >= DUET_SHAPES)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT, "shape is %d; expected a duet_shape",
                         (int)def->shape);
    if (!duet_level_get_info(def->level))
        return error_set(err, DUET_STATUS_BAD_ARGUMENT, "level is %d; expected a duet_level",
                         (int)def->level);
    if (def->has_accuracy && !accuracy_check(&def->accuracy, "the world's", err))
        return false;
    if (!(def->cell >= 0.0f) || !isfinite(def->cell))
        return error_set(err, DUET_STATUS_BAD_ARGUMENT, "cell is %g; expected 0 or an edge above 0",
                         def->cell);
    return check_origin(def, err) && check_sizes_apart(def, err) && check_world_box(def, err);
}

static bool check_def(const duet_world_def *def, duet_error *err)
{
    return world_check_def(def, err) &&
           (def->pair ||
            error_set(err, DUET_STATUS_BAD_ARGUMENT, "the world's def has no device pair"));
}

// The grid that both variants can search.
static bool find_wish(grid_wish *wish, const duet_plan *plan, const variant *a, const variant *b,
                      duet_error *err)
{
    bool paper = a->search == SEARCH_PAPER || b->search == SEARCH_PAPER;
    bool slab = plan->mode == DUET_MODE_SLAB;
    wish->hashed = a->grid == VARIANT_GRID_HASHED || b->grid == VARIANT_GRID_HASHED;
    wish->uniform =
        paper || slab || a->grid == VARIANT_GRID_UNIFORM || b->grid == VARIANT_GRID_UNIFORM;
    wish->dense = paper || slab || a->grid == VARIANT_GRID_DENSE || b->grid == VARIANT_GRID_DENSE;
    if (wish->hashed && (wish->dense || wish->uniform))
        return error_set(
            err, DUET_STATUS_BAD_ARGUMENT,
            "a hashed grid suits neither the paper's search nor slabs nor another grid "
            "on the other device ('%s', '%s', mode %s)",
            plan->variant_a, plan->variant_b, duet_mode_name(plan->mode));
    return true;
}

static bool check_ends(const char *name, const char *chars, size_t capacity, duet_error *err)
{
    return memchr(chars, '\0', capacity) ||
           error_set(err, DUET_STATUS_BAD_ARGUMENT, "%s has no end within its %zu bytes", name,
                     capacity);
}

// What the plan asks of the grid and of each device.
static bool read_plan(grid_wish *wish, variant variants[2], const duet_plan *plan,
                      const duet_world_def *def, duet_error *err)
{
    variant *a = &variants[0], *b = &variants[1];
    *wish = (grid_wish){0};
    if (!check_ends("variant_a", plan->variant_a, sizeof plan->variant_a, err) ||
        !check_ends("variant_b", plan->variant_b, sizeof plan->variant_b, err))
        return false;
    if (plan->share > DUET_SHARE_ONE)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "share is %u of %u; expected at most all of it", plan->share,
                         DUET_SHARE_ONE);
    if (plan->mode < DUET_MODE_SHARED || plan->mode > DUET_MODE_DEFAULT)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT, "mode is %d; expected a duet_mode",
                         (int)plan->mode);
    if (!variant_parse(a, plan->variant_a, &def->pair->devices[0].info, err) ||
        !variant_parse(b, plan->variant_b, &def->pair->devices[1].info, err))
        return false;
    bool paper = a->search == SEARCH_PAPER || b->search == SEARCH_PAPER;
    const char *unknown = def->separate_sizes                      ? "sizes apart"
                          : def->origin_edge > 0.0f                ? "origin cells"
                          : def->shape == DUET_SHAPE_ROUNDED_BOXES ? "rounded boxes"
                          : def->shape == DUET_SHAPE_SPHERES       ? "spheres"
                                                                   : NULL;
    if (paper && unknown)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT,
                         "the paper's search knows no %s ('%s', '%s'); expected "
                         "auto, simd or gpu",
                         unknown, plan->variant_a, plan->variant_b);
    if (plan->mode == DUET_MODE_SHARED &&
        (a->search == SEARCH_PAPER) != (b->search == SEARCH_PAPER))
        return error_set(
            err, DUET_STATUS_BAD_ARGUMENT,
            "mode shared: A cannot search B's grid as '%s' where B does '%s'; expected "
            "the same search, or mode own",
            plan->variant_a, plan->variant_b);
    return find_wish(wish, plan, a, b, err);
}

// ---------------------------------------------------------------- owner

// Which mode the default is depends on the grid, which slabs cut only where its cells are
// of one size. To have them at any price was measured three times slower where sizes are mixed.
void world_choose_mode(duet_world *world)
{
    bool one_size = world->grid.kind == GRID_DENSE && world->grid.n_levels == 1;
    if (world->mode_open)
        world->def.plan.mode =
            one_size && are_alike(world->def.pair) ? DUET_MODE_SLAB : DUET_MODE_OWN;
}

bool world_is_b_alone(const duet_world *world)
{
    const duet_plan *plan = &world->def.plan;
    bool slabs = plan->mode == DUET_MODE_SLAB || (world->mode_open && are_alike(world->def.pair));
    return plan->share == 0 && !slabs;
}

static void take_plan(duet_world *world, const duet_plan *plan, const grid_wish *wish,
                      const variant variants[2])
{
    world->def.plan = *plan;
    world->wish = *wish;
    world->variants[0] = variants[0];
    world->variants[1] = variants[1];
    world->mode_open = plan->mode == DUET_MODE_DEFAULT;
    world_choose_mode(world);
}

duet_world *duet_world_create(const duet_world_def *def, duet_error *err)
{
    grid_wish wish;
    variant variants[2];
    if (!check_def(def, err))
        return NULL;
    duet_plan plan = resolve_plan(def->plan, def->pair);
    duet_world_def own = *def;
    own.separate_sizes |= own.compact_transforms;
    if (!read_plan(&wish, variants, &plan, &own, err))
        return NULL;
    duet_world *world = calloc(1, sizeof *world);
    if (!world) {
        error_set(err, DUET_STATUS_NO_MEMORY, "no memory for a world");
        return NULL;
    }
    world->def = own;
    take_plan(world, &plan, &wish, variants);
    world_hold(world);
    device_pair_hold(def->pair);
    pack_open(&world->pack);
    world->driver = thread_pool_open(1, err);
    bool ok = world->driver && part_open(&world->parts[0], def->pair, 0, err) &&
              part_open(&world->parts[1], def->pair, 1, err);
    if (!ok) {
        duet_world_destroy(world);
        return NULL;
    }
    return world;
}

void world_hold(duet_world *world)
{
    ++world->users;
}

void duet_world_destroy(duet_world *world)
{
    if (!world || --world->users > 0)
        return;
    background_close(&world->background);
    thread_pool_close(world->driver);
    part_close(&world->parts[0]);
    part_close(&world->parts[1]);
    resident_drop(&world->resident);
    pair_buffers_drop(&world->left);
    host_block_release(&world->objects);
    host_block_release(&world->sizes);
    pack_close(&world->pack);
    split_free(&world->split);
    strays_close(&world->strays);
    duet_device_pair_destroy(world->def.pair);
    free(world);
}

// The next step fits another one, which is no change of this one.
void world_forget_grid(duet_world *world)
{
    world->fitted = world->cells_vary = false;
    world->grid = (grid){0};
}

bool duet_world_set_plan(duet_world *world, const duet_plan *plan, duet_error *err)
{
    grid_wish wish;
    variant variants[2];
    if (!world_is_idle(world, __func__, err) || !error_given(plan, __func__, "plan", err))
        return false;
    duet_plan whole = resolve_plan(*plan, world->def.pair);
    plan = &whole;
    if (!read_plan(&wish, variants, plan, &world->def, err))
        return false;
    if (wish.uniform != world->wish.uniform || wish.dense != world->wish.dense ||
        wish.hashed != world->wish.hashed)
        world_forget_grid(world);
    if ((plan->mode == DUET_MODE_SHARED) != (world->def.plan.mode == DUET_MODE_SHARED))
        world->prepared[0] = world->prepared[1] = false;
    world->prepared[0] &= strcmp(plan->variant_a, world->def.plan.variant_a) == 0;
    world->prepared[1] &= strcmp(plan->variant_b, world->def.plan.variant_b) == 0;
    take_plan(world, plan, &wish, variants);
    return true;
}

const duet_plan *duet_world_get_plan(const duet_world *world)
{
    return world && !world_is_under_way(world) ? &world->def.plan : NULL;
}

bool duet_world_set_level(duet_world *world, duet_level level, duet_error *err)
{
    if (!world_is_idle(world, __func__, err))
        return false;
    if (!duet_level_get_info(level))
        return error_set(err, DUET_STATUS_BAD_ARGUMENT, "level is %d; expected a duet_level",
                         (int)level);
    world_change_level(world, level);
    world->def.has_accuracy = false;
    return true;
}

void world_change_level(duet_world *world, duet_level level)
{
    if (level != world->def.level)
        world->prepared[0] = world->prepared[1] = false;
    world->def.level = level;
}

duet_level duet_world_get_level(const duet_world *world)
{
    return world ? world->def.level : DUET_LEVEL_CERTIFIED;
}

// ---------------------------------------------------------------- objects

grid_objects world_objects(const duet_world *world)
{
    const duet_world_def *def = &world->def;
    return (grid_objects){
        .array = world->resident.objects.mem ? world->resident.seen
                 : world->lent               ? world->lent
                                             : world->objects.bytes,
        .shape = def->shape,
        .origin = def->origin_edge,
        .n = world->n,
        .dims = def->dims,
        .sizes = def->separate_sizes ? world->sizes.bytes : NULL,
        .compact = def->compact_transforms,
    };
}

bool world_see_objects(duet_world *world, duet_error *err)
{
    grid_objects objects = world_objects(world);
    const device *devices = world->def.pair->devices;
    return objects.array || !world->resident.objects.mem ||
           (resident_await(&world->resident, err) &&
            resident_see(&world->resident, world->n * grid_object_bytes(&objects), &world->objects,
                         devices, world->parts, err));
}

void world_end_sight(duet_world *world)
{
    resident_end_sight(&world->resident, world->def.pair->devices);
}

bool world_can_have(const duet_world *world, duet_object_kind kind, uint32_t n, const char *call,
                    world_kind *what, duet_error *err)
{
    if (!world_is_idle(world, call, err))
        return false;
    if (kind < DUET_OBJECT_POSES || kind > DUET_OBJECT_SPHERES)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT, "kind is %d; expected a duet_object_kind",
                         (int)kind);
    duet_object_kind right = kind_of(&world->def);
    bool size = kind == DUET_OBJECT_SIZES && world->def.separate_sizes;
    if (kind != right && !size)
        return error_set(err, DUET_STATUS_BAD_ARGUMENT, "the world was made for %s, not for %s",
                         kinds[right].name, kinds[kind].name);
    *what = kinds[kind];
    return n <= UINT32_MAX - 2 ||
           error_set(err, DUET_STATUS_TOO_MANY, "%u objects; a world holds at most %u", n,
                     UINT32_MAX - 2);
}

// The row behind the last belongs to none: a device may read four numbers at once.
static void *map_sizes(duet_world *world, uint32_t n, duet_error *err)
{
    if (!host_block_reserve(&world->sizes, world->def.pair->devices, 2,
                            ((size_t)n + 1) * sizeof(duet_size), err))
        return NULL;
    duet_size *sizes = world->sizes.bytes;
    sizes[n] = (duet_size){0};
    world->n_sizes = n;
    ++world->sizes_version;
    return sizes;
}

void *duet_world_map_objects(duet_world *world, duet_object_kind kind, uint32_t n, duet_error *err)
{
    world_kind what;
    if (!world_can_have(world, kind, n, __func__, &what, err))
        return NULL;
    if (kind == DUET_OBJECT_SIZES)
        return map_sizes(world, n, err);
    resident_drop(&world->resident);
    if (!host_block_reserve(&world->objects, world->def.pair->devices, 2, n * what.bytes, err))
        return NULL;
    world->lent = NULL;
    world->n = n;
    ++world->objects_version;
    return world->objects.bytes;
}

void *world_extend_objects(duet_world *world, duet_object_kind kind, uint32_t n)
{
    if (n * kinds[kind].bytes > world->objects.size)
        return NULL;
    world->lent = NULL;
    world->n = n;
    return world->objects.bytes;
}

void world_lend_objects(duet_world *world, const void *objects, uint32_t n)
{
    resident_drop(&world->resident);
    world->lent = objects;
    world->n = n;
    ++world->objects_version;
}

bool world_check_sizes(const duet_world *world, duet_error *err)
{
    return !world->def.separate_sizes || world->n_sizes == world->n ||
           error_set(err, DUET_STATUS_BAD_ARGUMENT,
                     "%u objects have a transform and %u a size; expected as many of each",
                     world->n, world->n_sizes);
}

static bool take_sizes(duet_world *world, const duet_pose *poses, uint32_t n, duet_error *err)
{
    duet_size *sizes = duet_world_map_objects(world, DUET_OBJECT_SIZES, n, err);
    for (uint32_t i = 0; sizes && i < n; ++i)
        memcpy(sizes[i].half_extents, poses[i].half_extents, sizeof poses->half_extents);
    return sizes;
}

bool world_take_transforms(duet_world *world, const duet_pose *poses, uint32_t n, duet_error *err)
{
    void *to = duet_world_map_objects(world, kind_of(&world->def), n, err);
    for (uint32_t i = 0; to && i < n; ++i) {
        duet_transform t = grid_transform_of(&poses[i]);
        if (world->def.dims == 2)
            t.rotation[0] = t.rotation[1] = 0.0f;
        if (!world->def.compact_transforms)
            ((duet_transform *)to)[i] = t;
        else // what has no rotation is the step's to report
            duet_compact_transform_set(&((duet_compact_transform *)to)[i], &t, NULL);
    }
    return to;
}

// The first objects are counted at once: who then asks for a profile need not
// wait for that. An offset that is not a number is the step's to report. Of no
// objects none need be there.
bool duet_world_set_objects(duet_world *world, duet_object_kind kind, const void *objects,
                            uint32_t n, duet_error *err)
{
    if (!world_is_idle(world, __func__, err) ||
        (n > 0 && !error_given(objects, __func__, "objects", err)))
        return false;
    if (kind == DUET_OBJECT_POSES && world->def.separate_sizes)
        return world_take_transforms(world, objects, n, err) && take_sizes(world, objects, n, err);
    void *to = duet_world_map_objects(world, kind, n, err);
    if (!to || n == 0)
        return to;
    memcpy(to, objects, n * kinds[kind].bytes);
    for (uint32_t i = 0; kind == DUET_OBJECT_LARGE_POSES && i < n; ++i)
        origin_settle(&((duet_large_pose *)to)[i], world->def.origin_edge);
    if (kind != DUET_OBJECT_SIZES && world->objects_version == 1 && !world->def.separate_sizes)
        workload_stats_take(&world->stats, world);
    return true;
}
