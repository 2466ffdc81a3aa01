// SPDX-License-Identifier: MIT
// What the AVX2 programs share: eight records to eight lanes and back, and the
// lanes of a mask moved to the front.
#ifndef BENCH_LANES_AVX2_H
#define BENCH_LANES_AVX2_H

#include <immintrin.h>
#include <stdint.h>

// v[i] lane j becomes v[j] lane i.
static inline void lanes_transpose(__m256 v[8])
{
    __m256 t[8], u[8];
    for (int i = 0; i < 8; i += 2) {
        t[i] = _mm256_unpacklo_ps(v[i], v[i + 1]);
        t[i + 1] = _mm256_unpackhi_ps(v[i], v[i + 1]);
    }
    for (int i = 0; i < 8; i += 4) {
        u[i] = _mm256_shuffle_ps(t[i], t[i + 2], 0x44);
        u[i + 1] = _mm256_shuffle_ps(t[i], t[i + 2], 0xee);
        u[i + 2] = _mm256_shuffle_ps(t[i + 1], t[i + 3], 0x44);
        u[i + 3] = _mm256_shuffle_ps(t[i + 1], t[i + 3], 0xee);
    }
    for (int i = 0; i < 4; ++i) {
        v[i] = _mm256_permute2f128_ps(u[i], u[i + 4], 0x20);
        v[i + 4] = _mm256_permute2f128_ps(u[i], u[i + 4], 0x31);
    }
}

// Has for each mask of eight lanes the numbers of the set ones, least first.
extern uint64_t lanes_front[256];
void lanes_prepare(void);

static inline __m256i lanes_pack(__m256i v, unsigned mask)
{
    __m256i order = _mm256_cvtepu8_epi32(_mm_cvtsi64_si128((int64_t)lanes_front[mask]));
    return _mm256_permutevar8x32_epi32(v, order);
}

#endif
