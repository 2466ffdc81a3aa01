// SPDX-License-Identifier: MIT
// Contacts of pairs that a world found or the caller brings.
//
// Each device gets all objects, and its pairs a chunk at a time.
#include "base/budget.h"
#include "base/clock.h"
#include "base/error.h"
#include "runtime/narrowphase/rounded.h"
#include "runtime/opencl/shared_work.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

enum { COOKIE = 0x0d0e700f };

// Some 27 MB of contacts: launches cost nothing beside it, and few devices lack it.
enum { CHUNK = 1 << 18 };

// The points of a pair with an object that is no box, as in kernels/dynamics/contact_query.cl.
#define NO_BOX UINT32_MAX

static_assert(sizeof(duet_contact) == 26 * sizeof(uint32_t), "a row as the kernel writes it");
static_assert(offsetof(duet_contact, points) == 6 * sizeof(uint32_t), "points follow their number");

// One device, and what it does of a call: pairs first to last of both spans.
typedef struct side {
    work_side work;
    kernel *kernel;
    buffer objects, pairs, contacts;
    cl_uint n; // pairs that were launched last
    cl_float margin;
    uint32_t dims;
    duet_shape shape;

    const void *all_objects;
    uint32_t n_objects;
    const duet_span *spans;
    duet_contact *found; // all pairs' contacts
    uint64_t touching;
} side;

static const binding side_bindings[] = {BIND_BUFFER(side, "objects", "float *", objects),
                                        BIND_BUFFER(side, "pairs", "uint *", pairs),
                                        BIND_BUFFER(side, "contacts", "uint *", contacts),
                                        BIND_VALUE(side, "n", n),
                                        BIND_VALUE(side, "margin", margin),
                                        {0}};

struct duet_contact_query {
    shared_work work;
    side sides[2]; // A, B
    duet_contact *contacts;
    uint64_t capacity;
};

duet_contact_query_def duet_default_contact_query_def(void)
{
    return (duet_contact_query_def){.share = DUET_SHARE_DEFAULT, .dims = 3, .cookie = COOKIE};
}

// ---------------------------------------------------------------- objects

typedef struct shape_row {
    duet_object_kind kind;
    size_t width; // in bytes; 0: has no contacts
    const char *name;
} shape_row;

static const shape_row shape_rows[DUET_SHAPES] = {
    [DUET_SHAPE_POSES] = {DUET_OBJECT_POSES, sizeof(duet_pose), "poses"},
    [DUET_SHAPE_ROUNDED_BOXES] = {DUET_OBJECT_ROUNDED_BOXES, sizeof(duet_rounded_box),
                                  "rounded boxes"},
    [DUET_SHAPE_SPHERES] = {DUET_OBJECT_SPHERES, sizeof(duet_sphere), "spheres"},
};

static bool is_sound(const side *s, uint32_t id)
{
    const void *at = (const char *)s->all_objects + id * shape_rows[s->shape].width;
    if (s->shape == DUET_SHAPE_POSES)
        return narrow_is_box(at, s->dims);
    duet_rounded_box box =
        s->shape == DUET_SHAPE_SPHERES ? rounded_of_sphere(at) : *(const duet_rounded_box *)at;
    return rounded_is_sound(&box, s->dims);
}

// ---------------------------------------------------------------- owner

static bool check_def(const duet_contact_query_def *def, duet_error *err)
{
    if (!error_def(def && def->cookie == COOKIE, "query", "duet_default_contact_query_def", err) ||
        !error_def_pair(def->pair, "query", err) || !error_def_dims(def->dims, err))
        return false;
    if ((unsigned)def->shape >= DUET_SHAPES || shape_rows[def->shape].width == 0)
        return bad_argument(err,
                            "shape is %d; contacts are those of poses, rounded boxes or spheres",
                            (int)def->shape);
    if (!(def->margin >= 0.0f) || !isfinite(def->margin))
        return bad_argument(err, "margin is %g; expected 0 or a length above it",
                            (double)def->margin);
    return def->share == DUET_SHARE_DEFAULT || shared_work_check(def->share, err);
}

