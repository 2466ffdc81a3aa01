// SPDX-License-Identifier: MIT
#include "runtime/queries/far_rows.h"

#include "runtime/narrowphase/origin.h"

static float *offset_of(const far_rows *far, uint64_t i)
{
    return (float *)far->rows + i * far->words;
}

static int32_t *cell_of(const far_rows *far, uint64_t i)
{
    return (int32_t *)far->rows + i * far->words + far->cell_word;
}

void far_rows_settle(const far_rows *far, float edge)
{
    for (uint64_t i = 0; i < far->n; ++i)
        origin_settle_at(offset_of(far, i), cell_of(far, i), edge);
}

void far_rows_middle(const far_rows *far, int32_t middle[3])
{
    for (int k = 0; k < 3; ++k) {
        int64_t least = INT32_MAX, most = INT32_MIN;
        for (uint64_t i = 0; i < far->n; ++i) {
            float offset = offset_of(far, i)[k];
            int32_t cell = cell_of(far, i)[k];
            least = offset == offset && cell < least ? cell : least;
            most = offset == offset && cell > most ? cell : most;
        }
        middle[k] = least <= most ? (int32_t)(least + (most - least) / 2) : 0;
    }
}

void far_rows_count_from(const far_rows *far, const int32_t middle[3])
{
    for (uint64_t i = 0; i < far->n; ++i)
        for (int k = 0; k < 3; ++k)
            cell_of(far, i)[k] -= middle[k];
}

void far_shift(double shift[3], const duet_large_pose *from, const int32_t to[3], float edge)
{
    for (int k = 0; k < 3; ++k)
        shift[k] = ((double)to[k] - from->cell[k]) * edge;
}
