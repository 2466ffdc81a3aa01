// SPDX-License-Identifier: MIT
// The cells that a moving box passes over, a column of them after the other, and near their tops
// both prisms of each.
#include "runtime/narrowphase/heights.h"

#include <math.h>
#include <stdint.h>

// A box over the grid: places along both axes are counted in cells, and it reaches `wide` to both
// sides of its centre, or a little less.
typedef struct track {
    const duet_heights *heights;
    const ground_probe *probe;
    double at[2], go[2], wide[2];
    uint32_t cells[2];
    int major; // axis along which it passes more cells
    double begin, end;
} track;

typedef struct cell_span {
    uint32_t first, last;
} cell_span;

// Cuts the times to those over the grid. False: it never is.
static bool cut_to_grid(track *t, int k)
{
    double lower = -t->wide[k], upper = t->cells[k] + t->wide[k];
    if (t->go[k] == 0.0)
        return t->at[k] >= lower && t->at[k] <= upper;
    double in = (lower - t->at[k]) / t->go[k], out = (upper - t->at[k]) / t->go[k];
    t->begin = fmax(t->begin, fmin(in, out));
    t->end = fmin(t->end, fmax(in, out));
    return t->begin <= t->end;
}

// A quotient is right within 2^-50 of itself.
static bool begin_track(track *t, const duet_heights *h, const ground_probe *probe)
{
    *t = (track){.heights = h, .probe = probe, .cells = {h->nx - 1, h->ny - 1}};
    for (int k = 0; k < 2; ++k) {
        t->at[k] = (probe->centre[k] - h->origin[k]) / h->spacing[k];
        t->go[k] = probe->direction[k] / h->spacing[k];
        t->wide[k] = probe->reach[k] / h->spacing[k] + 0x1p-8 + 0x1p-48 * fabs(t->at[k]);
    }
    t->end = probe->t_max;
    t->major = fabs(t->go[1]) > fabs(t->go[0]);
    return cut_to_grid(t, 0) && cut_to_grid(t, 1);
}

static double place_at(const track *t, int k, double time)
{
    return t->go[k] == 0.0 ? t->at[k] : t->at[k] + time * t->go[k];
}

// Cells between its places at two times.
static cell_span cells_between(const track *t, int k, double from, double to)
{
    double a = place_at(t, k, from), b = place_at(t, k, to), last = t->cells[k] - 1.0;
    double lower = floor(fmin(a, b) - t->wide[k]), upper = floor(fmax(a, b) + t->wide[k]);
    return (cell_span){(uint32_t)fmin(fmax(lower, 0.0), last),
                       (uint32_t)fmin(fmax(upper, 0.0), last)};
}

static double top_of(const duet_heights *h, uint32_t i, uint32_t j)
{
    const float *low = h->heights + (size_t)j * h->nx + i, *high = low + h->nx;
    return h->origin[2] + (double)fmaxf(fmaxf(low[0], low[1]), fmaxf(high[0], high[1]));
}

// The least z that it reaches between two times; less than that by what rounding may do.
static double least_z(const track *t, double from, double to)
{
    double begin = t->probe->centre[2], go = t->probe->direction[2];
    double time = go < 0.0 ? to : from, way = go == 0.0 ? 0.0 : time * go;
    return begin + way - t->probe->reach[2] -
           0x1p-40 * (fabs(begin) + fabs(way) + fabs(t->heights->origin[2]));
}

static bool meet_cell(const track *t, uint32_t i, uint32_t j, ground_entry *best)
{
    bool met = false;
    for (int upper = 0; upper < 2; ++upper) {
        const ground_piece p = heights_piece(t->heights, i, j, upper);
        met |= ground_piece_improve(&p, t->probe, best);
    }
    return met;
}

// The times at which it is over a column, of those over the grid.
static void time_column(const track *t, uint32_t c, double *from, double *to)
{
    int k = t->major;
    *from = t->begin;
    *to = t->end;
    if (t->go[k] == 0.0)
        return;
    double in = (c - t->wide[k] - t->at[k]) / t->go[k];
    double out = (c + 1 + t->wide[k] - t->at[k]) / t->go[k];
    *from = fmax(*from, fmin(in, out));
    *to = fmin(*to, fmax(in, out));
}

static bool meet_column(const track *t, uint32_t c, double from, double to, ground_entry *best)
{
    cell_span along = cells_between(t, !t->major, from, to);
    double lowest = least_z(t, from, to);
    bool met = false;
    for (uint32_t other = along.first; other <= along.last; ++other) {
        uint32_t i = t->major == 0 ? c : other, j = t->major == 0 ? other : c;
        double top = top_of(t->heights, i, j);
        if (!(lowest - 0x1p-40 * fabs(top) > top))
            met |= meet_cell(t, i, j, best);
    }
    return met;
}

// Columns later on the way are met no sooner.
bool heights_meet(const duet_heights *h, const ground_probe *probe, ground_entry *entry)
{
    track t;
    if (!begin_track(&t, h, probe))
        return false;
    cell_span columns = cells_between(&t, t.major, t.begin, t.end);
    uint32_t n = columns.last - columns.first + 1;
    bool met = false;
    entry->t = INFINITY;
    for (uint32_t i = 0; i < n; ++i) {
        uint32_t c = t.go[t.major] < 0.0 ? columns.last - i : columns.first + i;
        double from, to;
        time_column(&t, c, &from, &to);
        if (met && (from > entry->t || entry->t == 0.0))
            break;
        if (from <= to)
            met |= meet_column(&t, c, from, to, entry);
    }
    return met;
}
