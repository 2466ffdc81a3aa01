// SPDX-License-Identifier: MIT
// A step of a scene's bodies over all domains: the stages of one motion's step
// (runtime/dynamics/solver.c), with an exchange of ghosts after each one that leaves them wrong.
#include "cluster/moving_domains.h"

#include "base/error.h"

#include <math.h>

// ---------------------------------------------------------------- what a step made

// Ghosts are chosen by bounds that bodies stay in for about so many steps, so that pairs are
// searched more often than bodies are exchanged.
enum { STEPS_WITHIN = 8 };

// Wider by the way of a body that keeps its velocity, and by the mean extent for one that does not.
static void widen(const moving *m, moving_body *b)
{
    const duet_motion *motion = m->domains[0].motion;
    double velocity[3];
    moving_velocity(m, b, velocity);
    for (int k = 0; k < 3; ++k) {
        double way = STEPS_WITHIN * motion->def.dt * velocity[k];
        b->bounds[k] -= (float)(motion->extent + greater(0, -way));
        b->bounds[k + 3] += (float)(motion->extent + greater(0, way));
    }
    if (motion->def.dims == 2)
        b->bounds[2] = b->bounds[5] = 0.0f;
}

void moving_read_bodies(moving *m, moving_domain *d, duet_error *own)
{
    const size_t state = m->body_bytes - sizeof(moving_body), n = d->bodies.n;
    char *states = malloc(n * state + 1);
    float *bounds = malloc((6 * n + 1) * sizeof *bounds);
    if (!states || !bounds)
        error_set(own, DUET_STATUS_NO_MEMORY, "the states of %zu bodies: no memory", n);
    domain_forget_bounds(d->motion); // others than those that the next step makes
    bool ok = is_well(own) && domain_read_states(d->motion, states, own) &&
              (!moving_touches(m) || domain_read_bounds(d->motion, bounds, own));
    for (uint64_t i = 0; ok && i < n; ++i) {
        moving_body *b = moving_body_at(m, &d->bodies, i);
        b->at =
            m->keeps_commands ? NO_PLACE : (uint32_t)i; // commands leave more than the motion has
        b->pose = d->motion->poses[i];
        b->body = d->motion->bodies[i];
        b->acts = (b->body.mass > 0.0f || b->body.sensor) &&
                  !domain_is_hidden(d->motion, states + i * state);
        memcpy(moving_state(b), states + i * state, state);
        if (!moving_touches(m))
            continue;
        memcpy(b->bounds, bounds + 6 * i, sizeof b->bounds);
        widen(m, b);
    }
    free(states);
    free(bounds);
}

enum { MOST_RECORD = HEAD_OF(1, 1, 4) + 4 * POINT_FLOATS_OF(1, 1, 3) };

typedef struct contact_row {
    moving_contact head;
    float record[MOST_RECORD];
} contact_row;

// The domain that a contact goes to for an end of it: the next one of an own body that acts, or is
// the owner, whose domain tells that the contact ended; and of another's body which commands made
// act, since its own domain has not seen the contact. UINT32_MAX: none.
static uint32_t next_of(const moving *m, const moving_domain *d, const moving_body *b,
                        bool is_owner)
{
    bool sends = b && (moving_is_own(d, b) ? b->acts || is_owner : b->acts && !b->complete);
    return sends ? moving_domain_of(m, b) : UINT32_MAX;
}

// A contact is right where its owner is own, which acted, or an end whose contacts are all there.
static bool is_right(const moving *m, const moving_domain *d, const uint32_t ends[2])
{
    const moving_body *other = moving_body_or_wall(m, d, ends[1]);
    return moving_owns(m, d, ends[0]) || (other && moving_is_own(d, other) && other->complete);
}

// Domains of this rank get it at once.
static void send_contact(moving *m, moving_contact *row, const uint32_t next[2],
                         item_list *contacts)
{
    row->domain = UINT32_MAX;
    for (int k = 0; k < 2; ++k) {
        if (next[k] == UINT32_MAX || next[k] == row->domain)
            continue;
        row->domain = next[k];
        list_add(next[k] / m->parts == (uint32_t)m->ranks->self
                     ? &m->domains[next[k] % m->parts].contacts
                     : contacts,
                 row, 1, m->contact_bytes);
    }
}

