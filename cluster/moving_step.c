// SPDX-License-Identifier: MIT
// A step of a scene's bodies over all domains: the stages of one motion's step
// (runtime/dynamics/solver.c), with an exchange of ghosts after each one that leaves them wrong.
#include "cluster/moving_domains.h"

#include "base/error.h"

// ---------------------------------------------------------------- what a step made

void moving_read_bodies(moving *m, moving_domain *d, duet_error *own)
{
    const size_t state = m->body_bytes - sizeof(moving_body), n = d->bodies.n;
    char *states = malloc(n * state + 1);
    float *bounds = malloc((6 * n + 1) * sizeof *bounds);
    if (!states || !bounds)
        error_set(own, DUET_STATUS_NO_MEMORY, "the states of %zu bodies: no memory", n);
    bool ok = is_well(own) && domain_read_states(d->motion, states, own) &&
              (!moving_pushes(m) || domain_read_bounds(d->motion, bounds, own));
    for (uint64_t i = 0; ok && i < n; ++i) {
        moving_body *b = moving_body_at(m, &d->bodies, i);
        memcpy(moving_state(b), states + i * state, state);
        if (moving_pushes(m))
            memcpy(b->bounds, bounds + 6 * i, sizeof b->bounds);
        if (d->motion->def.dims == 2)
            b->bounds[2] = b->bounds[5] = 0.0f;
    }
    free(states);
    free(bounds);
}

enum { MOST_RECORD = HEAD_OF(1, 1, 4) + 4 * POINT_FLOATS_OF(1, 1, 3) };

typedef struct contact_row {
    moving_contact head;
    float record[MOST_RECORD];
} contact_row;

// A contact goes to the domains that own its ends next, of which this one knows those of its own.
static void add_contact(moving *m, const moving_domain *d, const domain_contacts *from, uint32_t i,
                        item_list *contacts)
{
    const size_t record = m->contact_bytes - sizeof(moving_contact);
    const uint32_t *ends = from->links[i].s;
    contact_row row = {.head = {.domain = UINT32_MAX,
                                .owner = moving_id(m, d, ends[0]),
                                .other = moving_id(m, d, ends[1]),
                                .touch = from->touches[i],
                                .colour = from->colours[i]}};
    memcpy(row.record, (const char *)from->records + i * record, record);
    for (int k = 0; k < 2; ++k) {
        const moving_body *b = moving_body_or_wall(m, d, ends[k]);
        uint32_t to = b && moving_decides(d, b) ? moving_domain_of(m, b) : UINT32_MAX;
        if (to == UINT32_MAX || to == row.head.domain)
            continue;
        row.head.domain = to;
        list_add(contacts, &row, 1, m->contact_bytes);
    }
}

void moving_read_contacts(moving *m, const moving_domain *d, item_list *contacts, duet_error *own)
{
    domain_contacts all;
    if (!domain_read_contacts(d->motion, true, &all, own))
        return;
    for (uint32_t i = 0; i < all.n; ++i)
        add_contact(m, d, &all, i, contacts);
    domain_contacts_free(&all);
}

// The domains that contacts go to follow from where bodies are, and from the borders.
static bool read_all(moving *m, item_list *contacts, duet_error *own)
{
    for (uint32_t k = 0; is_well(own) && k < m->parts; ++k)
        moving_read_bodies(m, &m->domains[k], own);
    if (moving_cut_is_due(m) && !moving_cut(m, own))
        return false;
    for (uint32_t k = 0; is_well(own) && moving_pushes(m) && k < m->parts; ++k)
        moving_read_contacts(m, &m->domains[k], contacts, own);
    return true;
}

// ---------------------------------------------------------------- stages

typedef bool domain_stage(duet_motion *m, duet_error *err);

static void each(moving *m, domain_stage *stage, duet_error *own)
{
    for (uint32_t k = 0; is_well(own) && k < m->parts; ++k)
        stage(m->domains[k].motion, own);
}

// A pass does one of these to the contacts of a colour, or to one of those that are solved in order.
typedef enum solve_pass { SOLVE_SOFT, SOLVE_RELAX, SOLVE_RESTORE } solve_pass;

static void solve_colour(duet_motion *motion, uint32_t colour, solve_pass pass, duet_error *own)
{
    if (pass == SOLVE_RESTORE)
        domain_restore_colour(motion, colour, own);
    else
        domain_solve_colour(motion, colour, pass == SOLVE_SOFT, own);
}

static void solve_one(duet_motion *motion, uint32_t i, solve_pass pass, duet_error *own)
{
    if (pass == SOLVE_RESTORE)
        domain_restore_in_order(motion, i, own);
    else
        domain_solve_in_order(motion, i, pass == SOLVE_SOFT, own);
}

// Contacts without a colour of their own come one by one, in the order of all ids: a domain takes
// those that it has.
static void solve_in_order(moving *m, solve_pass pass, duet_error *own)
{
    uint64_t *taken = calloc(m->parts, sizeof *taken);
    if (!taken)
        error_set(own, DUET_STATUS_NO_MEMORY, "contacts in order: no memory");
    for (uint64_t i = 0; i < m->n_in_order; ++i) {
        for (uint32_t k = 0; is_well(own) && k < m->parts; ++k) {
            const row_list *has = &m->domains[k].in_order;
            if (taken[k] < has->n && has->rows[taken[k]] == i)
                solve_one(m->domains[k].motion, (uint32_t)taken[k]++, pass, own);
        }
        halo_exchange(&m->halo, m, BODIES, own);
    }
    free(taken);
}

