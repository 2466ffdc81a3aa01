// SPDX-License-Identifier: MIT
// What contacts there are, for the caller.
#include "runtime/dynamics/motion.h"

#include "base/error.h"

#include <stdlib.h>
#include <string.h>

static duet_contact read_record(const duet_motion *m, const uint32_t link[2], uint32_t n,
                                const float *record)
{
    const motion_layout *l = &m->layout;
    duet_contact c = {.a = link[0], .b = link[1], .n = n};
    memcpy(c.normal, record + AT_NORMAL, sizeof c.normal);
    for (uint32_t k = 0; k < n; ++k) {
        const float *saved = record + l->head + k * l->point;
        memcpy(c.points[k].anchor, saved + OF_ANCHOR, sizeof c.points[k].anchor);
        c.points[k].separation = saved[OF_SEPARATION];
        c.points[k].normal_impulse =
            motion_has(m, DUET_EFFECT_CONTACT_RESPONSE) ? saved[OF_NORMAL_IMPULSE] : 0.0f;
    }
    return c;
}

static bool fetch(duet_motion *m, motion_buffer which, void *to, size_t bytes, duet_error *err)
{
    return timeline_read(&m->times, "fetch", &m->buffers[which], to, bytes, err);
}

bool duet_motion_get_contacts(duet_motion *m, duet_contact **contacts, uint64_t *n, duet_error *err)
{
    if (!motion_is_whole(m, __func__, err) || !error_given(contacts, __func__, "contacts", err) ||
        !error_given(n, __func__, "n", err))
        return false;
    size_t count = m->n_contacts;
    size_t record = m->layout.record;
    uint32_t(*links)[2] = malloc(count * sizeof *links + 1);
    uint32_t *touches = malloc(count * sizeof *touches + 1);
    float *records = malloc(count * record * sizeof *records + 1);
    duet_contact *found = malloc(count * sizeof *found + 1);
    bool ok = links && touches && records && found;
    if (!ok)
        error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %zu contacts", count);
    ok = ok && fetch(m, LINKS, links, count * sizeof *links, err) &&
         fetch(m, TOUCHES, touches, count * sizeof *touches, err) &&
         fetch(m, CONTACTS, records, count * record * sizeof *records, err) &&
         timeline_finish(&m->times, err);
    *n = 0;
    for (size_t i = 0; ok && i < count; ++i)
        if (touches[i] & TOUCH_POINTS)
            found[(*n)++] =
                read_record(m, links[i], touches[i] & TOUCH_POINTS, records + i * record);
    free(links);
    free(touches);
    free(records);
    *contacts = ok ? found : NULL;
    if (!ok)
        free(found);
    return ok;
}