void moving_write_contact(const moving *m, const moving_domain *d, const domain_contacts *from,
                          uint32_t i, moving_contact *row)
{
    const size_t record = m->contact_bytes - sizeof(moving_contact);
    *row = (moving_contact){.owner = moving_id(m, d, from->links[i].s[0]),
                            .other = moving_id(m, d, from->links[i].s[1]),
                            .touch = from->touches[i],
                            .colour = from->colours[i]};
    memcpy(row + 1, (const char *)from->records + i * record, record);
}

static void add_contact(moving *m, const moving_domain *d, const domain_contacts *from, uint32_t i,
                        bool is_told, item_list *contacts)
{
    const uint32_t *ends = from->links[i].s;
    if (!is_right(m, d, ends))
        return;
    contact_row row;
    moving_write_contact(m, d, from, i, &row.head);
    row.head.told = is_told;
    const uint32_t next[2] = {next_of(m, d, moving_body_or_wall(m, d, ends[0]), true),
                              next_of(m, d, moving_body_or_wall(m, d, ends[1]), false)};
    send_contact(m, &row.head, next, contacts);
}

// Contacts of which an end is not here are in no motion, and stay until a step ends them: commands
// may bring it back.
static void send_parted(moving *m, const moving_domain *d, const item_list *parted,
                        item_list *contacts)
{
    for (uint64_t i = 0; i < parted->n; ++i) {
        moving_contact *c = moving_contact_at(m, parted, i);
        const uint32_t owner = moving_place(m, d, c->owner),
                       other = c->other < m->n_all ? moving_place(m, d, c->other) : 0;
        if (owner != UINT32_MAX && other != UINT32_MAX)
            continue;
        const uint32_t next[2] = {moving_owns(m, d, owner)
                                      ? next_of(m, d, moving_body_at(m, &d->bodies, owner), true)
                                      : UINT32_MAX,
                                  c->other < m->n_all && moving_owns(m, d, other)
                                      ? next_of(m, d, moving_body_at(m, &d->bodies, other), false)
                                      : UINT32_MAX};
        send_contact(m, c, next, contacts);
    }
}

// A contact that does not touch has nothing to keep.
static void add_contacts(moving *m, const moving_domain *d, const domain_contacts *all,
                         item_list *contacts, duet_error *own)
{
    uint8_t *told = calloc((size_t)d->motion->graph.n_contacts + 1, 1);
    if (!told)
        error_set(own, DUET_STATUS_NO_MEMORY, "%u contacts: no memory", all->n);
    else if (!all->rows && domain_note_touching(d->motion, own))
        domain_read_told(d->motion, told, own);
    for (uint32_t i = 0; is_well(own) && i < all->n; ++i)
        if (all->touches[i] & TOUCH_POINTS)
            add_contact(m, d, all, i, told[i], contacts);
    free(told);
}

void moving_read_contacts(moving *m, const moving_domain *d, item_list *contacts, duet_error *own)
{
    domain_contacts all;
    if (domain_read_contacts(d->motion, true, &all, own))
        add_contacts(m, d, &all, contacts, own);
    domain_contacts_free(&all);
}

// Ghosts and own bodies that leave take their contacts along.
static void mark_travelling(const moving *m, moving_domain *d, duet_error *own)
{
    moving_note_places(m, d, own);
    for (uint64_t i = 0; is_well(own) && i < d->bodies.n; ++i) {
        const moving_body *b = moving_body_at(m, &d->bodies, i);
        if (!moving_is_own(d, b) || moving_domain_of(m, b) != d->number)
            d->places[i].kind |= PLACE_SHARED;
    }
    if (is_well(own))
        domain_mark_places(d->motion, d->places, own);
}

// Leaves those contacts that travel of the ones that the host is told of.
static void leave_travelling(const moving_domain *d, domain_contacts *c)
{
    uint32_t kept = 0;
    for (uint32_t i = 0; i < c->n; ++i) {
        const uint32_t *ends = c->links[i].s;
        if (!((d->places[ends[0]].kind | d->places[ends[1]].kind) & PLACE_SHARED))
            continue;
        c->rows[kept] = c->rows[i];
        c->links[kept++] = c->links[i];
    }
    c->n = kept;
}

