// SPDX-License-Identifier: MIT
// Contacts of ghosts that a domain solves as well as their homes: the device finds them, and asks
// for those that it does not have as at home (closure.cl and asked_contacts.cl of the kernels).
#include "base/error.h"
#include "kernels/dynamics/border.h"
#include "runtime/dynamics/domain_motion.h"

static const char stage[] = "closure";

static bool has_contacts(const duet_motion *m)
{
    return m->n > 0 && m->graph.n_contacts > 0;
}

bool domain_reserve_ghosts(duet_motion *m, duet_error *err)
{
    return motion_reserve(m, GHOSTS, (uint64_t)m->n + 1, GHOST_WORDS * sizeof(cl_uint), err) &&
           motion_reserve(m, KEPT, (uint64_t)m->n + 1, sizeof(cl_uint), err);
}

// ---------------------------------------------------------------- what is solved

static bool begin(duet_motion *m, duet_error *err)
{
    return motion_reserve(m, CLOSING, CLOSING_WORDS, sizeof(cl_uint), err) &&
           motion_clear(m, stage, CLOSING, 0, CLOSING_WORDS, err) &&
           motion_launch(m, BEGIN_GHOSTS, err) && domain_list_ghosts(m, &m->border.n_border, err) &&
           motion_launch(m, NOTE_KEPT, err);
}

// From the last colour back: each colour is one after which ghosts may have to come.
static bool take_needed(duet_motion *m, duet_error *err)
{
    motion_border *b = &m->border;
    cl_uint present = 0;
    bool ok = motion_fetch(m, stage, CLOSING, CLOSING_PRESENT * sizeof present, &present,
                           sizeof present, err);
    uint32_t n = COLOUR_OVERFLOW;
    while (n > 0 && !(present >> (n - 1) & 1u))
        --n;
    for (uint32_t colour = n; ok && colour-- > 0;) {
        b->closing_colour = colour;
        ok = motion_launch(m, NOTE_LACKS, err) && motion_launch(m, TAKE_NEEDED, err);
    }
    return ok;
}

static bool take_own(duet_motion *m, uint32_t from, duet_error *err)
{
    m->border.closing_colour = from;
    return motion_launch(m, TAKE_OWN, err);
}

// If ghosts come after each colour, only contacts of own ends are solved.
static bool find_solved(duet_motion *m, duet_error *err)
{
    if (m->border.n_border == 0)
        return true;
    if (m->border.every == 1)
        return take_own(m, 0, err);
    return take_needed(m, err) && take_own(m, COLOUR_OVERFLOW, err);
}

bool domain_close(duet_motion *m, uint32_t every, duet_error *err)
{
    m->border.every = every;
    m->border.n_border = 0;
    return !has_contacts(m) ||
           (begin(m, err) && find_solved(m, err) && motion_launch(m, END_CONTACTS, err) &&
            motion_launch(m, END_GHOSTS, err));
}

// ---------------------------------------------------------------- contacts that are asked for

size_t domain_asked_bytes(const duet_motion *m)
{
    return (ASKED_RECORD + m->layout.record) * sizeof(cl_uint);
}

static bool send_asked(duet_motion *m, const asked_contact *asked, uint32_t n, duet_error *err)
{
    m->reading.n_ids = n;
    m->reading.row_words = m->layout.record;
    return motion_reserve(m, ASKED, n, sizeof *asked, err) &&
           motion_reserve(m, GATHERED, n, domain_asked_bytes(m), err) &&
           timeline_write_at(&m->times, stage, &m->buffers[ASKED], 0, asked, n * sizeof *asked,
                             err);
}

bool domain_read_asked(duet_motion *m, const asked_contact *asked, uint32_t n, void *rows,
                       duet_error *err)
{
    return n == 0 || (send_asked(m, asked, n, err) && motion_launch(m, READ_ASKED, err) &&
                      motion_fetch(m, stage, GATHERED, 0, rows, n * domain_asked_bytes(m), err));
}

bool domain_take_asked(duet_motion *m, const asked_contact *asked, uint32_t n, const void *rows,
                       duet_error *err)
{
    return n == 0 || (send_asked(m, asked, n, err) &&
                      timeline_write_at(&m->times, stage, &m->buffers[GATHERED], 0, rows,
                                        n * domain_asked_bytes(m), err) &&
                      motion_launch(m, TAKE_ASKED, err) && timeline_finish(&m->times, err));
}

bool domain_count_closed(duet_motion *m, domain_closed *found, duet_error *err)
{
    cl_uint words[2] = {0, 0};
    bool ok = !has_contacts(m) || motion_fetch(m, stage, CLOSING, CLOSING_FOREIGN * sizeof *words,
                                               words, sizeof words, err);
    *found = (domain_closed){words[0], words[1]};
    return ok;
}