static bool open_side(side *s, const duet_contact_query_def *def, duet_error *err)
{
    const gen_setting settings[] = {
        {"DIMS", def->dims}, {"SHAPE", def->shape}, {"ROUNDED", def->shape != DUET_SHAPE_POSES}};
    s->dims = def->dims;
    s->shape = def->shape;
    s->margin = def->margin;
    if (!s->work.device)
        return true;
    s->kernel = program_set_kernel(s->work.programs, "contact_query", "contact_query", settings, 3,
                                   side_bindings, err);
    return s->kernel && program_set_build(s->work.programs, err);
}

duet_contact_query *duet_contact_query_create(const duet_contact_query_def *def, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!check_def(def, err))
        return NULL;
    duet_contact_query *query = calloc(1, sizeof *query);
    if (!query)
        return null_no_memory(err, "a query");
    side *a = &query->sides[0], *b = &query->sides[1];
    uint32_t share = def->share;
    if (share == DUET_SHARE_DEFAULT)
        share = duet_default_plan(def->pair).share;
    if (!shared_work_open(&query->work, def->pair, def->pair->kernel_dir, share, &a->work, &b->work,
                          err) ||
        !open_side(a, def, err) || !open_side(b, def, err)) {
        duet_contact_query_destroy(query);
        return NULL;
    }
    return query;
}

void duet_contact_query_destroy(duet_contact_query *query)
{
    if (!query)
        return;
    for (int which = 0; which < 2; ++which) {
        buffer_release(&query->sides[which].objects);
        buffer_release(&query->sides[which].pairs);
        buffer_release(&query->sides[which].contacts);
    }
    shared_work_close(&query->work);
    free(query->contacts);
    free(query);
}

// ---------------------------------------------------------------- a chunk

// A buffer over memory that is the caller's, or as large as it.
static bool send(side *s, buffer *b, const char *stage, const void *rows, size_t bytes)
{
    return buffer_hold(b, s->work.device, (void *)rows, bytes, &s->work.err) &&
           timeline_write(&s->work.times, stage, b, rows, bytes, &s->work.err);
}

static bool ask_device(side *s, const duet_pair *pairs, uint64_t first, uint32_t n)
{
    duet_contact *found = s->found + first;
    s->n = n;
    return send(s, &s->pairs, "send pairs", pairs, n * sizeof *pairs) &&
           buffer_hold(&s->contacts, s->work.device, found, n * sizeof *found, &s->work.err) &&
           timeline_launch(&s->work.times, "contacts", s->kernel, n, s, &s->work.err) &&
           timeline_read(&s->work.times, "fetch contacts", &s->contacts, found, n * sizeof *found,
                         &s->work.err);
}

static bool refuse(side *s, uint64_t i)
{
    const duet_contact *c = &s->found[i];
    return error_set(&s->work.err, DUET_STATUS_BAD_OBJECT,
                     "object %u of %u is not a number, infinite, negative or without rotation",
                     is_sound(s, c->a) ? c->b : c->a, s->n_objects);
}

static bool look_at_chunk(side *s, const duet_pair *pairs, uint64_t first, uint32_t n)
{
    if (!budget_check(&s->work.err) || !ask_device(s, pairs, first, n))
        return false;
    for (uint64_t i = first; i < first + n; ++i) {
        if (s->found[i].n == NO_BOX)
            return refuse(s, i);
        s->touching += s->found[i].n > 0;
    }
    return true;
}

// ---------------------------------------------------------------- all pairs

// The pairs of a span that are the side's; `before` are in the spans before it.
static bool look_at_span(side *s, const duet_span *span, uint64_t before)
{
    uint64_t end = s->work.last < before + span->n ? s->work.last : before + span->n;
    bool ok = true;
    for (uint64_t at = s->work.first > before ? s->work.first : before; ok && at < end;
         at += CHUNK) {
        uint32_t n = end - at < CHUNK ? (uint32_t)(end - at) : CHUNK;
        ok = look_at_chunk(s, span->pairs + (at - before), at, n);
    }
    return ok;
}