// Domains that have no contact of a colour take part in its exchange.
static void solve(moving *m, solve_pass pass, duet_error *own)
{
    for (uint32_t colour = 0; colour < m->counts.colours && colour < COLOUR_OVERFLOW; ++colour) {
        for (uint32_t k = 0; is_well(own) && k < m->parts; ++k)
            solve_colour(m->domains[k].motion, colour, pass, own);
        halo_exchange(&m->halo, m, BODIES, own);
    }
    if (m->n_in_order > 0)
        solve_in_order(m, pass, own);
}

// The ghosts' velocities and positions change as their owners' do.
static void substep(moving *m, duet_error *own)
{
    each(m, domain_integrate_velocities, own);
    solve(m, SOLVE_SOFT, own);
    each(m, domain_integrate_positions, own);
    solve(m, SOLVE_RELAX, own);
}

// Finds what wakes and what falls asleep among the bodies that a domain owns, and tells others: rests
// before bodies look at those that they touch, and then which of them sleep.
static bool update_sleep(moving *m, tally *t, duet_error *own)
{
    *t = (tally){0};
    if (!(m->domains[0].motion->effects & DUET_EFFECT_SLEEP))
        return true;
    halo_exchange(&m->halo, m, RESTS, own);
    each(m, domain_update_sleep, own);
    halo_exchange(&m->halo, m, ASLEEP, own);
    each(m, domain_read_flags, own);
    for (uint32_t k = 0; k < m->parts; ++k) {
        const uint32_t *flags = m->domains[k].motion->flags;
        t->sums[0] += flags[FLAG_FELL_ASLEEP];
        t->sums[1] += flags[FLAG_PRESSED];
    }
    if (!ranks_agree_and(m->ranks, is_well(own), t, own))
        return false;
    for (uint32_t k = 0; is_well(own) && k < m->parts; ++k)
        domain_wake_touched(m->domains[k].motion, t->sums[0] > 0, own);
    return true;
}

static void push_sleepers(moving *m, duet_error *own)
{
    for (uint32_t round = 0; round < PRESSED_ROUNDS; ++round) {
        for (uint32_t k = 0; is_well(own) && k < m->parts; ++k)
            domain_push_sleepers(m->domains[k].motion, round, own);
        halo_exchange(&m->halo, m, BODIES, own);
    }
    each(m, domain_move_sleepers, own);
}

// The impulses to warm start with are sums over contacts, of which a ghost lacks some.
static bool respond(moving *m, duet_error *own)
{
    tally t;
    each(m, domain_begin_step, own);
    if (!update_sleep(m, &t, own) || !moving_colour(m, own))
        return false;
    each(m, domain_prepare_contacts, own);
    halo_exchange(&m->halo, m, BODIES, own);
    for (uint32_t i = 0; i < m->domains[0].motion->def.substeps; ++i)
        substep(m, own);
    if (m->domains[0].motion->facts & FACT_ELASTIC)
        solve(m, SOLVE_RESTORE, own);
    each(m, domain_finalize, own);
    if (t.sums[1] > 0)
        push_sleepers(m, own);
    each(m, domain_end_step, own);
    return true;
}

static bool fly(moving *m, duet_error *own)
{
    each(m, domain_fly, own);
    return true;
}

bool moving_step(moving *m, duet_error *own)
{
    item_list contacts = {0};
    bool ok = moving_pushes(m) ? respond(m, own) : fly(m, own);
    ok = ok && read_all(m, &contacts, own) && moving_exchange(m, &contacts, own);
    free(contacts.items);
    m->counts.step += ok;
    return ok;
}

// ---------------------------------------------------------------- hash

static void add_states(const moving *m, const moving_domain *d, uint64_t *hash, duet_error *own)
{
    duet_state *states = motion_read_states(d->motion, own);
    for (uint64_t i = 0; states && i < d->bodies.n; ++i) {
        const moving_body *b = moving_body_at(m, &d->bodies, i);
        if (moving_is_own(d, b))
            *hash = motion_hash_state(*hash, &states[i], b->id);
    }
    free(states);
}

bool moving_hash(moving *m, uint64_t *hash, duet_error *own)
{
    tally t = {.sums = {0}};
    for (uint32_t k = 0; is_well(own) && k < m->parts; ++k)
        add_states(m, &m->domains[k], &t.sums[0], own);
    bool ok = ranks_agree_and(m->ranks, is_well(own), &t, own);
    *hash = t.sums[0];
    return ok;
}

// A state begins with the centre.
void moving_centre(const moving *m, const moving_body *b, double at[3])
{
    const void *state = b + 1;
    for (int k = 0; k < 3; ++k)
        at[k] = m->domains[0].motion->def.doubles ? ((const double *)state)[k]
                                                  : (double)((const float *)state)[k];
}

uint32_t moving_domain_of(const moving *m, const moving_body *b)
{
    double at[3];
    moving_centre(m, b, at);
    return bisection_part(&m->cuts, at);
}
