// SPDX-License-Identifier: MIT
// tree:ray_query, :sweep_query, :box_query and :point_query: what is asked of a tree. They differ
// in the C calls behind them and in the arrays that they take and give.
#include "lua/nouns.h"

#include <stddef.h>
#include <string.h>

// The results differ in the type of their hits alone.
typedef union answer {
    struct {
        const void *hits;
        uint64_t n_hits;
        uint64_t undecided;
        double total_ms;
        double device_ms[2];
    };
    duet_ray_query_result rays;
    duet_sweep_query_result sweeps;
    duet_box_query_result boxes;
    duet_point_query_result points;
} answer;

#define IS_AN_ANSWER(result)                                                         \
    _Static_assert(sizeof(result) == sizeof(answer) &&                               \
                       offsetof(result, undecided) == offsetof(answer, undecided) && \
                       offsetof(result, device_ms) == offsetof(answer, device_ms),   \
                   #result " is laid out as the others")
IS_AN_ANSWER(duet_ray_query_result);
IS_AN_ANSWER(duet_sweep_query_result);
IS_AN_ANSWER(duet_box_query_result);
IS_AN_ANSWER(duet_point_query_result);

static const member result_members[] = {
    MEMBER(member_count, answer, undecided),
    MEMBER(member_double, answer, total_ms),
    MEMBER(member_double, answer, device_ms),
    {0},
};

// What a script says in place of a def.
typedef struct query_def {
    duet_query_wants wants;
    duet_level level;
    uint32_t nearest;
} query_def;

typedef struct query_kind {
    lua_class class;
    const char *noun;                  // "a ray query", in messages
    const member *members;             // of query_def
    array_kind takes[DUET_SHAPES + 1]; // by the tree's shape
    array_kind gives;
    size_t hit_bytes;
    void *(*create)(duet_tree *tree, const query_def *def, duet_error *err);
    bool (*run)(void *query, const array *items, answer *found, duet_error *err);
    void (*destroy)(void *query);
} query_kind;

typedef struct query_box {
    void *query;
    const query_kind *kind;
    array_kind takes;
} query_box;

// ---------------------------------------------------------------- the four

static const member wants_members[] = {MEMBER_ENUM(query_def, wants, query_wants_name), {0}};
static const member level_members[] = {MEMBER_ENUM(query_def, level, level_name), {0}};
static const member nearest_members[] = {MEMBER(member_count, query_def, nearest), {0}};

static void *create_rays(duet_tree *tree, const query_def *given, duet_error *err)
{
    duet_ray_query_def def = duet_default_ray_query_def();
    def.tree = tree;
    def.wants = given->wants;
    return duet_ray_query_create(&def, err);
}

static bool run_rays(void *query, const array *items, answer *found, duet_error *err)
{
    if (items->kind == ARRAY_LARGE_RAYS)
        return duet_ray_query_run_large(query, items->rows, items->n, &found->rays, err);
    return duet_ray_query_run(query, items->rows, items->n, &found->rays, err);
}

static void destroy_rays(void *query)
{
    duet_ray_query_destroy(query);
}

static void *create_sweeps(duet_tree *tree, const query_def *given, duet_error *err)
{
    duet_sweep_query_def def = duet_default_sweep_query_def();
    def.tree = tree;
    def.wants = given->wants;
    return duet_sweep_query_create(&def, err);
}

static bool run_sweeps(void *query, const array *items, answer *found, duet_error *err)
{
    duet_object_kind kind = items->kind == ARRAY_SWEEPS           ? DUET_OBJECT_POSES
                            : items->kind == ARRAY_BOUNDS_SWEEPS  ? DUET_OBJECT_BOUNDS
                            : items->kind == ARRAY_ROUNDED_SWEEPS ? DUET_OBJECT_ROUNDED_BOXES
                            : items->kind == ARRAY_LARGE_SWEEPS   ? DUET_OBJECT_LARGE_POSES
                                                                  : DUET_OBJECT_SPHERES;
    return duet_sweep_query_run(query, kind, items->rows, items->n, &found->sweeps, err);
}

static void destroy_sweeps(void *query)
{
    duet_sweep_query_destroy(query);
}

static void *create_boxes(duet_tree *tree, const query_def *given, duet_error *err)
{
    duet_box_query_def def = duet_default_box_query_def();
    def.tree = tree;
    def.level = given->level;
    return duet_box_query_create(&def, err);
}

static bool run_boxes(void *query, const array *items, answer *found, duet_error *err)
{
    return duet_box_query_run(query, tree_object_kind(items->kind), items->rows, items->n,
                              &found->boxes, err);
}

static void destroy_boxes(void *query)
{
    duet_box_query_destroy(query);
}

static void *create_points(duet_tree *tree, const query_def *given, duet_error *err)
{
    duet_point_query_def def = duet_default_point_query_def();
    def.tree = tree;
    def.nearest = given->nearest;
    return duet_point_query_create(&def, err);
}

static bool run_points(void *query, const array *items, answer *found, duet_error *err)
{
    if (items->kind == ARRAY_LARGE_POINTS)
        return duet_point_query_run_large(query, items->rows, items->n, &found->points, err);
    return duet_point_query_run(query, items->rows, items->n, &found->points, err);
}

static void destroy_points(void *query)
{
    duet_point_query_destroy(query);
}

// ---------------------------------------------------------------- one shape

static const luaL_Reg methods[3], box_methods[4];

static const query_kind rays = {{.name = "duet.ray_query", .methods = methods},
                                "a ray query",
                                wants_members,
                                {ARRAY_RAYS, ARRAY_RAYS, ARRAY_RAYS, ARRAY_RAYS, ARRAY_LARGE_RAYS},
                                ARRAY_HITS,
                                sizeof(duet_ray_hit),
                                create_rays,
                                run_rays,
                                destroy_rays};
static const query_kind sweeps = {{.name = "duet.sweep_query", .methods = methods},
                                  "a sweep query",
                                  wants_members,
                                  {[DUET_SHAPE_POSES] = ARRAY_SWEEPS,
                                   [DUET_SHAPE_BOUNDS] = ARRAY_BOUNDS_SWEEPS,
                                   [DUET_SHAPE_ROUNDED_BOXES] = ARRAY_ROUNDED_SWEEPS,
                                   [DUET_SHAPE_SPHERES] = ARRAY_SPHERE_SWEEPS,
                                   [TREE_LARGE_POSES] = ARRAY_LARGE_SWEEPS},
                                  ARRAY_SWEEP_HITS,
                                  sizeof(duet_sweep_hit),
                                  create_sweeps,
                                  run_sweeps,
                                  destroy_sweeps};
static const query_kind boxes = {{.name = "duet.box_query", .methods = box_methods},
                                 "a box query",
                                 level_members,
                                 {[DUET_SHAPE_POSES] = ARRAY_POSES,
                                  [DUET_SHAPE_BOUNDS] = ARRAY_BOUNDS,
                                  [DUET_SHAPE_ROUNDED_BOXES] = ARRAY_ROUNDED_BOXES,
                                  [DUET_SHAPE_SPHERES] = ARRAY_SPHERES,
                                  [TREE_LARGE_POSES] = ARRAY_LARGE_POSES},
                                 ARRAY_BOX_HITS,
                                 sizeof(duet_box_hit),
                                 create_boxes,
                                 run_boxes,
                                 destroy_boxes};
static const query_kind points = {
    {.name = "duet.point_query", .methods = methods},
    "a point query",
    nearest_members,
    {ARRAY_POINTS, ARRAY_POINTS, ARRAY_POINTS, ARRAY_POINTS, ARRAY_LARGE_POINTS},
    ARRAY_POINT_HITS,
    sizeof(duet_point_hit),
    create_points,
    run_points,
    destroy_points};
static const query_kind *const kinds[] = {&rays, &boxes, &points, &sweeps};

enum { N_KINDS = sizeof kinds / sizeof *kinds };

static query_box *box_at_1(lua_State *L)
{
    for (int i = 0; i < N_KINDS; ++i) {
        query_box *box = luaL_testudata(L, 1, kinds[i]->class.name);
        if (box)
            return box;
    }
    luaL_typeerror(L, 1, "duet query");
    return NULL;
}

static query_box *check(lua_State *L)
{
    query_box *box = box_at_1(L);
    luaL_argcheck(L, box->query, 1, "the query is closed");
    return box;
}

// tree:ray_query(def) and the others
static int create(lua_State *L, const query_kind *kind)
{
    duet_error err = {0};
    query_def def = {DUET_QUERY_CLOSEST, DUET_LEVEL_CERTIFIED, 0};
    duet_tree *tree = tree_check(L, 1);
    if (!lua_isnoneornil(L, 2))
        member_read_table(L, 2, kind->noun, kind->members, &def);
    query_box *box = class_push(L, &kind->class, sizeof *box);
    lua_pushvalue(L, 1);
    lua_setiuservalue(L, -2, 1);
    box->kind = kind;
    box->takes = kind->takes[tree_shape(L, 1)];
    box->query = kind->create(tree, &def, &err);
    return box->query ? 1 : class_push_failure(L, &err);
}

static int create_ray_query(lua_State *L)
{
    return create(L, &rays);
}

static int create_sweep_query(lua_State *L)
{
    return create(L, &sweeps);
}

static int create_box_query(lua_State *L)
{
    return create(L, &boxes);
}

static int create_point_query(lua_State *L)
{
    return create(L, &points);
}

const luaL_Reg tree_query_methods[] = {{"ray_query", create_ray_query},
                                       {"sweep_query", create_sweep_query},
                                       {"box_query", create_box_query},
                                       {"point_query", create_point_query},
                                       {NULL, NULL}};

static int push_answer(lua_State *L, const query_kind *kind, const answer *found)
{
    array *hits = array_push(L, kind->gives, found->n_hits);
    if (found->n_hits > 0)
        memcpy(hits->rows, found->hits, (size_t)found->n_hits * kind->hit_bytes);
    member_push_table(L, result_members, found);
    return 2;
}

// query:run(items) -> hits, result
static int run(lua_State *L)
{
    duet_error err = {0};
    answer found = {0};
    query_box *box = check(L);
    const array *items = array_check(L, 2, box->takes);
    if (!box->kind->run(box->query, items, &found, &err))
        return class_push_failure(L, &err);
    return push_answer(L, box->kind, &found);
}

// query:run_itself(filters) -> hits, result
static int run_itself(lua_State *L)
{
    duet_error err = {0};
    answer found = {0};
    query_box *box = luaL_checkudata(L, 1, boxes.class.name);
    luaL_argcheck(L, box->query, 1, "the query is closed");
    const array *filters = lua_isnoneornil(L, 2) ? NULL : array_check(L, 2, ARRAY_FILTERS);
    if (!duet_box_query_run_itself(box->query, filters ? filters->rows : NULL,
                                   filters ? filters->n : 0, &found.boxes, &err))
        return class_push_failure(L, &err);
    return push_answer(L, &boxes, &found);
}

static int close(lua_State *L)
{
    query_box *box = box_at_1(L);
    if (box->query)
        box->kind->destroy(box->query);
    box->query = NULL;
    return 0;
}

static const luaL_Reg methods[3] = {{"close", close}, {"run", run}, {NULL, NULL}};
static const luaL_Reg box_methods[4] = {
    {"close", close}, {"run", run}, {"run_itself", run_itself}, {NULL, NULL}};

void tree_query_open_lua(lua_State *L)
{
    for (int i = 0; i < N_KINDS; ++i)
        class_open(L, &kinds[i]->class);
}
