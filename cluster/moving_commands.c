// SPDX-License-Identifier: MIT
#include "cluster/moving_commands.h"

#include "base/error.h"
#include "cluster/moving_domains.h"
#include "cluster/parcels.h"
#include "runtime/commands/commands.h"
#include "runtime/dynamics/domain_commands.h"
#include "runtime/dynamics/motion_commands.h"

#include <stdlib.h>

// ---------------------------------------------------------------- what rank 0 gives

// A command as all ranks know it, in memory of their own.
typedef struct shared_command {
    command c;
    uint64_t *ids;
    void *rows;
    duet_body *bodies;
} shared_command;

typedef struct command_head {
    uint32_t n, first, fields;
    bool has_ids, has_bodies;
} command_head;

static void free_shared(shared_command *s)
{
    free(s->ids);
    free(s->rows);
    free(s->bodies);
}

// Pairs are each rank's own.
static void take_pair(const moving *m, const shared_command *s)
{
    if (s->c.op->form == COMMAND_DEF && s->rows && m->ranks->self != 0)
        ((duet_motion_def *)s->rows)->pair = m->def.pair;
}

static void share(const moving *m, const command *c, shared_command *s, duet_error *own)
{
    command_head h = {.n = c->list.n,
                      .first = c->list.first,
                      .fields = c->fields,
                      .has_ids = c->list.ids,
                      .has_bodies = c->new_bodies};
    ranks_broadcast(m->ranks, &h, sizeof h);
    s->ids = moving_tell(m, c->list.ids, h.has_ids ? h.n * sizeof *s->ids : 0, own);
    s->rows = moving_tell(m, c->rows, h.n * c->op->row, own);
    s->bodies = moving_tell(m, c->new_bodies, h.has_bodies ? h.n * sizeof *s->bodies : 0, own);
    s->c = (command){.op = c->op,
                     .call = c->call,
                     .list = {.ids = s->ids, .first = h.first, .n = h.n},
                     .fields = h.fields,
                     .rows = s->rows,
                     .new_bodies = s->bodies};
    take_pair(m, s);
}

// ---------------------------------------------------------------- places of those that come

typedef LIST_OF(uint64_t, ids) id_list;

// The ids that bodies in the n lowest empty places of a domain would have.
static void list_empty(const moving_domain *d, uint32_t n, id_list *empty)
{
    const motion_commands *c = d->motion->commands;
    for (uint64_t i = 0, found = 0; i < d->bodies.n && found < n; ++i) {
        const moving_body *b = &d->bodies.rows[i];
        const uint64_t id = (uint64_t)c->generations[i] << 32 | b->id;
        if (c->states[i] != PLACE_EMPTY || !moving_is_own(d, b))
            continue;
        list_add(&empty->list, &id, 1, sizeof id);
        ++found;
    }
}

static int compare_places(const void *left, const void *right)
{
    uint64_t a, b;
    memcpy(&a, left, sizeof a);
    memcpy(&b, right, sizeof b);
    return (uint32_t)a < (uint32_t)b ? -1 : (uint32_t)a > (uint32_t)b;
}

// The lowest empty places, and then new ones.
static void take_lowest(const moving *m, parcels *empty, uint64_t *ids, uint32_t n)
{
    uint64_t *all = empty->rows;
    if (empty->n > 0)
        qsort(all, empty->n, sizeof *all, compare_places);
    for (uint32_t i = 0; i < n; ++i)
        ids[i] = i < empty->n ? all[i] : m->n_all + (i - (uint32_t)empty->n);
}

// Returns the ids of those that come, ascending by place, on all ranks.
static uint64_t *choose_ids(const moving *m, const command *c, duet_error *own)
{
    const uint32_t n = c->list.n;
    id_list empty = {0};
    parcels in = {0};
    uint64_t *ids = malloc((size_t)n * sizeof *ids + 1);
    if (!ids)
        no_memory(own, "%u ids in %s", n, c->call);
    for (uint32_t k = 0; k < m->parts; ++k)
        list_empty(&m->domains[k], n, &empty);
    if (is_well(own) && empty.failed)
        no_memory(own, "empty places in %s", c->call);
    const parcels_def out = {.n = empty.n, .row_bytes = sizeof *ids, .rows = empty.ids};
    bool ok = parcels_deal(m->ranks, is_well(own), &out, &in, own);
    if (ok && m->ranks->self == 0)
        take_lowest(m, &in, ids, n);
    if (ok && n > 0)
        ranks_broadcast(m->ranks, ids, n * sizeof *ids);
    if (ok && n > 0 && (uint32_t)ids[n - 1] >= MOTION_MOST)
        error_set(own, DUET_STATUS_TOO_MANY, "%s: a motion has at most %u places", c->call,
                  MOTION_MOST);
    free(empty.ids);
    parcels_end(&in);
    return ids;
}

