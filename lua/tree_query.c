// SPDX-License-Identifier: MIT
// tree:ray_query, :sweep_query, :box_query and :point_query: what is asked of a tree. They differ
// in the arrays that they take and give.
#include "lua/nouns.h"
#include "runtime/queries/any_query.h"

// A script's form of a def.
typedef struct query_def {
    any_query_def asked;
    duet_filter filter;
} query_def;

// { group, mask }
static void read_filter(lua_State *L, const field *f, void *at)
{
    query_def *def = at;
    uint32_t *const words[] = {&def->filter.group, &def->filter.mask};
    if (!lua_istable(L, -1) || lua_rawlen(L, -1) != 2)
        field_refuse(L, f, "{ group, mask }");
    for (int i = 0; i < 2; ++i) {
        lua_rawgeti(L, -1, i + 1);
        field_count.read(L, f, words[i]);
        lua_pop(L, 1);
    }
    def->asked.filter = &def->filter;
}

static const field_type field_filter = {.read = read_filter};

#define WANTS FIELD_ENUM_AT("wants", query_def, asked.name.wants, query_wants_name)
#define FILTER                                                            \
    {                                                                     \
        .name = "filter", .type = &field_filter, .size = sizeof(uint32_t) \
    }

static const field ray_fields[] = {
    WANTS,
    FIELD_AT("normals", field_bool, query_def, asked.normals),
    FILTER,
    {0},
};
static const field sweep_fields[] = {
    WANTS,
    FILTER,
    {0},
};
static const field box_fields[] = {
    FIELD_ENUM_AT("level", query_def, asked.level, level_name),
    FILTER,
    {0},
};
static const field point_fields[] = {
    FIELD_AT("nearest", field_count, query_def, asked.name.nearest),
    FILTER,
    {0},
};

typedef struct query_kind {
    lua_class class;
    const char *noun;                  // "a ray query", in messages
    const field *fields;               // query_def's
    array_kind takes[DUET_SHAPES + 1]; // by the tree's shape
    array_kind gives;
} query_kind;

typedef struct query_box {
    lua_handle query;
    query_item item;
    array_kind takes;
} query_box;

// ---------------------------------------------------------------- the four

static void destroy(void *query)
{
    any_query_destroy(query);
}

#define QUERY_CLASS(name_)                                   \
    {                                                        \
        .name = (name_), .destroy = destroy, .noun = "query" \
    }

static const query_kind kinds[] = {
    [QUERY_RAYS] = {QUERY_CLASS("duet.ray_query"),
                    "a ray query",
                    ray_fields,
                    {ARRAY_RAYS, ARRAY_RAYS, ARRAY_RAYS, ARRAY_RAYS, ARRAY_LARGE_RAYS},
                    ARRAY_HITS},
    [QUERY_SWEEPS] = {QUERY_CLASS("duet.sweep_query"),
                      "a sweep query",
                      sweep_fields,
                      {[DUET_SHAPE_POSES] = ARRAY_SWEEPS,
                       [DUET_SHAPE_BOUNDS] = ARRAY_BOUNDS_SWEEPS,
                       [DUET_SHAPE_ROUNDED_BOXES] = ARRAY_ROUNDED_SWEEPS,
                       [DUET_SHAPE_SPHERES] = ARRAY_SPHERE_SWEEPS,
                       [TREE_LARGE_POSES] = ARRAY_LARGE_SWEEPS},
                      ARRAY_SWEEP_HITS},
    [QUERY_BOXES] = {QUERY_CLASS("duet.box_query"),
                     "a box query",
                     box_fields,
                     {[DUET_SHAPE_POSES] = ARRAY_POSES,
                      [DUET_SHAPE_BOUNDS] = ARRAY_BOUNDS,
                      [DUET_SHAPE_ROUNDED_BOXES] = ARRAY_ROUNDED_BOXES,
                      [DUET_SHAPE_SPHERES] = ARRAY_SPHERES,
                      [TREE_LARGE_POSES] = ARRAY_LARGE_POSES},
                     ARRAY_BOX_HITS},
    [QUERY_POINTS] = {QUERY_CLASS("duet.point_query"),
                      "a point query",
                      point_fields,
                      {ARRAY_POINTS, ARRAY_POINTS, ARRAY_POINTS, ARRAY_POINTS, ARRAY_LARGE_POINTS},
                      ARRAY_POINT_HITS},
};

enum { N_KINDS = sizeof kinds / sizeof *kinds };

static query_box *check(lua_State *L)
{
    for (int i = 0; i < N_KINDS; ++i)
        if (luaL_testudata(L, 1, kinds[i].class.name))
            return class_check(L, 1, &kinds[i].class);
    luaL_typeerror(L, 1, "duet query");
    return NULL;
}

// tree:ray_query(def) and the others; the upvalue is the query_item.
static int create(lua_State *L)
{
    duet_error err = {0};
    query_item item = (query_item)lua_tointeger(L, lua_upvalueindex(1));
    const query_kind *kind = &kinds[item];
    query_def def = {.asked = {.name = {.item = item}}};
    duet_tree *tree = tree_check(L);
    field_read(L, 2, kind->noun, kind->fields, &def);
    query_box *box = class_push_of(L, &kind->class, sizeof *box, 1);
    box->item = item;
    box->takes = kind->takes[tree_shape(L)];
    box->query.object = any_query_create(tree, &def.asked, &err);
    return box->query.object ? 1 : class_push_failure(L, &err);
}

static int push_found(lua_State *L, query_item item, const query_result *found)
{
    array_push_copy(L, kinds[item].gives, found->hits, found->n_hits);
    field_push_table(L, FIELD_LIST(query_result, undecided, total_ms, device_ms), found);
    if (found->normals) {
        array_push_copy(L, ARRAY_POINTS, found->normals, found->n_hits);
        lua_setfield(L, -2, "normals");
    }
    return 2;
}

// query:run(items) -> hits, result
static int run(lua_State *L)
{
    duet_error err = {0};
    query_result found;
    const query_box *box = check(L);
    const array *items = array_check(L, 2, box->takes);
    if (!any_query_run(box->query.object, items->rows, items->n, &found, &err))
        return class_push_failure(L, &err);
    return push_found(L, box->item, &found);
}

// query:run_itself(filters) -> hits, result
static int run_itself(lua_State *L)
{
    duet_error err = {0};
    query_result found;
    any_query *query = class_object(L, 1, &kinds[QUERY_BOXES].class);
    const array *filters = lua_isnoneornil(L, 2) ? NULL : array_check(L, 2, ARRAY_FILTERS);
    if (!any_query_run_itself(query, filters ? filters->rows : NULL, filters ? filters->n : 0,
                              &found, &err))
        return class_push_failure(L, &err);
    return push_found(L, QUERY_BOXES, &found);
}

const lua_noun tree_query_noun = {
    {&kinds[QUERY_RAYS].class, &kinds[QUERY_SWEEPS].class, &kinds[QUERY_BOXES].class,
     &kinds[QUERY_POINTS].class},
    (const lua_method[]){{"duet.tree:ray_query", create, QUERY_RAYS},
                         {"duet.tree:sweep_query", create, QUERY_SWEEPS},
                         {"duet.tree:box_query", create, QUERY_BOXES},
                         {"duet.tree:point_query", create, QUERY_POINTS},
                         {"duet.ray_query:run", run, 0},
                         {"duet.sweep_query:run", run, 0},
                         {"duet.box_query:run", run, 0},
                         {"duet.point_query:run", run, 0},
                         {"duet.box_query:run_itself", run_itself, 0},
                         {0}}};