// Reads the contacts that travel; the others stay in the motion.
static void read_travelling(moving *m, moving_domain *d, item_list *contacts, duet_error *own)
{
    domain_contacts listed = {0};
    mark_travelling(m, d, own);
    if (!is_well(own) || !domain_list_border(d->motion, &listed, own))
        return;
    leave_travelling(d, &listed);
    if (domain_reserve_rows(&listed, d->motion, own) &&
        domain_read_rows(d->motion, listed.rows, &listed, own))
        add_contacts(m, d, &listed, contacts, own);
    domain_contacts_free(&listed);
}

// The domains that contacts go to follow from where bodies are, and from the borders.
static bool read_all(moving *m, const item_list *parted, item_list *contacts, duet_error *own)
{
    for (uint32_t k = 0; is_well(own) && k < m->parts; ++k)
        moving_read_bodies(m, &m->domains[k], own);
    if (moving_cut_is_due(m) && !moving_cut(m, own))
        return false;
    for (uint32_t k = 0; is_well(own) && moving_touches(m) && k < m->parts; ++k) {
        if (moving_sends_all(m))
            moving_read_contacts(m, &m->domains[k], contacts, own);
        else
            read_travelling(m, &m->domains[k], contacts, own);
        send_parted(m, &m->domains[k], &parted[k], contacts);
    }
    return true;
}

// ---------------------------------------------------------------- stages

typedef bool domain_stage(duet_motion *m, duet_error *err);

static void each(moving *m, domain_stage *stage, duet_error *own)
{
    for (uint32_t k = 0; is_well(own) && k < m->parts; ++k)
        stage(m->domains[k].motion, own);
}

// A pass does one of these to the contacts of a colour, or to one of those that are solved in
// order.
typedef enum solve_pass { SOLVE_SHOCKS, SOLVE_SOFT, SOLVE_RELAX, SOLVE_RESTORE } solve_pass;

static void solve_colours(duet_motion *motion, uint32_t from, uint32_t to, solve_pass pass,
                          duet_error *own)
{
    if (pass == SOLVE_SHOCKS)
        domain_shock_colours(motion, from, to, own);
    else if (pass == SOLVE_RESTORE)
        domain_restore_colours(motion, from, to, own);
    else
        domain_solve_colours(motion, from, to, pass == SOLVE_SOFT, own);
}

static void solve_one(duet_motion *motion, uint32_t i, solve_pass pass, duet_error *own)
{
    if (pass == SOLVE_SHOCKS)
        domain_shock_in_order(motion, i, own);
    else if (pass == SOLVE_RESTORE)
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

// Colours after which no ghost of this rank goes or comes are solved together with the next one.
static uint32_t end_of_colours(const moving *m, uint32_t from)
{
    uint32_t colours = m->counts.colours < HALO_COLOURS ? m->counts.colours : HALO_COLOURS;
    uint32_t to = from + 1;
    while (to < colours && !halo_comes(&m->halo, to - 1))
        ++to;
    return to;
}

static void solve(moving *m, solve_pass pass, duet_error *own)
{
    for (uint32_t from = 0, to; from < m->counts.colours && from < COLOUR_OVERFLOW; from = to) {
        to = end_of_colours(m, from);
        for (uint32_t k = 0; is_well(own) && k < m->parts; ++k)
            solve_colours(m->domains[k].motion, from, to, pass, own);
        halo_exchange_after(&m->halo, m, to - 1, pass == SOLVE_RELAX, own);
    }
    halo_exchange_after(&m->halo, m, HALO_END, pass == SOLVE_RELAX, own);
    if (m->n_in_order > 0)
        solve_in_order(m, pass, own);
}

// Sweeps go on while something bounced in any domain.
static bool solve_shocks(moving *m, duet_error *own)
{
    tally t = {.sums = {motion_has_shocks(m->domains[0].motion)}};
    for (int i = 0; t.sums[0] > 0 && i < SHOCK_SWEEPS; ++i) {
        solve(m, SOLVE_SHOCKS, own);
        t = (tally){0};
        for (uint32_t k = 0; is_well(own) && k < m->parts; ++k) {
            bool bounced = false;
            domain_end_sweep(m->domains[k].motion, &bounced, own);
            t.sums[0] += bounced;
        }
        if (!ranks_agree_and(m->ranks, is_well(own), &t, own))
            return false;
    }
    return true;
}

// The ghosts' velocities and positions change as their owners' do.
static bool substep(moving *m, duet_error *own)
{
    each(m, domain_integrate_velocities, own);
    if (!solve_shocks(m, own))
        return false;
    solve(m, SOLVE_SOFT, own);
    each(m, domain_integrate_positions, own);
    solve(m, SOLVE_RELAX, own);
    return true;
}

// Shocks have given back all speed.
static bool run_substeps(moving *m, duet_error *own)
{
    const duet_motion *motion = m->domains[0].motion;
    bool ok = true;
    for (uint32_t i = 0; ok && i < motion->def.substeps; ++i)
        ok = substep(m, own);
    if (ok && (motion->facts & FACT_ELASTIC) && !motion_has_shocks(motion))
        solve(m, SOLVE_RESTORE, own);
    return ok;
}

// Finds what wakes and what falls asleep among the bodies that a domain owns, and tells others:
// rests before bodies look at those that they touch, and then which of them sleep.
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
    halo_exchange_after(&m->halo, m, HALO_ANY, true, own);
    if (!run_substeps(m, own))
        return false;
    halo_exchange_late(&m->halo, m, own);
    each(m, domain_finalize, own);
    if (!moving_refresh(m, own))
        return false;
    if (t.sums[1] > 0)
        push_sleepers(m, own);
    each(m, domain_end_step, own);
    return true;
}

