// SPDX-License-Identifier: MIT
// The contacts that a domain solves for its ghosts, so that these come less often.
#include "cluster/motion/moving.h"

#include "base/rng.h"
#include "kernels/dynamics/records.h"

enum { FIELD = 60, FIELD_CONTACTS = 150, SWEEPS = 3, WRONG = 0xBAD };

// Contacts of bodies on a line, each of one with another near it; the first `n_own` are a domain's.
typedef struct field {
    uint32_t n, n_own;
    uint32_t ends[FIELD_CONTACTS][2], colours[FIELD_CONTACTS];
    uint32_t used[FIELD];
    bool is_known[FIELD_CONTACTS]; // to the domain
} field;

static field random_field(rng *r)
{
    field f = {.n_own = FIELD / 3};
    for (int tries = 0; tries < 4 * FIELD_CONTACTS && f.n < FIELD_CONTACTS; ++tries) {
        uint32_t a = rng_below(r, FIELD - 1), b = a + 1 + rng_below(r, 6), colour = rng_below(r, 9);
        if (b >= FIELD || ((f.used[a] | f.used[b]) >> colour & 1u))
            continue;
        f.used[a] |= 1u << colour;
        f.used[b] |= 1u << colour;
        f.ends[f.n][0] = a;
        f.ends[f.n][1] = b;
        f.colours[f.n] = colour;
        f.is_known[f.n++] = a < f.n_own || rng_below(r, 8) > 0;
    }
    return f;
}

// The contact's impulse and both ends come to depend on each other.
static void solve_contact(uint64_t *impulse, uint64_t *a, uint64_t *b)
{
    *impulse = 0x9E3779B97F4A7C15u * (*impulse ^ *a) + (*b << 7 | *b >> 57);
    *a += 3 * *impulse;
    *b ^= *impulse >> 9;
}

static void solve_colour(const field *f, const bool *solved, uint32_t colour, uint64_t *impulses,
                         uint64_t *bodies)
{
    for (uint32_t i = 0; i < f->n; ++i)
        if (f->colours[i] == colour && (!solved || solved[i]))
            solve_contact(&impulses[i], &bodies[f->ends[i][0]], &bodies[f->ends[i][1]]);
}

// A device's answer: its ghosts, and which contacts are solved.
typedef struct found_closure {
    ghost_colours ghosts[FIELD];
    bool solved[FIELD_CONTACTS];
} found_closure;

static void write_words(duet_motion *m, motion_buffer which, const void *words, size_t bytes)
{
    must(motion_reserve(m, which, bytes, 1, ERR));
    must(timeline_write_at(&m->times, "test", &m->buffers[which], 0, words, bytes, ERR));
}

// The motion has the field's bodies and the contacts that the domain knows, instead of its own.
static void write_field(duet_motion *m, const field *f, uint32_t rows[FIELD_CONTACTS])
{
    domain_place *places = must(calloc(m->n + FIXED, sizeof *places));
    cl_uint2 links[FIELD_CONTACTS];
    cl_uint colours[FIELD_CONTACTS], at_home[FIELD][GHOST_WORDS] = {{0}};
    uint32_t n = 0;
    for (uint32_t i = 0; i < f->n; ++i)
        if (f->is_known[i]) {
            rows[n] = i;
            links[n] = (cl_uint2){{f->ends[i][0], f->ends[i][1]}};
            colours[n++] = f->colours[i];
        }
    for (uint32_t i = 0; i < FIELD; ++i) {
        places[i] = (domain_place){i, PLACE_MOVES | (i < f->n_own ? PLACE_OWN : 0)};
        at_home[i][GHOST_AT_HOME] = f->used[i];
    }
    must(domain_mark_places(m, places, ERR));
    must(domain_reserve_ghosts(m, ERR));
    write_words(m, LINKS, links, n * sizeof *links);
    write_words(m, COLOUR_OF, colours, n * sizeof *colours);
    write_words(m, GHOSTS, at_home, sizeof at_home);
    m->graph.n_contacts = n;
    must(timeline_finish(&m->times, ERR));
    free(places);
}

static found_closure closure_of(duet_motion *m, const field *f, uint32_t every)
{
    found_closure c = {0};
    uint32_t rows[FIELD_CONTACTS];
    cl_uint colours[FIELD_CONTACTS];
    write_field(m, f, rows);
    must(domain_close(m, every, ERR));
    must(motion_fetch(m, "test", GHOSTS, 0, c.ghosts, sizeof c.ghosts, ERR));
    must(
        motion_fetch(m, "test", COLOUR_OF, 0, colours, m->graph.n_contacts * sizeof *colours, ERR));
    for (uint32_t k = 0; k < m->graph.n_contacts; ++k) {
        c.solved[rows[k]] = colours[k] == f->colours[rows[k]];
        MUST(c.solved[rows[k]] || colours[k] == (COLOUR_LEFT | f->colours[rows[k]]),
             "solved or left");
        MUST(c.solved[rows[k]] || f->ends[rows[k]][0] >= f->n_own, "own ones are solved");
    }
    return c;
}

