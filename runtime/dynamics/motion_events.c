// SPDX-License-Identifier: MIT
// What began, stays and ended is told by comparing the pairs that touch with those of the
// step before. The device says a bit a contact; its contacts are by owner, so that pairs
// come nearly in order.
#include "runtime/dynamics/domain_motion.h"

#include "base/compare.h"
#include "base/error.h"

#include <stdlib.h>
#include <string.h>

void motion_free_events(motion_events *e)
{
    pair_list_free(&e->links);
    pair_list_free(&e->touching);
    pair_list_free(&e->before);
    pair_changes_free(&e->changes);
    free(e->hits);
    *e = (motion_events){0};
}

void motion_forget_events(motion_events *e)
{
    e->links_of = 0;
}

static bool is_told(const duet_motion *m, duet_pair p)
{
    uint32_t groups = m->bodies[p.a].group | (p.b < m->n ? m->bodies[p.b].group : 0);
    return groups & m->def.event_mask;
}

static bool fetch(duet_motion *m, motion_buffer which, void *to, size_t bytes, duet_error *err)
{
    return timeline_read(&m->times, "events", &m->buffers[which], to, bytes, err);
}

// ---------------------------------------------------------------- what touches

// All contacts with the ground are one pair.
static duet_pair told_pair(const duet_motion *m, duet_pair link)
{
    if (link.b > m->n + AT_GROUND)
        link.b = m->n + AT_GROUND;
    return link;
}

static void add_touching(motion_events *e, duet_pair p)
{
    const duet_pair *last = e->touching.n > 0 ? &e->touching.pairs[e->touching.n - 1] : NULL;
    if (!last || last->a != p.a || last->b != p.b)
        e->touching.pairs[e->touching.n++] = p;
}

static void list_touching(duet_motion *m, const uint32_t *words)
{
    motion_events *e = &m->told;
    e->touching.n = 0;
    for (size_t i = 0; i < e->links.n; ++i)
        if ((words[i / 32] >> i % 32 & 1u) && is_told(m, e->links.pairs[i]))
            add_touching(e, told_pair(m, e->links.pairs[i]));
}

// A bit for each contact, and the links if rows are not the last step's.
static bool fetch_bits(duet_motion *m, uint32_t *words, size_t n_words, duet_error *err)
{
    motion_events *e = &m->told;
    bool same = e->links_of != 0 && e->links_of == m->products.of[PRODUCT_ROWS].stamp;
    e->links.n = m->graph.n_contacts;
    return (same ||
            fetch(m, LINKS, e->links.pairs, m->graph.n_contacts * sizeof *e->links.pairs, err)) &&
           fetch(m, TOUCHING, words, n_words * sizeof *words, err);
}

static bool fetch_touching(duet_motion *m, duet_error *err)
{
    motion_events *e = &m->told;
    size_t n = m->graph.n_contacts, n_words = (n + 31) / 32;
    if (n == 0) {
        e->links.n = e->touching.n = 0;
        e->links_of = m->products.of[PRODUCT_ROWS].stamp;
        return true;
    }
    uint32_t *words = malloc(n_words * sizeof *words);
    if (!words)
        return no_memory(err, "%u contacts", m->graph.n_contacts);
    bool ok = pair_list_reserve(&e->links, n, err) && pair_list_reserve(&e->touching, n, err) &&
              fetch_bits(m, words, n_words, err);
    if (ok)
        list_touching(m, words);
    e->links_of = ok ? m->products.of[PRODUCT_ROWS].stamp : 0;
    free(words);
    return ok && pair_list_sort(&e->touching, err);
}

bool motion_note_events(duet_motion *m, duet_error *err)
{
    uint64_t n = m->graph.n_contacts, n_words = (n + 31) / 32;
    bool hits = motion_tells_hits(m);
    return !m->kernels.of[CONTACT_EVENTS] ||
           (motion_reserve(m, TOUCHING, n_words + 1, sizeof(uint32_t), err) &&
            (!hits || motion_reserve(m, HITS, n + 1, HIT_WORDS * sizeof(uint32_t), err)) &&
            motion_launch(m, CONTACT_EVENTS, err));
}

bool motion_recall_events(duet_motion *m, duet_error *err)
{
    return !m->kernels.of[CONTACT_EVENTS] ||
           m->told.links_of == m->products.of[PRODUCT_ROWS].stamp ||
           (motion_note_events(m, err) && fetch_touching(m, err));
}

// ---------------------------------------------------------------- hits

static float float_at(const uint32_t *word)
{
    float value;
    memcpy(&value, word, sizeof value);
    return value;
}

// The centre of the contact's owner when the step began.
static double centre_of(const duet_motion *m, const uint32_t *words, uint32_t k)
{
    double value;
    if (m->def.doubles) {
        memcpy(&value, words + 2 * (size_t)k, sizeof value);
        return value;
    }
    value = float_at(words + k);
    return m->cells ? value + (double)(int32_t)words[3 + k] * m->def.origin_edge : value;
}

