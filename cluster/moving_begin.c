// SPDX-License-Identifier: MIT
// A scene's bodies are divided among domains. Rank 0 reads the scene, and tells the others what
// follows from all of it (effects, margins, substeps), which is the same on all ranks. Bodies go to
// their domains some at a time, so no other rank ever has more than its own.
#include "cluster/moving_domains.h"

#include "base/error.h"
#include "runtime/dynamics/motion_commands.h"
#include "runtime/dynamics/motion_create.h"
#include "runtime/narrowphase/mesh.h"
#include "runtime/scene/scene_bodies.h"

#include <stdlib.h>

// Bodies that rank 0 makes at one time.
enum { CHUNK = 1 << 18 };

// ---------------------------------------------------------------- the whole, on rank 0

static duet_motion *know_objects(const duet_scene *scene, duet_device_pair *pair, duet_error *own)
{
    duet_motion_def def = duet_scene_motion_def(scene, pair);
    scene_bodies b;
    duet_motion *known = NULL;
    if (scene_bodies_take(&b, scene, NULL, own))
        known = motion_know(&def, b.poses, b.large_poses, b.bodies, b.n, own);
    scene_bodies_free(&b);
    return known;
}

// The motion of all bodies, without a device. NULL after a failure.
static duet_motion *know_scene(const moving_start *start, duet_error *own)
{
    duet_scene *scene = duet_scene_load(start->path, start->settings, start->n_settings, own);
    duet_motion *known = scene ? know_objects(scene, start->pair, own) : NULL;
    duet_scene_destroy(scene);
    return known;
}

// Whether rank 0 has all bodies on a device before they are divided: those of a file, in origin
// cells, or to be taken apart.
static bool begins_on_device(const duet_motion_def *def, const moving_start *start)
{
    return start->resume || def->origin_edge > 0.0f || (def->wants & DUET_EFFECT_DEPENETRATION);
}

// One domain alone takes its bodies apart in its first step.
static void open_known(duet_motion *known, const moving_start *start, bool is_alone,
                       duet_error *own)
{
    if (start->plan)
        known->def.plan = *start->plan;
    bool ok =
        motion_open(known, own) && (!start->resume || duet_motion_load(known, start->resume, own));
    if (ok && start->resume)
        domain_forget_idle_commands(known);
    if (ok && !is_alone)
        domain_begin_apart(known, own);
}

// ---------------------------------------------------------------- the whole, on all ranks

// The scene as rank 0 tells the others of it.
typedef struct moving_whole {
    duet_motion_def def;  // its pair, plan and ground are rank 0's alone
    duet_heights heights; // nx 0: none
    duet_mesh mesh;       // n_triangles 0: none
    effect_facts facts;
    double extent;
    cl_int4 base; // the origin cell that others are counted from
    uint32_t n_all;
    uint64_t step;
    bool keeps_commands; // of a file
} moving_whole;

static moving_whole whole_of(const duet_motion *known)
{
    moving_whole w = {.def = known->def,
                      .facts = known->facts,
                      .extent = known->extent,
                      .n_all = known->n,
                      .step = known->step,
                      .keeps_commands = known->commands};
    if (known->def.heights)
        w.heights = *known->def.heights;
    if (known->def.mesh)
        w.mesh = *known->def.mesh;
    if (known->cells)
        w.base = known->cells[0];
    return w;
}

void *moving_tell(const moving *m, const void *of_rank_0, size_t bytes, duet_error *own)
{
    if (bytes == 0 || !is_well(own))
        return NULL;
    void *copy = malloc(bytes);
    if (!copy)
        no_memory(own, "what rank 0 tells");
    else if (m->ranks->self == 0)
        memcpy(copy, of_rank_0, bytes);
    if (ranks_agree(m->ranks, is_well(own), own))
        ranks_broadcast(m->ranks, copy, bytes);
    return copy;
}

static void tell_ground(const moving *m, moving_whole *w, duet_error *own)
{
    duet_heights *h = &w->heights;
    duet_mesh *mesh = &w->mesh;
    h->heights = moving_tell(m, h->heights, (size_t)h->nx * h->ny * sizeof *h->heights, own);
    mesh->vertices = moving_tell(m, mesh->vertices, mesh_vertex_bytes(mesh), own);
    mesh->triangles = moving_tell(m, mesh->triangles, mesh_triangle_bytes(mesh), own);
}

static void free_ground(const moving_whole *w)
{
    free((void *)w->heights.heights);
    free((void *)w->mesh.vertices);
    free((void *)w->mesh.triangles);
}