// Returns how often ghosts come. Ghosts that are wrong and do not come are wrong without bounds.
static uint32_t must_sweep_alike(const field *f, const found_closure *c, rng *r)
{
    uint64_t at_home[FIELD], here[FIELD], impulses[FIELD_CONTACTS], own[FIELD_CONTACTS];
    uint32_t times = 0;
    for (uint32_t i = 0; i < f->n; ++i)
        impulses[i] = own[i] = rng_next(r);
    for (uint32_t i = 0; i < FIELD; ++i) {
        at_home[i] = rng_next(r);
        here[i] = i < f->n_own || c->ghosts[i].here != 0 ? at_home[i] : WRONG;
    }
    for (int sweep = 0; sweep < SWEEPS; ++sweep)
        for (uint32_t colour = 0; colour <= HALO_END; ++colour) {
            uint32_t came = 0;
            solve_colour(f, NULL, colour, impulses, at_home);
            solve_colour(f, c->solved, colour, own, here);
            for (uint32_t i = f->n_own; i < FIELD; ++i)
                if (c->ghosts[i].comes >> colour & 1u) {
                    here[i] = at_home[i];
                    ++came;
                }
            times += came > 0;
        }
    MUST(memcmp(here, at_home, f->n_own * sizeof *here) == 0, "own bodies are right");
    for (uint32_t i = 0; i < f->n; ++i)
        MUST(!c->solved[i] || own[i] == impulses[i], "contacts that are solved are right");
    for (uint32_t i = f->n_own; i < FIELD; ++i)
        MUST(c->ghosts[i].here == 0 || here[i] == at_home[i],
             "ghosts with contacts are right after a sweep");
    return times;
}

// Contacts that the domain does not know, of bodies anywhere, make ghosts come sooner.
FACT_OF_ONE(closures_leave_nothing_wrong)
{
    rng r = rng_seed(job_seed);
    uint32_t times[2] = {0};
    duet_cluster *cluster = two_domains_after_steps("200", 1, 1);
    duet_motion *m = cluster->moving->domains[0].motion;
    MUST(m->n > FIELD, "places for a field");
    for (int i = 0; i < 200; ++i) {
        const field f = random_field(&r);
        for (uint32_t every = 1; every <= 9; ++every) {
            const found_closure c = closure_of(m, &f, every);
            uint32_t n = must_sweep_alike(&f, &c, &r);
            times[0] += every == 1 ? n : 0;
            times[1] += every == 9 ? n : 0;
        }
    }
    MUST(times[1] > 0 && 2 * times[1] < times[0], "ghosts come less often");
    duet_cluster_destroy(cluster);
}

enum { ASKED_MOST = ASKED_RECORD + 512 };

// A row of a coloured contact that follows another coloured one of the same owner.
static uint32_t second_coloured(duet_motion *m, cl_uint2 *links, cl_uint *colours)
{
    const uint32_t n = m->graph.n_contacts;
    must(motion_fetch(m, "test", LINKS, 0, links, n * sizeof *links, ERR));
    must(motion_fetch(m, "test", COLOUR_OF, 0, colours, n * sizeof *colours, ERR));
    for (uint32_t i = 1; i < n; ++i)
        if (links[i].s[0] == links[i - 1].s[0] && colours[i] < COLOUR_OVERFLOW &&
            colours[i - 1] < COLOUR_OVERFLOW)
            return i;
    MUST(false, "a body with two contacts");
    return 0;
}

static cl_uint colour_at(duet_motion *m, uint32_t row)
{
    cl_uint colour = 0;
    must(motion_fetch(m, "test", COLOUR_OF, row * sizeof colour, &colour, sizeof colour, ERR));
    return colour;
}

static uint32_t mistaken_after(duet_motion *m, const asked_contact *asked, const cl_uint *row)
{
    domain_closed closed;
    must(domain_take_asked(m, asked, 1, row, ERR));
    must(domain_count_closed(m, &closed, ERR));
    return closed.n_mistaken;
}

// A contact is found by an end and its colour. If another one comes instead, both are known again:
// the one was solved in the place of the other, and the other by a colour that it does not have.
FACT_OF_ONE(asked_contacts_come_or_are_mistaken)
{
    duet_cluster *cluster = two_domains_after_steps("200", 31, 80);
    const moving_domain *d = &cluster->moving->domains[0];
    duet_motion *m = d->motion;
    const size_t n = m->graph.n_contacts, bytes = domain_asked_bytes(m);
    cl_uint2 *links = must(malloc(n * sizeof *links));
    cl_uint *colours = must(malloc(n * sizeof *colours)), row[ASKED_MOST], again[ASKED_MOST];
    const uint32_t i = second_coloured(m, links, colours);
    const asked_contact asked = {links[i].s[0], colours[i]};
    MUST(bytes <= sizeof row, "space for a record");
    must(domain_read_asked(m, &asked, 1, row, ERR));
    MUST(row[0] == d->places[links[i].s[0]].id && row[1] == d->places[links[i].s[1]].id, "its ids");
    row[ASKED_RECORD + 1] += 77;
    MUST(mistaken_after(m, &asked, row) == 0, "it is the one that was meant");
    must(domain_read_asked(m, &asked, 1, again, ERR));
    MUST(memcmp(row, again, bytes) == 0 && colour_at(m, i) == asked.colour, "it came");
    row[1] = d->places[links[i - 1].s[1]].id;
    MUST(mistaken_after(m, &asked, row) == 2, "another one came");
    MUST(colour_at(m, i) == (COLOUR_LEFT | COLOUR_NONE), "of this nothing is known");
    MUST(colour_at(m, i - 1) == (COLOUR_LEFT | asked.colour), "that has the colour at home");
    MUST(mistaken_after(m, &asked, row) == 2, "it is left to its home, and nothing rests on it");
    free(links);
    free(colours);
    duet_cluster_destroy(cluster);
}