// The caller may free what was wrapped.
static void give_back(side *s)
{
    buffer *const all[] = {&s->objects, &s->pairs, &s->contacts};
    for (size_t i = 0; i < sizeof all / sizeof *all; ++i)
        if (all[i]->borrowed)
            buffer_release(all[i]);
}

static bool look_at_part(work_side *w)
{
    side *s = (side *)w;
    size_t bytes = s->n_objects * shape_rows[s->shape].width;
    return send(s, &s->objects, "send objects", s->all_objects, bytes) &&
           look_at_span(s, &s->spans[0], 0) && look_at_span(s, &s->spans[1], s->spans[0].n);
}

static bool check_pairs(const duet_span *span, uint32_t n, uint64_t before, duet_error *err)
{
    for (uint64_t i = 0; i < span->n; ++i) {
        duet_pair p = span->pairs[i];
        if (p.a >= n || p.b >= n || p.a == p.b)
            return bad_argument(err, "pair %llu is of objects %u and %u; expected two of %u",
                                (unsigned long long)(before + i), p.a, p.b, n);
    }
    return true;
}

static bool check_rows(const void *objects, const duet_span spans[2], uint32_t n, duet_error *err)
{
    for (int k = 0; k < 2; ++k)
        if (spans[k].n > 0 && (!spans[k].pairs || !objects))
            return bad_argument(err, "%llu pairs, but no %s", (unsigned long long)spans[k].n,
                                objects ? "rows of them" : "objects");
    return check_pairs(&spans[0], n, 0, err) && check_pairs(&spans[1], n, spans[0].n, err);
}

static bool reserve_contacts(duet_contact_query *query, uint64_t n, duet_error *err)
{
    if (n <= query->capacity)
        return true;
    free(query->contacts);
    query->capacity = 0;
    bool fits = n <= SIZE_MAX / sizeof *query->contacts;
    query->contacts = fits ? malloc((size_t)n * sizeof *query->contacts) : NULL;
    if (!query->contacts)
        return no_memory(err, "%llu contacts", (unsigned long long)n);
    query->capacity = n;
    return true;
}

static bool check_kind(const duet_contact_query *query, duet_object_kind kind, duet_error *err)
{
    const shape_row *row = &shape_rows[query->sides[0].shape];
    return kind == row->kind ||
           bad_argument(err, "objects of kind %d; the query is of %s", (int)kind, row->name);
}

bool duet_contact_query_run(duet_contact_query *query, duet_object_kind kind, const void *objects,
                            uint32_t n, const duet_span spans[2], duet_contact_query_result *result,
                            duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_given(query, __func__, "query", err) ||
        !error_given(spans, __func__, "spans", err) ||
        !error_given(result, __func__, "result", err))
        return false;
    uint64_t begun = clock_steady_ns();
    uint64_t n_pairs = spans[0].n + spans[1].n;
    if (!check_kind(query, kind, err) || !check_rows(objects, spans, n, err) ||
        !reserve_contacts(query, n_pairs, err))
        return false;
    side *a = &query->sides[0], *b = &query->sides[1];
    for (int which = 0; which < 2; ++which) {
        side *s = &query->sides[which];
        s->all_objects = objects;
        s->n_objects = n;
        s->spans = spans;
        s->found = query->contacts;
        s->touching = 0;
    }
    bool ok = shared_work_run(&query->work, n_pairs, look_at_part, err);
    give_back(a);
    give_back(b);
    if (!ok)
        return false;
    *result = (duet_contact_query_result){.contacts = query->contacts,
                                          .n_contacts = n_pairs,
                                          .touching = a->touching + b->touching,
                                          .total_ms = clock_ms_since(begun),
                                          .device_ms = {a->work.wall_ms, b->work.wall_ms}};
    return true;
}
