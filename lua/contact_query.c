// SPDX-License-Identifier: MIT
// device_pair:contact_query: where pairs of boxes touch.
#include "lua/nouns.h"

typedef struct query_box {
    lua_handle query;
    duet_shape shape;
} query_box;

CLASS_DESTROY(contact_query)
static const lua_class query_class = {
    .name = "duet.contact_query", .destroy = destroy_contact_query, .noun = "query"};

static const field def_fields[] = {
    FIELD(field_share, duet_contact_query_def, share),
    FIELDS(duet_contact_query_def, dims),
    FIELD_ENUM(duet_contact_query_def, shape, shape_name),
    FIELDS(duet_contact_query_def, margin),
    {0},
};

// device_pair:contact_query(def)
static int device_pair_contact_query(lua_State *L)
{
    duet_error err = {0};
    duet_contact_query_def def = duet_default_contact_query_def();
    def.pair = device_pair_check(L);
    field_read(L, 2, "a contact query", def_fields, &def);
    query_box *box = class_push_of(L, &query_class, sizeof *box, 1);
    box->shape = def.shape;
    box->query.object = duet_contact_query_create(&def, &err);
    return box->query.object ? 1 : class_push_failure(L, &err);
}

// query:run(objects, pairs) -> contacts, result
static int contact_query_run(lua_State *L)
{
    duet_error err = {0};
    duet_contact_query_result result = {0};
    const query_box *box = class_check(L, 1, &query_class);
    array_kind kind = shape_array_kind(box->shape);
    const array *objects = array_check(L, 2, kind);
    const array *pairs = array_check(L, 3, ARRAY_PAIRS);
    luaL_argcheck(L, objects->n <= UINT32_MAX, 2, "fewer than 2^32 rows");
    const duet_span spans[2] = {{pairs->rows, pairs->n}, {NULL, 0}};
    if (!duet_contact_query_run(box->query.object, array_object_kind(kind), objects->rows,
                                (uint32_t)objects->n, spans, &result, &err))
        return class_push_failure(L, &err);
    array_push_copy(L, ARRAY_CONTACTS, result.contacts, result.n_contacts);
    field_push_table(L, FIELD_LIST(duet_contact_query_result, touching, total_ms, device_ms),
                     &result);
    return 2;
}

const lua_noun contact_query_noun = {
    {&query_class},
    (const lua_method[]){METHODS(device_pair, contact_query), METHODS(contact_query, run), {0}}};
