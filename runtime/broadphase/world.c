// SPDX-License-Identifier: MIT
#include "runtime/broadphase/world.h"

#include "base/error.h"
#include "runtime/narrowphase/accuracy.h"
#include "runtime/narrowphase/origin.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { COOKIE = 0x0d0e7002 };

static uint32_t default_share(const duet_device_pair *pair)
{
    uint64_t a = pair->devices[0].info.units, b = pair->devices[1].info.units;
    return world_pair_is_alike(pair) && a + b > 0 ? (uint32_t)(DUET_SHARE_ONE * a / (a + b)) : 0;
}

static const char *default_variant(const duet_device_info *info)
{
    return info->kind == DUET_KIND_CPU ? "simd" : "auto";
}

// Fills in what a plan leaves to the device pair.
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

// ---------------------------------------------------------------- checks

static bool check_world_box(const duet_world_def *def, duet_error *err)
{
    for (uint32_t k = 0; def->has_world && k < def->dims; ++k)
        if (!isfinite(def->lower[k]) || !isfinite(def->upper[k]) || def->lower[k] > def->upper[k])
            return bad_argument(err,
                                "the world's %c runs from %g to %g; expected finite and rising",
                                "xyz"[k], def -> lower[k], def -> upper[k]);
    return true;
}

static bool check_origin(const duet_world_def *def, duet_error *err)
{
    if (!origin_is_edge(def->origin_edge))
        return bad_argument(err,
                            "origin_edge is %g; expected 0, or a power of two from 2^-100 to 2^100",
                            (double)def->origin_edge);
    return def->origin_edge == 0.0f || def->shape == DUET_SHAPE_POSES ||
           bad_argument(err, "origin cells are for poses; expected an origin_edge of 0 for %s",
                        world_objects_name(def));
}

static bool check_pose_form(const duet_world_def *def, duet_error *err)
{
    if (def->pose_form > DUET_POSE_COMPACT)
        return bad_argument(err, "pose_form is %d; expected a duet_pose_form", (int)def->pose_form);
    bool of_poses = def->shape == DUET_SHAPE_POSES && def->origin_edge == 0.0f;
    return of_poses || !def->pose_form ||
           bad_argument(err, "pose_form is for poses; expected DUET_POSE_WHOLE for %s",
                        world_objects_name(def));
}

bool world_check_def(const duet_world_def *def, duet_error *err)
{
    if (!error_def(def && def->cookie == COOKIE, "world", "duet_default_world_def", err) ||
        !error_def_dims(def->dims, err))
        return false;
    if (def->shape < DUET_SHAPE_POSES || def->shape >= DUET_SHAPES)
        return bad_argument(err, "shape is %d; expected a duet_shape", (int)def->shape);
    if (!duet_level_get_info(def->level))
        return bad_argument(err, "level is %d; expected a duet_level", (int)def->level);
    if (def->has_accuracy && !accuracy_check(&def->accuracy, "the world's", err))
        return false;
    if (!(def->cell >= 0.0f) || !isfinite(def->cell))
        return bad_argument(err, "cell is %g; expected 0 or an edge above 0", def->cell);
    return check_origin(def, err) && check_pose_form(def, err) && check_world_box(def, err);
}

static bool check_def(const duet_world_def *def, duet_error *err)
{
    return world_check_def(def, err) && error_def_pair(def->pair, "world", err);
}

// The grid that both variants can search.
static bool find_wish(grid_wish *wish, const duet_plan *plan, const variant *a, const variant *b,
                      duet_error *err)
{
    bool paper = a->search == SEARCH_PAPER || b->search == SEARCH_PAPER;
    bool slab = plan->mode == DUET_MODE_SLAB;
    bool hashed = a->grid == VARIANT_GRID_HASHED || b->grid == VARIANT_GRID_HASHED;
    bool uniform =
        paper || slab || a->grid == VARIANT_GRID_UNIFORM || b->grid == VARIANT_GRID_UNIFORM;
    bool dense = paper || slab || a->grid == VARIANT_GRID_DENSE || b->grid == VARIANT_GRID_DENSE;
    wish->kinds = hashed ? GRID_ONLY_HASHED : dense ? GRID_ONLY_DENSE : GRID_ANY;
    wish->n_levels = uniform ? 1 : 0;
    if (hashed && (dense || uniform))
        return bad_argument(err,
                            "a hashed grid suits neither the paper's search nor slabs nor another "
                            "grid on the other device ('%s', '%s', mode %s)",
                            plan->variant_a, plan->variant_b, duet_mode_name(plan->mode));
    return true;
}

static bool check_ends(const char *name, const char *chars, size_t capacity, duet_error *err)
{
    return memchr(chars, '\0', capacity) ||
           bad_argument(err, "%s has no end within its %zu bytes", name, capacity);
}