// ---------------------------------------------------------------- parts

// A domain's part of a command, in memory of its own.
typedef struct command_part {
    command c;
    uint32_t *of;
    uint64_t *ids;
    unsigned char *rows;
    duet_body *bodies;
    uint64_t n_new; // of those that come: bodies in places that no motion had
    duet_error err;
    uint32_t blamed; // the listed body that err names
} command_part;

static void free_part(command_part *p)
{
    command_close(&p->c);
    free(p->of);
    free(p->ids);
    free(p->rows);
    free(p->bodies);
}

static bool reserve_part(command_part *p, const command *c, duet_error *own)
{
    const size_t n = (size_t)c->list.n + 1;
    p->c = (command){.op = c->op, .call = c->call, .fields = c->fields, .n_all = c->list.n};
    p->c.of = p->of = malloc(n * sizeof *p->of);
    p->c.list.ids = p->ids = malloc(n * sizeof *p->ids);
    p->c.places = malloc(n * sizeof *p->c.places);
    p->c.rows = p->rows = malloc(n * c->op->row + 1);
    p->bodies = c->new_bodies ? malloc(n * sizeof *p->bodies) : NULL;
    p->c.new_bodies = p->bodies;
    p->c.blamed = &p->blamed;
    return (p->of && p->ids && p->c.places && p->rows && (p->bodies || !c->new_bodies)) ||
           no_memory(own, "%u bodies in %s", c->list.n, c->call);
}

static void add_to_part(command_part *p, const command *c, uint32_t i, uint32_t place, uint64_t id)
{
    const uint32_t k = p->c.list.n++;
    const size_t row = c->op->row;
    p->of[k] = i;
    p->ids[k] = id;
    p->c.places[k] = place;
    if (row > 0)
        memcpy(p->rows + k * row, (const unsigned char *)c->rows + i * row, row);
    if (p->bodies)
        p->bodies[k] = c->new_bodies[i];
}

// Lists those bodies of the command that are here, as own bodies or as ghosts.
static void list_part(const moving *m, const moving_domain *d, const command *c, command_part *p)
{
    for (uint32_t i = 0; is_well(&p->err) && i < c->list.n; ++i) {
        uint64_t id = c->list.ids ? c->list.ids[i] : c->list.first + (uint64_t)i;
        uint32_t place = moving_place(d, (uint32_t)id);
        if (!command_check_id(c, i, m->n_all, &p->err))
            p->blamed = i;
        if (!is_well(&p->err) || place == UINT32_MAX)
            continue;
        if (!c->list.ids)
            id |= motion_id_at(d->motion, place) & ~(uint64_t)UINT32_MAX;
        add_to_part(p, c, i, place, id);
        command_check_place(d->motion, &p->c, p->c.list.n - 1, place, &p->err);
    }
}

// The domain in whose box a pose is, as far as float tells: bodies are exchanged before they move.
static uint32_t domain_at(const moving *m, const duet_pose *pose)
{
    const float *c = pose->centre;
    const double at[3] = {c[0] + m->def.origin[0], c[1] + m->def.origin[1],
                          c[2] + m->def.origin[2]};
    return bisection_part(&m->cuts, at);
}

// An empty place is filled in the domain that has it.
static void list_coming(const moving *m, const moving_domain *d, const command *c,
                        const uint64_t *ids, command_part *p)
{
    for (uint32_t i = 0; i < c->list.n; ++i) {
        uint32_t place = moving_place(d, (uint32_t)ids[i]);
        if ((uint32_t)ids[i] < m->n_all && moving_owns(d, place))
            add_to_part(p, c, i, place, ids[i]);
        else if ((uint32_t)ids[i] >= m->n_all &&
                 domain_at(m, (const duet_pose *)c->rows + i) == d->number)
            add_to_part(p, c, i, (uint32_t)(d->bodies.n + p->n_new++), ids[i]);
    }
}

// A part of the world's def is all of it.
static void take_world(const command *c, command_part *p)
{
    p->c.list.n = 1;
    memcpy(p->rows, c->rows, c->op->row);
}

static void make_part(const moving *m, const moving_domain *d, const command *c,
                      const uint64_t *ids, command_part *p)
{
    if (!reserve_part(p, c, &p->err))
        return;
    if (c->op->form == COMMAND_DEF)
        take_world(c, p);
    else if (c->op->form == COMMAND_ADD)
        list_coming(m, d, c, ids, p);
    else
        list_part(m, d, c, p);
}

// A domain that is given nothing of a list looks at nothing.
static void look_at(const moving_domain *d, const command *c, command_part *p)
{
    if (p->c.list.n > 0 || c->list.n == 0)
        command_look(d->motion, &p->c, &p->err);
}

