// SPDX-License-Identifier: MIT
#include "runtime/dynamics/motion.h"

static const char stage[] = "sleep";

static uint32_t count_parts(const duet_motion *m)
{
    const kernel *k = m->kernels.of[LIST_AWAKE];
    uint32_t most = m->n > m->graph.n_contacts ? m->n : m->graph.n_contacts;
    return (uint32_t)(((uint64_t)most + k->per_item - 1) / k->per_item);
}

static cl_uint *counted(const duet_motion *m)
{
    return m->awake.counts.bytes;
}

static bool reserve(duet_motion *m, duet_error *err)
{
    const size_t word = sizeof(uint32_t);
    return host_block_reserve(&m->awake.counts, m->device, 1, LISTED * word, err) &&
           motion_reserve(m, LEVELS, m->n, word, err) &&
           motion_reserve(m, PART_COUNTS, 2 * (uint64_t)m->awake.n_parts + 1, word, err) &&
           motion_reserve(m, AWAKE, m->n, word, err) &&
           motion_reserve(m, AWAKE_CONTACTS, (uint64_t)m->graph.n_contacts + 1, word, err) &&
           motion_reserve(m, N_LISTED, LISTED, word, err);
}

// woken: 1 adds to the last lists what is awake.
static bool list(duet_motion *m, uint32_t woken, duet_error *err)
{
    awake_lists *a = &m->awake;
    buffer *counts = &m->buffers[PART_COUNTS];
    uint64_t work = (uint64_t)a->n_parts * m->kernels.of[LIST_AWAKE]->per_item;
    m->solver.woken = woken;
    a->n_bodies = m->n;
    a->n_contacts = m->graph.n_contacts;
    return motion_launch(m, MARK_AWAKE, err) && motion_launch_over(m, SPREAD_AWAKE, work, err) &&
           motion_launch_over(m, COUNT_AWAKE, work, err) &&
           scan_run(&m->graph.scan, &m->times, stage, counts, counts, 2 * a->n_parts + 1, err) &&
           motion_launch_over(m, LIST_AWAKE, work, err) &&
           timeline_start_read(&m->times, stage, &m->buffers[N_LISTED], 0, counted(m),
                               LISTED * sizeof *counted(m), err);
}

// Lists of more than one in FEW bodies are not made, but for each COUNTED_EVERY steps if something
// woke or fell asleep: then it is seen whether they have become fewer.
enum { FEW = 2, COUNTED_EVERY = 16 };

static bool are_most_awake(const duet_motion *m)
{
    const awake_lists *a = &m->awake;
    bool due = a->changed_in >= a->counted_in && m->step - a->counted_in >= COUNTED_EVERY;
    return counted(m)[LISTED_BODIES] > m->n / FEW && !due;
}

// Bodies that were never prepared are, with all others, in the first step.
bool motion_make_awake(duet_motion *m, duet_error *err)
{
    awake_lists *a = &m->awake;
    a->n_bodies = m->n;
    a->n_contacts = m->graph.n_contacts;
    bool made = a->counts.bytes && product_was_made(&m->products, PRODUCT_AWAKE);
    product_renew(&m->products, PRODUCT_AWAKE);
    a->all_awake = !(m->effects & DUET_EFFECT_SLEEP);
    if (a->all_awake)
        return true;
    a->n_parts = count_parts(m);
    if (!reserve(m, err))
        return false;
    if (!made)
        counted(m)[LISTED_BODIES] = 0; // the next step counts
    a->all_awake = !made || are_most_awake(m);
    if (a->all_awake)
        return true;
    a->counted_in = m->step;
    return list(m, 0, err);
}

bool motion_list_woken(duet_motion *m, duet_error *err)
{
    return motion_launch(m, WAKE_TOUCHING, err) && list(m, 1, err);
}

void motion_count_awake(duet_motion *m)
{
    if (m->awake.all_awake)
        return;
    m->awake.n_bodies = counted(m)[LISTED_BODIES];
    m->awake.n_contacts = counted(m)[LISTED_CONTACTS];
}

void motion_note_awake(duet_motion *m)
{
    motion_count_awake(m);
    if (m->flags[FLAG_FELL_ASLEEP])
        m->awake.changed_in = m->step;
    if (m->awake.all_awake || m->flags[FLAG_FELL_ASLEEP] || m->flags[FLAG_PRESSED])
        product_forget(&m->products, PRODUCT_AWAKE);
}