static duet_hit_event hit_of(const duet_motion *m, const uint32_t words[HIT_WORDS])
{
    bool owned = words[0] < words[1];
    duet_hit_event hit = {.a = owned ? words[0] : words[1],
                          .b = owned ? words[1] : words[0],
                          .speed = float_at(words + 8),
                          .impulse = float_at(words + 9)};
    for (uint32_t k = 0; k < 3; ++k) {
        float normal = float_at(words + 2 + k);
        hit.normal[k] = owned ? normal : -normal;
        hit.point[k] = centre_of(m, words + HIT_CENTRE, k) + (double)float_at(words + 5 + k);
    }
    return hit;
}

// Of hits of one body and the ground the fastest is left.
static void join_hits(motion_events *e)
{
    size_t n = 0;
    for (size_t i = 0; i < e->n_hits; ++i) {
        const duet_hit_event *hit = &e->hits[i];
        duet_hit_event *last = n > 0 ? &e->hits[n - 1] : NULL;
        if (!last || last->a != hit->a || last->b != hit->b)
            e->hits[n++] = *hit;
        else if (hit->speed > last->speed ||
                 (hit->speed == last->speed && hit->impulse > last->impulse))
            *last = *hit;
    }
    e->n_hits = n;
}

// Devices write them in any order.
static bool fetch_hits(duet_motion *m, size_t n, duet_error *err)
{
    motion_events *e = &m->told;
    e->n_hits = 0;
    if (n == 0)
        return true;
    uint32_t(*words)[HIT_WORDS] = malloc(n * sizeof *words);
    if (!words)
        return no_memory(err, "%zu events", n);
    bool ok = fetch(m, HITS, words, n * sizeof *words, err);
    for (size_t i = 0; ok && i < n; ++i) {
        duet_hit_event hit = hit_of(m, words[i]);
        hit.b = hit.b > m->n + AT_GROUND ? m->n + AT_GROUND : hit.b;
        if (is_told(m, (duet_pair){hit.a, hit.b}))
            e->hits[e->n_hits++] = hit;
    }
    if (ok)
        qsort(e->hits, e->n_hits, sizeof *e->hits, compare_uint32_pair);
    if (ok)
        join_hits(e);
    free(words);
    return ok;
}

// ---------------------------------------------------------------- a step

static void swap(pair_list *a, pair_list *b)
{
    pair_list kept = *a;
    *a = *b;
    *b = kept;
}

// Pairs that touch stay if nothing moved.
bool motion_find_events(duet_motion *m, bool moved, duet_error *err)
{
    motion_events *e = &m->told;
    size_t n_hits = moved && motion_tells_hits(m) ? m->flags[FLAG_EVENTS] : 0;
    if (moved)
        swap(&e->before, &e->touching);
    return (!moved || fetch_touching(m, err)) &&
           pair_changes_find(&e->changes, moved ? &e->before : &e->touching, &e->touching, err) &&
           pair_list_grow((void **)&e->hits, &e->hit_capacity, n_hits, sizeof *e->hits, err) &&
           fetch_hits(m, n_hits, err);
}

// ---------------------------------------------------------------- stage by stage

bool domain_note_events(duet_motion *m, duet_error *err)
{
    motion_forget_events(&m->told);
    return m->n == 0 || motion_note_events(m, err);
}

bool domain_list_touching(duet_motion *m, duet_error *err)
{
    return m->n == 0 || !m->kernels.of[CONTACT_EVENTS] || fetch_touching(m, err);
}

static bool mark_told(duet_motion *m, uint32_t *words, size_t n_words, uint8_t *told,
                      duet_error *err)
{
    motion_events *e = &m->told;
    if (!pair_list_reserve(&e->links, m->graph.n_contacts, err) ||
        !fetch_bits(m, words, n_words, err))
        return false;
    for (size_t i = 0; i < e->links.n; ++i)
        told[i] = (words[i / 32] >> i % 32 & 1u) && is_told(m, e->links.pairs[i]);
    return true;
}

bool domain_read_told(duet_motion *m, uint8_t *told, duet_error *err)
{
    size_t n = m->n > 0 ? m->graph.n_contacts : 0, n_words = (n + 31) / 32;
    memset(told, 0, n);
    m->told.links.n = 0;
    if (!m->kernels.of[CONTACT_EVENTS] || n == 0)
        return true;
    uint32_t *words = malloc(n_words * sizeof *words);
    bool ok = words ? mark_told(m, words, n_words, told, err) : no_memory(err, "%zu contacts", n);
    free(words);
    return ok;
}

bool domain_read_hits(duet_motion *m, const duet_hit_event **hits, size_t *n, duet_error *err)
{
    motion_events *e = &m->told;
    *n = 0;
    if (!motion_tells_hits(m) || m->n == 0)
        return true;
    if (!motion_read_flags(m, err))
        return false;
    size_t most = m->flags[FLAG_EVENTS];
    bool ok = pair_list_grow((void **)&e->hits, &e->hit_capacity, most, sizeof *e->hits, err) &&
              fetch_hits(m, most, err);
    *hits = e->hits;
    *n = ok ? e->n_hits : 0;
    return ok;
}