// Contacts, which are long, are here only while they are exchanged.
static void forget_contacts(moving *m)
{
    for (uint32_t k = 0; k < m->parts; ++k) {
        free(m->domains[k].contacts.items);
        m->domains[k].contacts = (item_list){0};
    }
}

bool moving_settle(moving *m, duet_error *own)
{
    item_list contacts = {0}, *parted = calloc(m->parts, sizeof *parted);
    if (!parted)
        error_set(own, DUET_STATUS_NO_MEMORY, "%u domains: no memory", m->parts);
    for (uint32_t k = 0; parted && k < m->parts; ++k) {
        parted[k] = m->domains[k].contacts;
        m->domains[k].contacts = (item_list){0};
    }
    bool ok = read_all(m, parted, &contacts, own) && moving_exchange(m, &contacts, own);
    for (uint32_t k = 0; parted && k < m->parts; ++k)
        free(parted[k].items);
    free(parted);
    free(contacts.items);
    return ok;
}

bool moving_stays(const moving *m, const moving_domain *d, const extent *old, const extent *now)
{
    if (extent_within(now, old))
        return true;
    bool stays = extent_within(now, &m->reaches[d->number]);
    for (uint64_t i = 0; stays && i < d->neighbours.n; ++i) {
        const extent *reach = &m->reaches[d->neighbours.rows[i]];
        stays = !extents_meet(now, reach) || extents_meet(old, reach);
    }
    return stays;
}

static extent extent_of_bounds(const moving *m, const float bounds[6])
{
    const bool flat = m->def.dims == 2;
    return (extent){{bounds[0], bounds[1], flat ? 0.0 : bounds[2]},
                    {bounds[3], bounds[4], flat ? 0.0 : bounds[5]}};
}

static bool stays(const moving *m, const moving_domain *d, const domain_near *near)
{
    const extent old = extent_of_bounds(m, moving_body_at(m, &d->bodies, near->place)->bounds),
                 now = extent_of_bounds(m, near->bounds);
    return moving_stays(m, d, &old, &now);
}

// An extent in float, rounded inward or outward, so that what float says of bounds is right; in 2D
// all lies in it along z.
static void round_extent(const moving *m, const extent *e, bool inward, float to[6])
{
    for (int k = 0; k < 3; ++k) {
        const double lower = e->lower[k], upper = e->upper[k];
        to[k] = (float)lower;
        to[k + 3] = (float)upper;
        if (inward ? to[k] < lower : to[k] > lower)
            to[k] = nextafterf(to[k], inward ? INFINITY : -INFINITY);
        if (inward ? to[k + 3] > upper : to[k + 3] < upper)
            to[k + 3] = nextafterf(to[k + 3], inward ? -INFINITY : INFINITY);
    }
    if (m->def.dims == 2) {
        to[2] = -INFINITY;
        to[5] = INFINITY;
    }
}