static void take_whole(moving *m, const moving_whole *w, const moving_start *start)
{
    m->def = w->def;
    m->def.pair = start->pair;
    m->def.plan = start->plan ? *start->plan : duet_default_plan(start->pair);
    m->def.heights = w->heights.nx > 0 ? &w->heights : NULL;
    m->def.mesh = w->mesh.n_triangles > 0 ? &w->mesh : NULL;
    m->facts = w->facts;
    m->extent = w->extent;
    m->base = w->base;
    m->n_all = w->n_all;
    m->counts.bodies = w->n_all;
    m->counts.step = w->step;
    m->keeps_commands = w->keeps_commands;
    m->n_commands = w->keeps_commands; // the file may be of a motion that was given some
}

duet_motion *moving_create(const moving *m, duet_error *own)
{
    duet_motion *motion = domain_create(&m->def, &m->facts, m->extent, own);
    if (motion)
        motion->step = m->counts.step;
    if (motion)
        moving_keep_base(m, motion);
    if (motion && m->keeps_commands)
        motion_begin_commands(motion, own);
    return motion;
}

// One rank of a host builds kernels, and the others wait.
static void open_domains(moving *m, duet_error *own)
{
    ranks_await_turn(m->ranks, true);
    m->domains = calloc(m->parts, sizeof *m->domains);
    if (!m->domains)
        no_memory(own, "%u domains", m->parts);
    for (uint32_t k = 0; is_well(own) && k < m->parts; ++k) {
        m->domains[k].number = (uint32_t)m->ranks->self * m->parts + k;
        m->domains[k].reach = extent_none;
        m->domains[k].motion = moving_create(m, own);
    }
    ranks_end_turn(m->ranks);
}

static void measure_rows(moving *m)
{
    const duet_motion *first = m->domains[0].motion;
    m->def = first->def; // whose ground is a copy
    m->every = first->plan.colours > 0 ? first->plan.colours : 1;
    m->trial.is_fixed = first->plan.colours > 0;
    m->least_inner = halo_least_inner(m->ranks);
    m->traveller_bytes = sizeof(moving_traveller) + domain_state_bytes(first);
    m->contact_bytes = sizeof(moving_contact) + first->layout.record * sizeof(float);
}

static bool open_all(moving *m, const duet_motion *known, const moving_start *start,
                     duet_error *own)
{
    moving_whole w = {0};
    if (known)
        w = whole_of(known);
    ranks_broadcast(m->ranks, &w, sizeof w);
    tell_ground(m, &w, own);
    bool ok = is_well(own);
    if (ok) {
        take_whole(m, &w, start);
        open_domains(m, own);
        if (is_well(own))
            measure_rows(m);
        ok = bisection_begin(&m->cuts, m->n_domains, own);
        ok = ranks_agree(m->ranks, is_well(own), own);
    }
    free_ground(&w);
    return ok;
}

void moving_end_domain(moving_domain *d)
{
    free(d->bodies.rows);
    free(d->index.firsts);
    free(d->gone.rows);
    free(d->came.items);
    free(d->contacts.items);
    free(d->places);
    free(d->neighbours.rows);
    domain_contacts_free(&d->told);
    free(d->waiting.rows);
    free(d->in_order.rows);
}

// ---------------------------------------------------------------- bodies, from rank 0

// Bodies [first, first + n) of the whole, as if they were the first domain's own; `reader` has
// them.
static bool begin_some(const moving *m, duet_motion *reader, uint32_t first, uint32_t n,
                       moving_domain *some, duet_error *own)
{
    *some = (moving_domain){.motion = reader, .number = m->domains[0].number, .n_own = n};
    some->bodies.rows = malloc(((size_t)n + 1) * sizeof *some->bodies.rows);
    if (!some->bodies.rows)
        return no_memory(own, "%u bodies", n);
    for (uint32_t i = 0; i < n; ++i)
        some->bodies.rows[i] = (moving_body){.id = first + i, .own = some->number, .complete = 1};
    some->bodies.n = n;
    return true;
}

static void add_bodies(moving *m, duet_motion *reader, uint32_t first, uint32_t n,
                       item_list *bodies, duet_error *own)
{
    moving_domain some;
    row_list places = {0};
    if (begin_some(m, reader, first, n, &some, own))
        moving_read_all(m, &some, &places, bodies, own);
    moving_end_domain(&some);
    free(places.rows);
}

// Before any body is there: by where the scene has them.
static bool cut_scene(moving *m, const duet_motion *known, duet_error *own)
{
    item_list points = {0};
    uint64_t every = moving_sampled(known ? known->n : 0);
    for (uint32_t i = 0; known && i < known->n; i += (uint32_t)every) {
        const float *c = known->poses[i].centre;
        const bisection_point point = {
            .at = {c[0] + m->def.origin[0], c[1] + m->def.origin[1], c[2] + m->def.origin[2]},
            .weight = (double)every};
        list_add(&points, &point, 1, sizeof point);
    }
    bool ok = moving_cut_by(m, &points, own);
    free(points.items);
    return ok;
}

