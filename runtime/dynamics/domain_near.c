// SPDX-License-Identifier: MIT
// Bodies near the borders of a domain, which the device lists for the host.
#include "base/error.h"
#include "kernels/dynamics/border.h"
#include "runtime/dynamics/domain_motion.h"

#include <assert.h>
#include <stdlib.h>

static const char stage[] = "domain";

static_assert(sizeof(domain_near) == NEAR_WORDS * sizeof(cl_uint), "a row of near");

static bool build_near(duet_motion *m, duet_error *err)
{
    const kernel_request list[] = {
        {&m->border.list_near, true, "list_near", "list_near", motion_bindings},
    };
    return m->border.list_near || motion_build_kernels(m, list, 1, false, err);
}

static bool send_extents(duet_motion *m, const float *extents, uint32_t n, duet_error *err)
{
    const size_t bytes = n * 6 * sizeof *extents;
    m->border.n_extents = n;
    return motion_reserve(m, EXTENTS, n, 6 * sizeof *extents, err) &&
           timeline_write_at(&m->times, stage, &m->buffers[EXTENTS], 0, extents, bytes, err);
}

// The first row is the number of the others.
static bool count_near(duet_motion *m, cl_uint *n, duet_error *err)
{
    const uint64_t rows = (uint64_t)m->border.near_capacity + 1;
    return motion_reserve(m, NEAR, rows, sizeof(domain_near), err) &&
           motion_clear(m, stage, NEAR, 0, 1, err) &&
           motion_launch(m, stage, m->border.list_near, m->n, err) &&
           motion_fetch(m, stage, NEAR, 0, n, sizeof *n, err);
}

static bool find_near(duet_motion *m, cl_uint *n, duet_error *err)
{
    if (!count_near(m, n, err))
        return false;
    if (*n <= m->border.near_capacity)
        return true;
    m->border.near_capacity = *n + *n / 4;
    return count_near(m, n, err);
}

bool domain_list_near(duet_motion *m, const float *extents, uint32_t n, domain_near **list,
                      uint32_t *n_list, duet_error *err)
{
    *list = NULL;
    *n_list = 0;
    if (m->n == 0)
        return true;
    bool ok = domain_make_bounds(m, err) && build_near(m, err) &&
              send_extents(m, extents, n, err) && find_near(m, n_list, err);
    const size_t bytes = *n_list * sizeof **list;
    if (!ok || *n_list == 0)
        return ok;
    *list = malloc(bytes);
    return *list ? motion_fetch(m, stage, NEAR, sizeof **list, *list, bytes, err)
                 : error_set(err, DUET_STATUS_NO_MEMORY, "no memory for %u bodies", *n_list);
}