// The device looks for bodies that may have left, which are near borders.
static bool list_near(const moving *m, const moving_domain *d, domain_near **near, uint32_t *n,
                      duet_error *own)
{
    const uint32_t n_extents = (uint32_t)d->neighbours.n + 1;
    float(*extents)[6] = malloc(n_extents * sizeof *extents);
    if (!extents)
        return error_set(own, DUET_STATUS_NO_MEMORY, "the bounds of bodies: no memory");
    round_extent(m, &m->reaches[d->number], true, extents[0]);
    for (uint32_t i = 1; i < n_extents; ++i)
        round_extent(m, &m->reaches[d->neighbours.rows[i - 1]], false, extents[i]);
    bool ok = domain_list_near(d->motion, extents[0], n_extents, near, n, own);
    free(extents);
    return ok;
}

// Whether pairs that the next step searches are all among the domain's bodies.
static bool has_all_pairs(const moving *m, const moving_domain *d, duet_error *own)
{
    domain_near *near = NULL;
    uint32_t n = 0;
    if (domain_is_bounded(d->motion))
        return true;
    bool within = list_near(m, d, &near, &n, own);
    for (uint32_t i = 0; within && i < n; ++i)
        within = stays(m, d, &near[i]);
    free(near);
    return within;
}

// All ranks know whether a body is to be a ghost elsewhere.
static bool settle_where_due(moving *m, duet_error *own)
{
    tally t = {.sums = {0}};
    for (uint32_t k = 0; is_well(own) && k < m->parts; ++k)
        t.sums[0] += !has_all_pairs(m, &m->domains[k], own);
    moving_note_work(m, &t);
    if (!ranks_agree_and(m->ranks, is_well(own), &t, own) || !moving_compare_work(m, &t, own))
        return false;
    return (t.sums[0] == 0 && !moving_cut_is_due(m)) || moving_settle(m, own);
}

// The only domain's bodies are a motion of their own.
static bool step_alone(moving *m, duet_error *own)
{
    duet_motion_result result;
    forget_contacts(m);
    if (!is_well(own) || !duet_motion_advance(m->domains[0].motion, &result, own))
        return false;
    m->counts.contacts = result.contacts;
    m->counts.colours = result.colours;
    return true;
}

static void end_commands(moving *m, duet_error *own)
{
    each(m, domain_end_commands, own);
    for (uint32_t k = 0; k < m->parts; ++k)
        moving_keep_base(m, m->domains[k].motion);
}

// Touches after the flight are found among ghosts at the places of that time.
static bool fly(moving *m, duet_error *own)
{
    each(m, domain_fly, own);
    if (!settle_where_due(m, own))
        return false;
    if (moving_touches(m))
        each(m, domain_find_contacts, own);
    forget_contacts(m);
    end_commands(m, own);
    moving_find_events(m, own);
    return true;
}

static bool step_together(moving *m, duet_error *own)
{
    if (m->n_commands > 0 && !moving_settle(m, own))
        return false;
    forget_contacts(m);
    if (!moving_pushes(m))
        return fly(m, own);
    if (!respond(m, own))
        return false;
    end_commands(m, own);
    moving_find_events(m, own);
    return settle_where_due(m, own);
}

bool moving_step(moving *m, duet_error *own)
{
    bool ok = m->n_domains == 1 ? step_alone(m, own) : step_together(m, own);
    m->counts.step += ok;
    m->n_commands = 0;
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

void moving_centre(const moving *m, const moving_body *b, double at[3])
{
    domain_centre(m->domains[0].motion, (const char *)(b + 1), at);
}

// A state begins with the centre and the velocity, each a vector of four.
void moving_velocity(const moving *m, const moving_body *b, double velocity[3])
{
    const void *state = b + 1;
    for (int k = 0; k < 3; ++k)
        velocity[k] = m->domains[0].motion->def.doubles ? ((const double *)state)[4 + k]
                                                        : (double)((const float *)state)[4 + k];
}

uint32_t moving_domain_of(const moving *m, const moving_body *b)
{
    double at[3];
    moving_centre(m, b, at);
    return bisection_part(&m->cuts, at);
}
