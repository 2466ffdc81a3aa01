// SPDX-License-Identifier: MIT
// Bodies near the borders of a domain, which the device lists for the host.
#include "base/error.h"
#include "kernels/dynamics/border.h"
#include "runtime/dynamics/domain_motion.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char stage[] = "domain";

static_assert(sizeof(domain_near) == NEAR_WORDS * sizeof(cl_uint), "a row of near");

static bool send_extents(duet_motion *m, const float *extents, uint32_t n, duet_error *err)
{
    const size_t bytes = n * 6 * sizeof *extents;
    m->border.n_extents = n;
    return motion_reserve(m, EXTENTS, n, 6 * sizeof *extents, err) &&
           timeline_write_at(&m->times, stage, &m->buffers[EXTENTS], 0, extents, bytes, err);
}

// ---------------------------------------------------------------- the list

// The first row tells of the others.
static bool run(duet_motion *m, motion_kernel which, domain_near *head, duet_error *err)
{
    const uint64_t rows = (uint64_t)m->border.near_capacity + 1;
    return motion_reserve(m, NEAR, rows, sizeof *head, err) &&
           motion_clear(m, stage, NEAR, 0, NEAR_WORDS, err) && motion_launch(m, which, err) &&
           motion_fetch(m, stage, NEAR, 0, head, sizeof *head, err);
}

// Its place is the number of bodies.
static bool run_with_room(duet_motion *m, motion_kernel which, domain_near *head, duet_error *err)
{
    if (!run(m, which, head, err))
        return false;
    if (head->place <= m->border.near_capacity)
        return true;
    m->border.near_capacity = head->place + head->place / 4;
    return run(m, which, head, err);
}

static bool fetch(duet_motion *m, uint32_t n, domain_near **list, duet_error *err)
{
    if (n == 0)
        return true;
    *list = malloc(n * sizeof **list);
    return *list ? motion_fetch(m, stage, NEAR, sizeof **list, *list, n * sizeof **list, err)
                 : no_memory(err, "%u bodies", n);
}

bool domain_list_near(duet_motion *m, const float *extents, uint32_t n, domain_near **list,
                      uint32_t *n_list, duet_error *err)
{
    domain_near head = {0};
    *list = NULL;
    bool ok = m->n == 0 || (domain_make_bounds(m, err) && send_extents(m, extents, n, err) &&
                            run_with_room(m, LIST_NEAR, &head, err));
    *n_list = head.place;
    return ok && fetch(m, *n_list, list, err);
}

// ---------------------------------------------------------------- far boxes

// The number of a word (kernels/primitives/sortable.clh); 0 is below all.
static float number_of(uint32_t word)
{
    float number;
    const uint32_t bits = word >> 31 ? word & 0x7FFFFFFFu : ~word;
    memcpy(&number, &bits, sizeof number);
    return word == 0 ? -INFINITY : number;
}

static void read_reach(const domain_near *head, float reach[6])
{
    uint32_t words[6];
    memcpy(words, head->bounds, sizeof words);
    for (int k = 0; k < 3; ++k) {
        reach[k] = -number_of(words[k]);
        reach[k + 3] = number_of(words[k + 3]);
    }
}

bool domain_keep_far_boxes(duet_motion *m, duet_error *err)
{
    return !(m->effects & DUET_EFFECT_CONTACT) || m->kernels.of[MAKE_FAR_BOXES] ||
           (motion_build_ahead(m, MAKE_FAR_BOXES, err) && motion_grow_rows(m, FAR_BOXES, 0, err));
}

bool domain_make_far_boxes(duet_motion *m, const domain_far *far, float reach[6],
                           domain_near **list, uint32_t *n_list, duet_error *err)
{
    domain_near head = {0};
    *list = NULL;
    m->border.far_time = far->time;
    m->border.far_margin = far->margin;
    domain_forget_bounds(m); // others than those that the next step makes
    bool ok = m->n == 0 ||
              (domain_keep_far_boxes(m, err) && domain_make_bounds(m, err) &&
               send_extents(m, far->home, 1, err) && run_with_room(m, MAKE_FAR_BOXES, &head, err));
    read_reach(&head, reach);
    *n_list = head.place;
    return ok && fetch(m, *n_list, list, err);
}

bool domain_list_meeting(duet_motion *m, const float *extents, uint32_t n, domain_near **list,
                         uint32_t *n_list, duet_error *err)
{
    domain_near head = {0};
    *list = NULL;
    bool ok = m->n == 0 || n == 0 ||
              (send_extents(m, extents, n, err) && run_with_room(m, LIST_MEETING, &head, err));
    *n_list = head.place;
    return ok && fetch(m, *n_list, list, err);
}
