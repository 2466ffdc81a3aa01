// SPDX-License-Identifier: MIT
// What began, stays and ended is told by comparing the pairs that touch with those of the
// step before. The device says a bit a contact; its contacts are by owner, so that pairs
// come nearly in order.
#include "runtime/dynamics/motion.h"

#include "base/error.h"

#include <stdlib.h>
#include <string.h>

static bool reserve(void **rows, size_t *capacity, size_t n, size_t size, duet_error *err)
{
    if (n <= *capacity)
        return true;
    void *grown = realloc(*rows, n * size);
    if (!grown)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %zu events", n);
    *rows = grown;
    *capacity = n;
    return true;
}

static bool reserve_pairs(pair_list *list, size_t n, duet_error *err)
{
    return reserve((void **)&list->pairs, &list->capacity, n, sizeof *list->pairs, err);
}

void motion_free_events(motion_events *e)
{
    free(e->links.pairs);
    free(e->touching.pairs);
    free(e->stays.pairs);
    free(e->before.pairs);
    free(e->events);
    free(e->hits);
    *e = (motion_events){0};
}

static bool is_told(const duet_motion *m, duet_pair p)
{
    uint32_t groups = m->bodies[p.a].group | (p.b < m->n ? m->bodies[p.b].group : 0);
    return groups & m->def.event_mask;
}

static duet_pair ordered(duet_pair link)
{
    return link.a < link.b ? link : (duet_pair){link.b, link.a};
}

// ---------------------------------------------------------------- what touches

// Of one a all b come in order already, for either a owns all its contacts with those above
// it or, without a mass, none.
static bool sort_by_first(pair_list *list, uint32_t n_objects, duet_error *err)
{
    bool sorted = true;
    for (size_t i = 1; sorted && i < list->n; ++i)
        sorted = list->pairs[i - 1].a <= list->pairs[i].a;
    if (sorted)
        return true;
    size_t *places = calloc((size_t)n_objects + 1, sizeof *places);
    duet_pair *pairs = malloc(list->n * sizeof *pairs);
    bool ok = places && pairs;
    if (!ok)
        error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %zu events", list->n);
    for (size_t i = 0; ok && i < list->n; ++i)
        ++places[list->pairs[i].a + 1];
    for (uint32_t id = 0; ok && id < n_objects; ++id)
        places[id + 1] += places[id];
    for (size_t i = 0; ok && i < list->n; ++i)
        pairs[places[list->pairs[i].a]++] = list->pairs[i];
    if (ok)
        memcpy(list->pairs, pairs, list->n * sizeof *pairs);
    free(places);
    free(pairs);
    return ok;
}

static bool list_touching(duet_motion *m, const uint32_t *words, duet_error *err)
{
    motion_events *e = &m->told;
    if (!reserve_pairs(&e->touching, e->links.n, err))
        return false;
    e->touching.n = 0;
    for (size_t i = 0; i < e->links.n; ++i) {
        if (!(words[i / 32] >> i % 32 & 1u))
            continue;
        duet_pair p = ordered(e->links.pairs[i]);
        if (is_told(m, p))
            e->touching.pairs[e->touching.n++] = p;
    }
    return sort_by_first(&e->touching, m->n, err);
}

// Rows are those of the last step until pairs are searched again.
static bool fetch_links(duet_motion *m, duet_error *err)
{
    motion_events *e = &m->told;
    if (e->known && !m->rebuilt)
        return true;
    e->links.n = 0;
    if (!reserve_pairs(&e->links, m->n_contacts, err) ||
        !timeline_read(&m->times, "events", &m->buffers[LINKS], e->links.pairs,
                       m->n_contacts * sizeof *e->links.pairs, err))
        return false;
    e->links.n = m->n_contacts;
    return true;
}

static bool fetch_touching(duet_motion *m, duet_error *err)
{
    size_t n_words = ((size_t)m->n_contacts + 31) / 32;
    if (n_words == 0) {
        m->told.links.n = m->told.touching.n = 0;
        return true;
    }
    uint32_t *words = malloc(n_words * sizeof *words);
    if (!words)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %u contacts", m->n_contacts);
    bool ok = fetch_links(m, err) &&
              timeline_read(&m->times, "events", &m->buffers[TOUCHING], words,
                            n_words * sizeof *words, err) &&
              list_touching(m, words, err);
    free(words);
    return ok;
}