// Tells the failure that names the first body of the list. Collective.
static bool agree_on_parts(const moving *m, command_part *parts, duet_error *own)
{
    uint64_t mine = UINT64_MAX, first;
    for (uint32_t k = 0; k < m->parts; ++k)
        if (!is_well(&parts[k].err) && parts[k].blamed < mine) {
            mine = parts[k].blamed;
            *own = parts[k].err;
        }
    first = mine;
    ranks_least(m->ranks, &first, 1);
    if (mine > first)
        *own = (duet_error){0};
    return ranks_agree(m->ranks, is_well(own), own);
}

static bool check_parts(const moving *m, const command *c, const uint64_t *ids, command_part *parts,
                        duet_error *own)
{
    for (uint32_t k = 0; k < m->parts; ++k)
        make_part(m, &m->domains[k], c, ids, &parts[k]);
    if (!agree_on_parts(m, parts, own))
        return false;
    for (uint32_t k = 0; k < m->parts; ++k)
        look_at(&m->domains[k], c, &parts[k]);
    return agree_on_parts(m, parts, own);
}

// ---------------------------------------------------------------- effects

enum { MOST_FACTS = 32 };

// Facts that any rank's bodies have.
static effect_facts facts_of_all(const moving *m, effect_facts facts)
{
    uint64_t having[MOST_FACTS];
    for (uint32_t i = 0; i < MOST_FACTS; ++i)
        having[i] = facts >> i & 1u;
    ranks_sum(m->ranks, having, MOST_FACTS);
    for (uint32_t i = 0; i < MOST_FACTS; ++i)
        facts |= having[i] > 0 ? 1u << i : 0;
    return facts;
}

static bool find_facts(const moving *m, command_part *parts, effect_facts *facts, duet_error *own)
{
    const duet_motion *first = m->domains[0].motion;
    *facts = m->facts;
    for (uint32_t k = 0; k < m->parts; ++k)
        command_add_facts(m->domains[k].motion, &parts[k].c, facts, &parts[k].err);
    if (!agree_on_parts(m, parts, own))
        return false;
    *facts = facts_of_all(m, *facts);
    return !motion_lacks(effect_infer(&first->def, *facts) & ~first->effects, parts[0].c.call,
                         "one of its bodies", own);
}

// ---------------------------------------------------------------- acting

// Bodies of new places are the domain's own until they are exchanged.
static void add_new_bodies(moving *m, moving_domain *d, const command_part *p, duet_error *own)
{
    for (uint32_t i = 0; i < p->c.list.n; ++i) {
        const moving_body b = {.id = (uint32_t)p->ids[i], .own = d->number, .complete = 1};
        if (b.id < m->n_all)
            continue;
        list_add(&d->bodies.list, &b, 1, sizeof b);
        ++d->n_own;
    }
    if (d->bodies.failed)
        no_memory(own, "bodies that come in %s", p->c.call);
    else
        moving_index_places(m, d, own);
}

static void act_on(moving *m, moving_domain *d, command_part *p, effect_facts facts,
                   duet_error *own)
{
    if (!command_admit(d->motion, facts, own))
        return;
    if (p->n_new > 0)
        add_new_bodies(m, d, p, own);
    if (is_well(own) && (p->c.list.n > 0 || p->c.op->form == COMMAND_DEF))
        motion_keep_whole(d->motion, p->c.op->act(d->motion, &p->c, own));
    moving_keep_base(m, d->motion);
}

// Bodies that never move have numbers after all places.
static void move_walls(moving *m, uint32_t n_new)
{
    for (uint32_t k = 0; k < m->parts; ++k) {
        const item_list *contacts = &m->domains[k].contacts;
        for (uint64_t i = 0; i < contacts->n; ++i) {
            moving_contact *c = moving_contact_at(m, contacts, i);
            c->other += c->other >= m->n_all ? n_new : 0;
        }
    }
    m->n_all += n_new;
    m->counts.bodies = m->n_all;
}

static uint32_t count_new(const moving *m, const command *c, const uint64_t *ids)
{
    uint32_t n = 0;
    for (uint32_t i = 0; ids && i < c->list.n; ++i)
        n += (uint32_t)ids[i] >= m->n_all;
    return n;
}

static bool act(moving *m, const command *c, command_part *parts, const uint64_t *ids,
                effect_facts facts, duet_error *own)
{
    const uint32_t n_new = count_new(m, c, ids);
    for (uint32_t k = 0; is_well(own) && k < m->parts; ++k)
        act_on(m, &m->domains[k], &parts[k], facts, own);
    if (!ranks_agree(m->ranks, is_well(own), own))
        return false;
    m->facts = facts;
    m->def = m->domains[0].motion->def;
    ++m->n_commands;
    move_walls(m, n_new);
    return true;
}

