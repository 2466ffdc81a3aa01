// SPDX-License-Identifier: MIT
// All ranks write their pairs into one file at once. Rank 0 opens it under a temporary name and
// puts it in its place; where any rank fails or is ended, it is removed.
#include "base/error.h"
#include "base/npy.h"
#include "base/output.h"
#include "cluster/cluster.h"

#include <inttypes.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>

// ---------------------------------------------------------------- order

static int ascending(const void *left, const void *right)
{
    const duet_pair64 *p = left, *q = right;
    if (p->a != q->a)
        return p->a < q->a ? -1 : 1;
    return (p->b > q->b) - (p->b < q->b);
}

// Ids are dealt out in equal runs, whatever ids there are.
static int rank_of_id(uint64_t id, uint64_t most, int n_ranks)
{
    uint64_t run = most / (uint64_t)n_ranks + 1;
    return (int)(id / run);
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
    uint64_t *places = calloc((size_t)r->n, sizeof *places);
    parcels out = {0};
    bool ok = places || error_set(err, DUET_STATUS_NO_MEMORY, "%d ranks: no memory", r->n);
    ok = parcels_begin(&out, r, sizeof(duet_pair64), err) && ok;
    for (uint64_t i = 0; ok && i < c->own.n; ++i)
        ++out.counts[rank_of_id(c->own.pairs[i].a, most, r->n)];
    ok = ok && parcels_reserve(&out, r, places, err);
    duet_pair64 *rows = out.rows;
    for (uint64_t i = 0; ok && i < c->own.n; ++i)
        rows[places[rank_of_id(c->own.pairs[i].a, most, r->n)]++] = c->own.pairs[i];
    ok = ranks_exchange(r, ok, &out, sorted, err);
    if (ok)
        qsort(sorted->rows, sorted->n, sizeof(duet_pair64), ascending);
    parcels_end(&out);
    free(places);
    return ok;
}

// ---------------------------------------------------------------- the file

// What rank 0 tells the others: where the values begin, and the path's length.
typedef struct told_file {
    uint64_t values_at;
    uint64_t path_bytes;
} told_file;

static bool open_file(output *o, const char *path, uint64_t pairs, told_file *told, text *part,
                      duet_error *err)
{
    text header = {0};
    npy_add_header(&header, NPY_UINT64, pairs, 2);
    bool ok = text_ok(&header, err) && output_open(o, path, err) && output_part_path(o, part, err);
    if (ok && (fwrite(header.chars, 1, header.length, o->stream) != header.length ||
               fflush(o->stream) != 0))
        ok = error_set(err, DUET_STATUS_IO_FAILED, "%s: cannot be written", path);
    *told = (told_file){header.length, part->length + 1};
    text_free(&header);
    return ok;
}

static bool check(int code, const char *path, duet_error *err)
{
    char why[MPI_MAX_ERROR_STRING] = "";
    int length = 0;
    if (code == MPI_SUCCESS)
        return true;
    MPI_Error_string(code, why, &length);
    return error_set(err, DUET_STATUS_IO_FAILED, "%s: cannot be written: %s", path, why);
}

// Every call here is made by all ranks, whatever came of the one before.
static bool write_values(duet_cluster *c, const char *part, uint64_t at, const void *pairs,
                         uint64_t n, const char *path, duet_error *err)
{
    MPI_File file;
    MPI_Datatype row;
    int code = MPI_File_open(c->ranks.comm, part, MPI_MODE_WRONLY, MPI_INFO_NULL, &file);
    if (!ranks_agree(&c->ranks, check(code, path, err), err))
        return false;
    MPI_Type_contiguous((int)sizeof(duet_pair64), MPI_BYTE, &row);
    MPI_Type_commit(&row);
    code = MPI_File_write_at_all(file, (MPI_Offset)at, pairs, (int)n, row, MPI_STATUS_IGNORE);
    bool ok = check(code, path, err);
    ok = check(MPI_File_close(&file), path, err) && ok;
    MPI_Type_free(&row);
    return ranks_agree(&c->ranks, ok, err);
}

static bool write_pairs(duet_cluster *c, const char *path, const void *pairs, uint64_t n,
                        duet_error *err)
{
    ranks *r = &c->ranks;
    output o = {.folder = -1, .slot = -1};
    told_file told = {0};
    text part = {0};
    uint64_t all = n;
    bool opens = r->self == 0;
    ranks_sum(r, &all, 1);
    uint64_t before = ranks_sum_before(r, n);
    bool ok =
        n <= INT_MAX || error_set(err, DUET_STATUS_TOO_MANY,
                                  "%" PRIu64 " pairs on one rank; %d are the most: more ranks "
                                  "have fewer each",
                                  n, INT_MAX);
    ok = ok && (!opens || open_file(&o, path, all, &told, &part, err));
    ok = ranks_agree(r, ok, err);
    char *name = NULL;
    int slot = -1;
    if (ok) {
        ranks_tell(r, &told, sizeof told);
        name = calloc(told.path_bytes, 1);
        ok =
            ranks_agree(r, name || error_set(err, DUET_STATUS_NO_MEMORY, "a path: no memory"), err);
    }
    if (ok) {
        if (opens)
            memcpy(name, text_chars(&part), told.path_bytes);
        ranks_tell(r, name, told.path_bytes);
        slot = opens ? -1 : output_watch_part(name);
        ok = write_values(c, name, told.values_at + before * sizeof(duet_pair64), pairs, n, path,
                          err);
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
    if (!error_given(c, __func__, "cluster", err))
        return false;
    duet_error own = {0};
    parcels in_order = {0};
    bool ok = ranks_agree(&c->ranks, error_given(path, __func__, "path", &own), &own);
    ok = ok && (!sorted || sort_pairs(c, &in_order, &own));
    if (ok)
        ok = sorted ? write_pairs(c, path, in_order.rows, in_order.n, &own)
                    : write_pairs(c, path, c->own.pairs, c->own.n, &own);
    parcels_end(&in_order);
    return ok || error_set(err, own.status, "%s", own.text);
}
