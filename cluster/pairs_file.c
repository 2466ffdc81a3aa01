// SPDX-License-Identifier: MIT
// All ranks write their pairs into one file at once. Rank 0 opens it under a temporary name and
// puts it in its place; if any rank fails or is ended, the file is removed.
#define _POSIX_C_SOURCE 200809L
#include "base/error.h"
#include "base/npy.h"
#include "base/output.h"
#include "cluster/cluster.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

// ---------------------------------------------------------------- order

static int ascending(const void *left, const void *right)
{
    const duet_pair64 *p = left, *q = right;
    if (p->a != q->a)
        return p->a < q->a ? -1 : 1;
    return (p->b > q->b) - (p->b < q->b);
}

// Pairs go to ranks in equal runs of ids, whatever ids there are.
typedef struct dealing {
    const duet_pair64 *pairs;
    uint64_t run; // ids of each rank
} dealing;

static int rank_of(const void *context, uint64_t i)
{
    const dealing *d = context;
    return (int)(d->pairs[i].a / d->run);
}

// Sends each pair to the rank of its a, and sorts what arrives: then ranks, one after the
// other, have all pairs ascending.
static bool sort_pairs(duet_cluster *c, parcels *sorted, duet_error *err)
{
    ranks *r = &c->ranks;
    uint64_t most = 0;
    for (uint64_t i = 0; i < c->own.n; ++i)
        most = most > c->own.pairs[i].a ? most : c->own.pairs[i].a;
    most = UINT64_MAX - most;
    ranks_least(r, &most, 1);
    most = UINT64_MAX - most;
    const dealing d = {c->own.pairs, most / (uint64_t)r->n + 1};
    const parcels_def out = {.n = c->own.n,
                             .row_bytes = sizeof(duet_pair64),
                             .rows = c->own.pairs,
                             .rank_of = rank_of,
                             .context = &d};
    if (!parcels_deal(r, true, &out, sorted, err))
        return false;
    qsort(sorted->rows, sorted->n, sizeof(duet_pair64), ascending);
    return true;
}

// ---------------------------------------------------------------- the file

static bool check(bool ok, const char *path, duet_error *err)
{
    return ok || error_set(err, DUET_STATUS_IO_FAILED, "%s: cannot be written: %s", path,
                           errno ? strerror(errno) : "the disk is full");
}

// The file has its whole size before any rank opens it: if it grows, a client of a network file
// system may write a page that it shares with another's range as a whole, with zeros there.
static bool open_file(output *o, const char *path, uint64_t pairs, uint64_t *values_at, text *part,
                      duet_error *err)
{
    text header = {0};
    npy_add_header(&header, NPY_UINT64, pairs, 2);
    bool ok = text_ok(&header, err) && output_open(o, path, err) && output_part_path(o, part, err);
    uint64_t bytes = header.length + pairs * sizeof(duet_pair64);
    errno = 0;
    ok = ok && check(ftruncate(fileno(o->stream), (off_t)bytes) == 0, path, err) &&
         check(fwrite(header.chars, 1, header.length, o->stream) == header.length &&
                   fflush(o->stream) == 0,
               path, err);
    *values_at = header.length;
    text_free(&header);
    return ok;
}

static bool write_all(int file, uint64_t at, const void *bytes, size_t n)
{
    const unsigned char *from = bytes;
    while (n > 0) {
        errno = 0;
        ssize_t written = pwrite(file, from, n, (off_t)at);
        if (written <= 0 && errno != EINTR)
            return false;
        size_t done = written > 0 ? (size_t)written : 0;
        from += done;
        at += done;
        n -= done;
    }
    return true;
}

// Each rank writes its own range with plain calls. MPI-IO would gather small pieces to large ones,
// but a rank has one piece; and if the disk is full it may write less than all and call it success.
static bool write_values(const char *part, uint64_t at, const void *pairs, uint64_t n,
                         const char *path, duet_error *err)
{
    int file = open(part, O_WRONLY | O_CLOEXEC);
    if (file < 0)
        return error_set(err, DUET_STATUS_IO_FAILED,
                         "%s: cannot be written: %s; expected a folder that all hosts share", path,
                         strerror(errno));
    bool ok = check(write_all(file, at, pairs, n * sizeof(duet_pair64)), path, err);
    return check(close(file) == 0, path, ok ? err : NULL) && ok;
}

static bool write_pairs(duet_cluster *c, const char *path, const void *pairs, uint64_t n,
                        duet_error *err)
{
    ranks *r = &c->ranks;
    output o = {.folder = -1, .slot = -1};
    text part = {0};
    uint64_t all = n, at = 0;
    bool opens = r->self == 0;
    int slot = -1;
    ranks_sum(r, &all, 1);
    uint64_t before = ranks_sum_before(r, n) * sizeof(duet_pair64);
    bool ok = ranks_agree(r, !opens || open_file(&o, path, all, &at, &part, err), err);
    char *name = ok ? ranks_broadcast_text(r, opens ? text_chars(&part) : NULL, err) : NULL;
    ok = name;
    if (ok) {
        ranks_broadcast(r, &at, sizeof at);
        slot = opens ? -1 : output_watch_part(name);
        ok = ranks_agree(r, write_values(name, at + before, pairs, n, path, err), err);
    }
    bool closed = !opens || output_close(&o, ok, ok ? err : NULL);
    ok = ok && ranks_agree(r, closed, err);
    output_forget_part(slot);
    free(name);
    text_free(&part);
    return ok;
}

bool duet_cluster_save_pairs(duet_cluster *c, const char *path, bool sorted, duet_error *err)
{
    PUBLIC_CALL(err);
    if (!error_given(c, __func__, "cluster", err))
        return false;
    duet_error own = {0};
    parcels in_order = {0};
    bool ok = error_given(path, __func__, "path", &own) && cluster_list_pairs(c, &own);
    ok = ranks_agree_on(&c->ranks, __func__, ok, NULL, &own);
    ok = ok && (!sorted || sort_pairs(c, &in_order, &own));
    if (ok)
        ok = sorted ? write_pairs(c, path, in_order.rows, in_order.n, &own)
                    : write_pairs(c, path, c->own.pairs, c->own.n, &own);
    parcels_end(&in_order);
    return ok || error_copy(err, &own);
}