bool motion_note_events(duet_motion *m, duet_error *err)
{
    uint64_t n_words = ((uint64_t)m->n_contacts + 31) / 32;
    return !m->kernels.contact_events ||
           (motion_reserve(m, TOUCHING, n_words + 1, sizeof(uint32_t), err) &&
            (!motion_tells_hits(m) || motion_reserve(m, HITS, (uint64_t)m->n_contacts + 1,
                                                     HIT_WORDS * sizeof(uint32_t), err)) &&
            motion_launch(m, "events", m->kernels.contact_events, n_words, err));
}

bool motion_recall_events(duet_motion *m, duet_error *err)
{
    if (!m->kernels.contact_events || m->told.known)
        return true;
    m->told.known = motion_note_events(m, err) && fetch_touching(m, err);
    return m->told.known;
}

// ---------------------------------------------------------------- what changed

static int compare(duet_pair x, duet_pair y)
{
    return x.a != y.a ? (x.a < y.a ? -1 : 1) : x.b != y.b ? (x.b < y.b ? -1 : 1) : 0;
}

static bool compare_steps(motion_events *e, duet_error *err)
{
    const pair_list *before = &e->before, *now = &e->touching;
    if (!reserve_pairs(&e->stays, now->n, err) ||
        !reserve((void **)&e->events, &e->event_capacity, before->n + now->n, sizeof *e->events,
                 err))
        return false;
    e->n_events = e->stays.n = 0;
    for (size_t i = 0, k = 0; i < before->n || k < now->n;) {
        int order = i == before->n ? 1
                    : k == now->n  ? -1
                                   : compare(before->pairs[i], now->pairs[k]);
        duet_pair p = order < 0 ? before->pairs[i] : now->pairs[k];
        i += order <= 0;
        k += order >= 0;
        if (order == 0)
            e->stays.pairs[e->stays.n++] = p;
        else
            e->events[e->n_events++] = (duet_event){p.a, p.b, order > 0};
    }
    return true;
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

static int by_ids(const void *x, const void *y)
{
    const duet_hit_event *a = x, *b = y;
    return compare((duet_pair){a->a, a->b}, (duet_pair){b->a, b->b});
}

// Devices write them in any order.
static bool fetch_hits(duet_motion *m, duet_error *err)
{
    motion_events *e = &m->told;
    size_t n = motion_tells_hits(m) ? m->flags[FLAG_EVENTS] : 0;
    e->n_hits = 0;
    if (n == 0)
        return true;
    uint32_t(*words)[HIT_WORDS] = malloc(n * sizeof *words);
    if (!words)
        return error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %zu events", n);
    bool ok = reserve((void **)&e->hits, &e->hit_capacity, n, sizeof *e->hits, err) &&
              timeline_read(&m->times, "events", &m->buffers[HITS], words, n * sizeof *words, err);
    for (size_t i = 0; ok && i < n; ++i) {
        duet_hit_event hit = hit_of(m, words[i]);
        if (is_told(m, (duet_pair){hit.a, hit.b}))
            e->hits[e->n_hits++] = hit;
    }
    if (ok)
        qsort(e->hits, e->n_hits, sizeof *e->hits, by_ids);
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

bool motion_fetch_events(duet_motion *m, duet_error *err)
{
    motion_events *e = &m->told;
    swap(&e->before, &e->touching);
    return fetch_touching(m, err) && compare_steps(e, err) && fetch_hits(m, err);
}

bool motion_keep_events(duet_motion *m, duet_error *err)
{
    motion_events *e = &m->told;
    e->n_hits = e->n_events = 0;
    if (!reserve_pairs(&e->stays, e->touching.n, err))
        return false;
    e->stays.n = e->touching.n;
    if (e->touching.n > 0)
        memcpy(e->stays.pairs, e->touching.pairs, e->touching.n * sizeof *e->stays.pairs);
    return true;
}
