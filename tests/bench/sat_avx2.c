// SPDX-License-Identifier: MIT
// Every axis of every pair is worked out and nothing branches: eight unlike
// pairs are seldom all separated by the same early axis.
//
// Verdicts are certified as docs/accuracy.md says: an axis separates only
// where its separation exceeds the error bound, a pair collides only where every separation
// is below minus the bound, and what lies between is left open.
#include "sat_avx2.h"

#include "lanes_avx2.h"
#include "runtime/narrowphase/narrow.h"

#include <math.h>

#define AHEAD 32 // pairs whose second box is asked for while the present ones are tested
#define ERROR_BOUND (32 * 0x1p-24f) // error of a separation, relative to the sizes that enter it

// Eight boxes, one a lane.
typedef struct boxes8 {
    __m256 centre[3];
    __m256 half[3];
    __m256 axes[3][3];
    __m256i id;
} boxes8;

static void load_boxes(const sat_box *boxes, const uint32_t at[8], boxes8 *b)
{
    __m256 low[8], high[8];
    for (int i = 0; i < 8; ++i) {
        const float *box = (const float *)&boxes[at[i]];
        low[i] = _mm256_load_ps(box);
        high[i] = _mm256_load_ps(box + 8);
    }
    lanes_transpose(low);
    lanes_transpose(high);
    for (int i = 0; i < 3; ++i) {
        b->centre[i] = low[i];
        b->half[i] = low[3 + i];
        b->axes[2][i] = high[4 + i];
    }
    b->axes[0][0] = low[6];
    b->axes[0][1] = low[7];
    b->axes[0][2] = high[0];
    for (int i = 0; i < 3; ++i)
        b->axes[1][i] = high[1 + i];
    b->id = _mm256_castps_si256(high[7]);
}

static inline __m256 absolute(__m256 v)
{
    return _mm256_andnot_ps(_mm256_set1_ps(-0.0f), v);
}

static inline __m256 dot(const __m256 u[3], const __m256 v[3])
{
    return _mm256_fmadd_ps(u[2], v[2], _mm256_fmadd_ps(u[1], v[1], _mm256_mul_ps(u[0], v[0])));
}

// The widest separation between a and b over the 15 axes, times each axis' length.
static inline __m256 widest_separation(const boxes8 *a, const boxes8 *b, const __m256 way[3])
{
    __m256 along[3]; // way in a's frame
    __m256 r[3][3];  // b's axes in a's frame
    __m256 s[3][3];  // their absolute values
    for (int i = 0; i < 3; ++i) {
        along[i] = dot(way, a->axes[i]);
        for (int j = 0; j < 3; ++j) {
            r[i][j] = dot(a->axes[i], b->axes[j]);
            s[i][j] = absolute(r[i][j]);
        }
    }
    __m256 widest = _mm256_set1_ps(-INFINITY);
    for (int i = 0; i < 3; ++i) {
        __m256 reach = _mm256_add_ps(a->half[i], dot(b->half, s[i]));
        widest = _mm256_max_ps(widest, _mm256_sub_ps(absolute(along[i]), reach));
    }
    for (int j = 0; j < 3; ++j) {
        __m256 rj[3] = {r[0][j], r[1][j], r[2][j]};
        __m256 sj[3] = {s[0][j], s[1][j], s[2][j]};
        __m256 reach = _mm256_add_ps(b->half[j], dot(a->half, sj));
        widest = _mm256_max_ps(widest, _mm256_sub_ps(absolute(dot(along, rj)), reach));
    }
    for (int i = 0; i < 3; ++i) {
        int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
        for (int j = 0; j < 3; ++j) {
            int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
            __m256 span = _mm256_fmsub_ps(along[i2], r[i1][j], _mm256_mul_ps(along[i1], r[i2][j]));
            __m256 reach = _mm256_mul_ps(a->half[i1], s[i2][j]);
            reach = _mm256_fmadd_ps(a->half[i2], s[i1][j], reach);
            reach = _mm256_fmadd_ps(b->half[j1], s[i][j2], reach);
            reach = _mm256_fmadd_ps(b->half[j2], s[i][j1], reach);
            widest = _mm256_max_ps(widest, _mm256_sub_ps(absolute(span), reach));
        }
    }
    return widest;
}

static inline __m256 sum3(const __m256 v[3])
{
    return _mm256_add_ps(v[0], _mm256_add_ps(v[1], v[2]));
}

static void store_pairs(__m256i a, __m256i b, unsigned mask, duet_pair *to)
{
    a = lanes_pack(a, mask);
    b = lanes_pack(b, mask);
    __m256i even = _mm256_unpacklo_epi32(a, b); // pairs 0 1 4 5
    __m256i odd = _mm256_unpackhi_epi32(a, b);  // pairs 2 3 6 7
    _mm256_storeu_si256((__m256i *)to, _mm256_permute2x128_si256(even, odd, 0x20));
    _mm256_storeu_si256((__m256i *)(to + 4), _mm256_permute2x128_si256(even, odd, 0x31));
}

// Float's open questions are so few that each may cost what it likes.
static void decide_open(const sat_box *boxes, const duet_pose *poses, uint32_t first,
                        uint32_t second, sat_result *result)
{
    uint32_t a = boxes[first].id, b = boxes[second].id;
    if (narrow_decide(&poses[a], &poses[b], 3))
        result->pairs[result->n_pairs++] = (duet_pair){a < b ? a : b, a < b ? b : a};
}

static inline void test_eight(const sat_box *boxes, const duet_pose *poses, const uint32_t *first,
                              const uint32_t *second, unsigned wanted, sat_result *result)
{
    boxes8 a, b;
    load_boxes(boxes, first, &a);
    load_boxes(boxes, second, &b);
    __m256 way[3], length[3];
    for (int i = 0; i < 3; ++i) {
        way[i] = _mm256_sub_ps(b.centre[i], a.centre[i]);
        length[i] = absolute(way[i]);
    }
    __m256 sizes = _mm256_add_ps(sum3(length), _mm256_add_ps(sum3(a.half), sum3(b.half)));
    __m256 bound = _mm256_mul_ps(sizes, _mm256_set1_ps(ERROR_BOUND));
    __m256 separation = widest_separation(&a, &b, way);
    __m256 colliding =
        _mm256_cmp_ps(_mm256_add_ps(separation, bound), _mm256_setzero_ps(), _CMP_LT_OQ);
    __m256 apart = _mm256_cmp_ps(separation, bound, _CMP_GT_OQ);
    unsigned hit = wanted & (unsigned)_mm256_movemask_ps(colliding);
    unsigned open = wanted & ~hit & ~(unsigned)_mm256_movemask_ps(apart);
    store_pairs(_mm256_min_epu32(a.id, b.id), _mm256_max_epu32(a.id, b.id), hit,
                result->pairs + result->n_pairs);
    result->n_pairs += (unsigned)__builtin_popcount(hit);
    for (; open; open &= open - 1) {
        int lane = __builtin_ctz(open);
        decide_open(boxes, poses, first[lane], second[lane], result);
    }
}

void sat_avx2(const sat_box *boxes, const duet_pose *poses, const uint32_t *first,
              const uint32_t *second, uint32_t n, sat_result *result)
{
    for (uint32_t i = 0; i < n; i += 8) {
        for (int j = 0; j < 8; ++j)
            _mm_prefetch((const char *)&boxes[second[i + AHEAD + j]], _MM_HINT_T0);
        unsigned wanted = n - i < 8 ? (1u << (n - i)) - 1 : 0xff;
        test_eight(boxes, poses, first + i, second + i, wanted, result);
    }
}
