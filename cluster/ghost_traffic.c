// SPDX-License-Identifier: MIT
#include "cluster/ghost_traffic.h"

#include "base/error.h"
#include "cluster/halo.h"

#include <math.h>
#include <stdlib.h>

const ghost_traffic ghost_traffics[GHOST_TRAFFICS] = {{1, 1, 10.6, 9.8, 6.3, 132, 0.46, 2.17},
                                                      {2, 2, 11.7, 11.4, 7.4, 169, 0.59, 2.66},
                                                      {4, 2, 10.9, 15.1, 11.0, 244, 0.88, 3.65},
                                                      {8, 4, 7.7, 16.2, 12.4, 352, 1.19, 5.03},
                                                      {31, 8, 5.1, 23.2, 21.6, 335, 1.47, 5.22}};

const ghost_traffic *ghost_traffic_of(uint32_t colours)
{
    const ghost_traffic *found = ghost_traffics;
    for (uint32_t i = 1; i < GHOST_TRAFFICS; ++i)
        if (ghost_traffics[i].colours <= colours)
            found = &ghost_traffics[i];
    return found;
}

// Substeps, each of two sweeps; and the end of a step: ghosts say whether they rest and sleep, are
// told colours, ask for theirs, and come as a whole. Ranks agree now and then.
enum { SUBSTEPS = 4, SWEEPS = 2 * SUBSTEPS, END_MESSAGES = 5, AGREEMENTS = 11 };

// The part of a step in which sweeps solve contacts, contacts of a body, and the part of them that
// each colour has: messages between colours have as large parts of the bytes.
static const double sweeps_part = 0.35, contacts_of_body = 1.3;
enum { COUNTED_COLOURS = 14 };
static const double colour_parts[COUNTED_COLOURS] = {0.1705,  0.1633,  0.1424,  0.1294, 0.1169,
                                                     0.1002,  0.0807,  0.0546,  0.029,  0.0101,
                                                     0.00246, 0.00034, 0.00004, 0.00002};

// A step of this rank. Times are in seconds.
typedef struct traffic_step {
    const ghost_traffic *traffic;
    const ghosts *ghosts;
    ranks *ranks;
    double own_time, all_time; // of own bodies; and with what is done for ghosts
    double inner_part;         // of the own bodies' contacts
    double least_inner_part;   // of all contacts: fewer are not worth a launch beside a message
    parcels out, in;           // as long as the longest message
    MPI_Request *requests;
} traffic_step;

static uint64_t at_border(const traffic_step *s, int q)
{
    const ghosts *g = s->ghosts;
    return q == s->ranks->self ? 0 : g->out.counts[q] + g->in.counts[q];
}

// ---------------------------------------------------------------- messages

static void set_bytes(const traffic_step *s, parcels *p, double bytes)
{
    for (int q = 0; q < s->ranks->n; ++q)
        p->counts[q] = (uint64_t)ceil(bytes * (double)at_border(s, q));
}

// Rows of a byte each.
static bool reserve(const traffic_step *s, parcels *p, double bytes, duet_error *err)
{
    if (!parcels_begin(p, s->ranks, 1, err))
        return false;
    set_bytes(s, p, bytes);
    return parcels_reserve(p, s->ranks, NULL, err);
}

// Both sides send as much. No bytes: no message.
static int begin_message(traffic_step *s, double bytes)
{
    set_bytes(s, &s->out, bytes);
    set_bytes(s, &s->in, bytes);
    return bytes > 0 ? parcels_begin_pass(s->ranks, &s->out, &s->in, s->requests) : 0;
}

static void pass_message(traffic_step *s, double bytes)
{
    parcels_end_pass(s->ranks, begin_message(s, bytes), s->requests);
}

// ---------------------------------------------------------------- work

static void work(const traffic_step *s, double seconds)
{
    s->ranks->simulation->pass(seconds);
}

static double part_of_colours(uint32_t from, uint32_t to)
{
    double part = 0;
    for (uint32_t k = from; k < to; ++k)
        part += colour_parts[k];
    return part;
}

// The time of a colour's contacts that are solved while a message travels.
static double inner_time(const traffic_step *s, uint32_t colour)
{
    const double part = colour_parts[colour];
    return part * s->inner_part < s->least_inner_part
               ? 0
               : part * s->inner_part * s->own_time * sweeps_part / SWEEPS;
}

// A sweep begins with a message of so many bytes; others are between colours.
static void sweep(traffic_step *s, double begin_bytes)
{
    const ghost_traffic *t = s->traffic;
    double bytes = begin_bytes;
    for (uint32_t from = 0, to; from < COUNTED_COLOURS; from = to) {
        const double inner = inner_time(s, from);
        to = from + t->apart < COUNTED_COLOURS ? from + t->apart : COUNTED_COLOURS;
        const int n = begin_message(s, bytes);
        work(s, inner);
        parcels_end_pass(s->ranks, n, s->requests);
        const double part = part_of_colours(from, to);
        work(s, part * s->all_time * sweeps_part / SWEEPS - inner);
        bytes = to < COUNTED_COLOURS ? t->colour_bytes * part : 0;
    }
}

static void take_step(traffic_step *s)
{
    const ghost_traffic *t = s->traffic;
    work(s, (1 - sweeps_part) * s->all_time);
    for (int i = 0; i < SUBSTEPS; ++i) {
        sweep(s, t->begin_bytes);
        pass_message(s, t->end_bytes);
        sweep(s, 0);
    }
    pass_message(s, t->end_bytes);
    for (int i = 0; i < END_MESSAGES; ++i)
        pass_message(s, t->step_bytes / END_MESSAGES);
}

static void find_work(traffic_step *s, double n)
{
    const ghost_traffic *t = s->traffic;
    const double body_time = s->ranks->simulation->object_seconds * s->ranks->stands_for;
    double border = 0;
    for (int q = 0; q < s->ranks->n; ++q)
        border += (double)at_border(s, q);
    s->own_time = n * body_time;
    s->all_time = (n + t->work * border) * body_time;
    s->inner_part = n > 0 ? fmax(0, 1 - t->border * border / n) : 0;
    s->least_inner_part =
        halo_least_inner(s->ranks) / (contacts_of_body * fmax(n, 1) * s->ranks->stands_for);
}

bool ghost_traffic_take(const ghost_traffic *t, const ghosts *g, ranks *r, uint64_t n,
                        duet_error *err)
{
    traffic_step s = {.traffic = t, .ghosts = g, .ranks = r};
    s.requests = malloc(4 * (size_t)r->n * sizeof *s.requests);
    if (!s.requests)
        no_memory(err, "messages to %d ranks", r->n);
    bool ok = is_well(err) && reserve(&s, &s.out, t->step_bytes, err) &&
              reserve(&s, &s.in, t->step_bytes, err);
    ok = ranks_agree(r, ok, err);
    if (ok) {
        find_work(&s, (double)n);
        take_step(&s);
    }
    for (int i = 0; ok && i < AGREEMENTS; ++i)
        ok = ranks_agree(r, true, err);
    parcels_end(&s.out);
    parcels_end(&s.in);
    free(s.requests);
    return ok;
}
