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
} query_kind;

typedef struct query_box {
    lua_handle query;
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
    static const duet_object_kind kinds[] = {[ARRAY_SWEEPS] = DUET_OBJECT_POSES,
                                             [ARRAY_BOUNDS_SWEEPS] = DUET_OBJECT_BOUNDS,
                                             [ARRAY_ROUNDED_SWEEPS] = DUET_OBJECT_ROUNDED_BOXES,
                                             [ARRAY_LARGE_SWEEPS] = DUET_OBJECT_LARGE_POSES,
                                             [ARRAY_SPHERE_SWEEPS] = DUET_OBJECT_SPHERES};
    return duet_sweep_query_run(query, kinds[items->kind], items->rows, items->n, &found->sweeps,
                                err);
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
    return duet_box_query_run(query, array_object_kind(items->kind), items->rows, items->n,
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

static const luaL_Reg methods[2], box_methods[3];

#define QUERY_CLASS(name_, methods_, destroy_)                                         \
    {                                                                                  \
        .name = (name_), .methods = (methods_), .destroy = (destroy_), .noun = "query" \
    }

static const query_kind rays = {QUERY_CLASS("duet.ray_query", methods, destroy_rays),
                                "a ray query",
                                wants_members,
                                {ARRAY_RAYS, ARRAY_RAYS, ARRAY_RAYS, ARRAY_RAYS, ARRAY_LARGE_RAYS},
                                ARRAY_HITS,
                                sizeof(duet_ray_hit),
                                create_rays,
                                run_rays};
static const query_kind sweeps = {QUERY_CLASS("duet.sweep_query", methods, destroy_sweeps),
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
                                  run_sweeps};
static const query_kind boxes = {QUERY_CLASS("duet.box_query", box_methods, destroy_boxes),
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
                                 run_boxes};
static const query_kind points = {
    QUERY_CLASS("duet.point_query", methods, destroy_points),
    "a point query",
    nearest_members,
    {ARRAY_POINTS, ARRAY_POINTS, ARRAY_POINTS, ARRAY_POINTS, ARRAY_LARGE_POINTS},
    ARRAY_POINT_HITS,
    sizeof(duet_point_hit),
    create_points,
    run_points};

enum { RAYS, SWEEPS, BOXES, POINTS, N_KINDS };

static const query_kind *const kinds[N_KINDS] = {
    [RAYS] = &rays, [SWEEPS] = &sweeps, [BOXES] = &boxes, [POINTS] = &points};

static query_box *check(lua_State *L)
{
    for (int i = 0; i < N_KINDS; ++i)
        if (luaL_testudata(L, 1, kinds[i]->class.name))
            return class_check(L, 1, &kinds[i]->class);
    luaL_typeerror(L, 1, "duet query");
    return NULL;
}

// tree:ray_query(def) and the others; the upvalue is the place in kinds.
static int create(lua_State *L)
{
    duet_error err = {0};
    const query_kind *kind = kinds[lua_tointeger(L, lua_upvalueindex(1))];
    query_def def = {DUET_QUERY_CLOSEST, DUET_LEVEL_CERTIFIED, 0};
    duet_tree *tree = tree_check(L, 1);
    if (!lua_isnoneornil(L, 2))
        member_read_table(L, 2, kind->noun, kind->members, &def);
    query_box *box = class_push_of(L, &kind->class, sizeof *box, 1);
    box->kind = kind;
    box->takes = kind->takes[tree_shape(L, 1)];
    box->query.object = kind->create(tree, &def, &err);
    return box->query.object ? 1 : class_push_failure(L, &err);
}

const lua_shared tree_query_methods[] = {{"ray_query", create, RAYS},
                                         {"sweep_query", create, SWEEPS},
                                         {"box_query", create, BOXES},
                                         {"point_query", create, POINTS},
                                         {NULL, NULL, 0}};

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
    if (!box->kind->run(box->query.object, items, &found, &err))
        return class_push_failure(L, &err);
    return push_answer(L, box->kind, &found);
}

// query:run_itself(filters) -> hits, result
static int run_itself(lua_State *L)
{
    duet_error err = {0};
    answer found = {0};
    duet_box_query *query = class_object(L, 1, &boxes.class);
    const array *filters = lua_isnoneornil(L, 2) ? NULL : array_check(L, 2, ARRAY_FILTERS);
    if (!duet_box_query_run_itself(query, filters ? filters->rows : NULL, filters ? filters->n : 0,
                                   &found.boxes, &err))
        return class_push_failure(L, &err);
    return push_answer(L, &boxes, &found);
}

static const luaL_Reg methods[2] = {{"run", run}, {NULL, NULL}};
static const luaL_Reg box_methods[3] = {{"run", run}, {"run_itself", run_itself}, {NULL, NULL}};

void tree_query_open_lua(lua_State *L)
{
    for (int i = 0; i < N_KINDS; ++i)
        class_open(L, &kinds[i]->class);
}