// Reads what the plan asks of the grid and of each device.
static bool read_plan(grid_wish *wish, variant variants[2], const duet_plan *plan,
                      const duet_world_def *def, duet_error *err)
{
    variant *a = &variants[0], *b = &variants[1];
    *wish = (grid_wish){0};
    if (!check_ends("variant_a", plan->variant_a, sizeof plan->variant_a, err) ||
        !check_ends("variant_b", plan->variant_b, sizeof plan->variant_b, err))
        return false;
    if (plan->share > DUET_SHARE_ONE)
        return bad_argument(err, "share is %u of %u; expected at most all of it", plan->share,
                            DUET_SHARE_ONE);
    if (plan->mode < DUET_MODE_SHARED || plan->mode > DUET_MODE_DEFAULT)
        return bad_argument(err, "mode is %d; expected a duet_mode", (int)plan->mode);
    if (!variant_parse(a, plan->variant_a, &def->pair->devices[0].info, err) ||
        !variant_parse(b, plan->variant_b, &def->pair->devices[1].info, err))
        return false;
    bool paper = a->search == SEARCH_PAPER || b->search == SEARCH_PAPER;
    const char *unknown = def->pose_form                           ? "sizes apart"
                          : def->origin_edge > 0.0f                ? "origin cells"
                          : def->shape == DUET_SHAPE_ROUNDED_BOXES ? "rounded boxes"
                          : def->shape == DUET_SHAPE_SPHERES       ? "spheres"
                                                                   : NULL;
    if (paper && unknown)
        return bad_argument(
            err, "the paper's search knows no %s ('%s', '%s'); expected auto, simd or gpu", unknown,
            plan->variant_a, plan->variant_b);
    if (plan->mode == DUET_MODE_SHARED &&
        (a->search == SEARCH_PAPER) != (b->search == SEARCH_PAPER))
        return bad_argument(err,
                            "mode shared: A cannot search B's grid as '%s' where B does '%s'; "
                            "expected the same search, or mode own",
                            plan->variant_a, plan->variant_b);
    return find_wish(wish, plan, a, b, err);
}

// ---------------------------------------------------------------- owner

static void take_plan(duet_world *world, const duet_plan *plan, const grid_wish *wish,
                      const variant variants[2])
{
    world->def.plan = *plan;
    world->wish = *wish;
    world->variants[0] = variants[0];
    world->variants[1] = variants[1];
    world->asked_mode = plan->mode;
    world_choose_mode(world);
}

duet_world *duet_world_create(const duet_world_def *def, duet_error *err)
{
    PUBLIC_CALL(err);
    grid_wish wish;
    variant variants[2];
    if (!check_def(def, err))
        return NULL;
    duet_plan plan = resolve_plan(def->plan, def->pair);
    if (!read_plan(&wish, variants, &plan, def, err))
        return NULL;
    duet_world *world = calloc(1, sizeof *world);
    if (!world)
        return null_no_memory(err, "a world");
    world->def = *def;
    world->objects = (grid_objects){.kind = world_objects_kind(def),
                                    .shape = def->shape,
                                    .dims = def->dims,
                                    .origin = def->origin_edge,
                                    .all.row_bytes = world_kind_bytes(world_objects_kind(def)),
                                    .sizes.row_bytes = sizeof(duet_size)};
    take_plan(world, &plan, &wish, variants);
    world_hold(world);
    device_pair_hold(def->pair);
    compaction_open(&world->lists);
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
    world_drop_resident(world);
    pair_buffers_drop(&world->left);
    host_block_release(&world->objects_block);
    host_block_release(&world->sizes_block);
    compaction_close(&world->lists);
    split_free(&world->split);
    input_ranges_close(&world->ranges);
    duet_device_pair_destroy(world->def.pair);
    free(world);
}

bool duet_world_set_plan(duet_world *world, const duet_plan *plan, duet_error *err)
{
    PUBLIC_CALL(err);
    grid_wish wish;
    variant variants[2];
    if (!world_is_idle(world, __func__, err) || !error_given(plan, __func__, "plan", err))
        return false;
    duet_plan whole = resolve_plan(*plan, world->def.pair);
    plan = &whole;
    if (!read_plan(&wish, variants, plan, &world->def, err))
        return false;
    if (wish.n_levels != world->wish.n_levels || wish.kinds != world->wish.kinds)
        world_forget_grid(world);
    take_plan(world, plan, &wish, variants);
    return true;
}

const duet_plan *duet_world_get_plan(const duet_world *world)
{
    return world && !world_is_under_way(world) ? &world->def.plan : NULL;
}

bool duet_world_set_level(duet_world *world, duet_level level, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!world_is_idle(world, __func__, err))
        return false;
    if (!duet_level_get_info(level))
        return bad_argument(err, "level is %d; expected a duet_level", (int)level);
    world_change_level(world, level);
    world->def.has_accuracy = false;
    return true;
}

void world_change_level(duet_world *world, duet_level level)
{
    for (int side = 0; side < 2 && level != world->def.level; ++side)
        part_forget_kernels(&world->parts[side]);
    world->def.level = level;
}

bool world_is_prepared(const duet_world *world, int side)
{
    return part_has_kernels(&world->parts[side], &world->variants[side]);
}

duet_level duet_world_get_level(const duet_world *world)
{
    return world ? world->def.level : DUET_LEVEL_CERTIFIED;
}