static bool begin_bodies(moving *m, const duet_motion *known, duet_error *own)
{
    item_list bodies = {0};
    bool ok = cut_scene(m, known, own);
    for (uint32_t first = 0, n; ok && first < m->n_all; first += n) {
        n = m->n_all - first < CHUNK ? m->n_all - first : CHUNK;
        duet_motion *reader = m->domains[0].motion;
        if (known &&
            domain_begin_bodies(reader, known->poses + first, known->bodies + first, n, own))
            add_bodies(m, reader, first, n, &bodies, own);
        ok = moving_migrate(m, &bodies, own);
        list_clear(&bodies);
    }
    free(bodies.items);
    return ok;
}

// Before the first step nothing touched.
static void forget_told(const moving *m, const item_list *contacts)
{
    for (uint64_t i = 0; m->counts.step == 0 && i < contacts->n; ++i)
        moving_contact_at(m, contacts, i)->told_by = TOLD_BY_NONE;
}

// Reads all bodies, and the contacts that go with them.
static void read_whole(moving *m, moving_domain *all, item_list *bodies, item_list *contacts,
                       duet_error *own)
{
    row_list places = {0};
    moving_read_all(m, all, &places, bodies, own);
    for (uint64_t i = 0; is_well(own) && !bodies->failed && i < bodies->n; ++i)
        all->bodies.rows[i].next = moving_traveller_at(m, bodies, i)->domain;
    if (is_well(own) && moving_touches(m))
        moving_read_contacts(m, all, contacts, own);
    free(places.rows);
}

static bool deal_bodies(moving *m, duet_motion *known, item_list *bodies, item_list *contacts,
                        duet_error *own)
{
    moving_domain all = {0};
    if (known)
        begin_some(m, known, 0, known->n, &all, own);
    bool ok = moving_cut(m, &all, known ? 1 : 0, own);
    if (ok && known)
        read_whole(m, &all, bodies, contacts, own);
    moving_end_domain(&all);
    forget_told(m, contacts);
    for (uint32_t k = 0; k < m->parts; ++k)
        forget_told(m, &m->domains[k].contacts);
    return ok;
}

// ---------------------------------------------------------------- all of it

static bool fill(moving *m, duet_motion *known, const moving_start *start, duet_error *own)
{
    item_list bodies = {0}, contacts = {0};
    bool ok = open_all(m, known, start, own) &&
              (begins_on_device(&m->def, start) ? deal_bodies(m, known, &bodies, &contacts, own)
                                                : begin_bodies(m, known, own)) &&
              moving_exchange(m, &bodies, &contacts, own);
    free(bodies.items);
    free(contacts.items);
    return ok;
}

moving *moving_begin(ranks *r, const moving_start *start, duet_error *own)
{
    moving *m = calloc(1, sizeof *m);
    duet_motion *known = NULL;
    if (!m)
        no_memory(own, "a motion over ranks");
    if (is_well(own) && r->self == 0)
        known = know_scene(start, own);
    if (is_well(own) && known && begins_on_device(&known->def, start))
        open_known(known, start, start->parts == 1 && r->n == 1, own);
    bool ok = ranks_agree(r, is_well(own), own);
    if (ok) {
        m->ranks = r;
        m->parts = start->parts;
        m->n_domains = m->parts * (uint32_t)r->n;
        m->balance.model = work_begin();
        ok = fill(m, known, start, own);
        if (ok)
            moving_begin_phases(m);
    }
    duet_motion_destroy(known);
    if (ok)
        return m;
    moving_end(m);
    return NULL;
}

void moving_end(moving *m)
{
    if (!m)
        return;
    for (uint32_t k = 0; m->domains && k < m->parts; ++k) {
        duet_motion_destroy(m->domains[k].motion);
        moving_end_domain(&m->domains[k]);
    }
    free(m->domains);
    free(m->reaches);
    halo_end(&m->halo);
    moving_events_end(&m->events);
    bisection_end(&m->cuts);
    free(m);
}

moving_counts moving_get_counts(const moving *m)
{
    return m->counts;
}

const moving_phases *moving_get_phases(const moving *m)
{
    return &m->phases;
}

duet_motion *moving_get_motion(const moving *m, uint32_t k)
{
    return m->domains[k].motion;
}

void moving_get_own_ids(const moving *m, uint32_t k, uint64_t *ids)
{
    const moving_domain *d = &m->domains[k];
    for (uint64_t i = 0; i < d->bodies.n; ++i) {
        const moving_body *b = &d->bodies.rows[i];
        ids[i] = moving_is_own(d, b) ? b->id : DUET_NO_BODY;
    }
}
