// SPDX-License-Identifier: MIT
#include "cluster/worker_search.h"

#include "base/error.h"

// Without homes there are no pairs of this rank's, and nothing is built.
static void run(void *arg)
{
    worker_search *s = arg;
    s->ok = true;
    if (seen_homes(s->seen) == 0)
        return;
    if (s->tells_ids && s->worker->tell_ids)
        s->worker->tell_ids(s->worker, &s->ids);
    s->ok = s->worker->find(s->worker, &s->found, &s->err);
}

void worker_search_begin(worker_search *s, parallel *beside)
{
    s->beside = beside;
    if (beside)
        parallel_call_begin(beside, run, s);
    else
        run(s);
}

bool worker_search_end(worker_search *s, duet_error *err)
{
    if (s->beside)
        parallel_call_end(s->beside);
    s->beside = NULL;
    if (!s->ok)
        return error_copy(err, &s->err);
    return seen_check_found(s->seen, &s->found, err);
}