// ---------------------------------------------------------------- all of it

// The first step of a motion that takes bodies apart begins with that, before they are divided.
static void check_command(const moving *m, const command *c, duet_error *own)
{
    if ((m->domains[0].motion->effects & DUET_EFFECT_DEPENETRATION) && m->counts.step == 0)
        bad_argument(own,
                     "%s: with depenetration the first step comes before commands; expected "
                     "duet_cluster_advance first",
                     c->call);
    if (is_well(own))
        motion_needs(m->domains[0].motion, c->op->effect, c->call, own);
}

// A rank may ask for fewer ids than there are.
static void tell_ids(const command *to, uint32_t n, const uint64_t *ids)
{
    for (uint32_t i = 0; ids && to->new_ids && i < n && i < to->list.n; ++i)
        to->new_ids[i] = ids[i];
}

static given_command give_parts(moving *m, const command *c, command_part *parts, const command *to,
                                duet_error *own)
{
    effect_facts facts = 0;
    uint64_t *ids = c->op->form == COMMAND_ADD ? choose_ids(m, c, own) : NULL;
    bool ok = ranks_agree(m->ranks, is_well(own), own) && check_parts(m, c, ids, parts, own) &&
              find_facts(m, parts, &facts, own);
    bool done = ok && act(m, c, parts, ids, facts, own);
    if (done)
        tell_ids(to, c->list.n, ids);
    free(ids);
    return done ? COMMAND_DONE : ok ? COMMAND_BROKE : COMMAND_REFUSED;
}

static given_command give_shared(moving *m, const command *c, const command *to, duet_error *own)
{
    command_part *parts = calloc(m->parts, sizeof *parts);
    given_command given = COMMAND_REFUSED;
    if (!parts)
        no_memory(own, "the parts of %s", c->call);
    else
        check_command(m, c, own);
    if (ranks_agree(m->ranks, is_well(own), own))
        given = give_parts(m, c, parts, to, own);
    for (uint32_t k = 0; parts && k < m->parts; ++k)
        free_part(&parts[k]);
    free(parts);
    return given;
}

// Lets all bodies keep what commands leave. Rows that travel are longer from then on.
static bool keep_commands(moving *m, duet_error *own)
{
    if (m->keeps_commands)
        return true;
    for (uint32_t k = 0; is_well(own) && k < m->parts; ++k)
        motion_begin_commands(m->domains[k].motion, own);
    m->keeps_commands = true;
    m->traveller_bytes += domain_command_bytes(m->domains[0].motion);
    return ranks_agree(m->ranks, is_well(own), own);
}

given_command moving_give(moving *m, command *c, duet_error *own)
{
    shared_command s = {0};
    given_command given = COMMAND_REFUSED;
    if (!keep_commands(m, own))
        return COMMAND_BROKE;
    share(m, c, &s, own);
    if (is_well(own))
        given = give_shared(m, &s.c, c, own);
    free_shared(&s);
    return given;
}

// ---------------------------------------------------------------- what is asked

static void read_user_data(const moving *m, const moving_domain *d, const command_part *p,
                           uint64_t *data)
{
    for (uint32_t i = 0; m->keeps_commands && i < p->c.list.n; ++i)
        if (moving_owns(d, p->c.places[i]))
            data[p->of[i]] = d->motion->commands->user_data[p->c.places[i]];
}

bool moving_get_user_data(moving *m, duet_body_list list, const char *call, uint64_t **data,
                          uint32_t *n, duet_error *own)
{
    const command_op asks = {.form = COMMAND_LIST};
    shared_command s = {0};
    share(m, &(command){.op = &asks, .call = call, .list = list}, &s, own);
    *n = s.c.list.n;
    *data = calloc((size_t)*n + 1, sizeof **data);
    if (is_well(own) && !*data)
        no_memory(own, "%u numbers in %s", *n, call);
    for (uint32_t k = 0; is_well(own) && k < m->parts; ++k) {
        command_part p = {0};
        make_part(m, &m->domains[k], &s.c, NULL, &p);
        *own = p.err;
        if (is_well(own))
            read_user_data(m, &m->domains[k], &p, *data);
        free_part(&p);
    }
    bool ok = ranks_agree(m->ranks, is_well(own), own);
    for (uint32_t first = 0; ok && first < *n; first += INT32_MAX)
        ranks_sum(m->ranks, *data + first, (int)(*n - first < INT32_MAX ? *n - first : INT32_MAX));
    free_shared(&s);
    return ok;
}

const duet_motion_def *moving_get_def(const moving *m)
{
    return &m->domains[0].motion->def;
}
