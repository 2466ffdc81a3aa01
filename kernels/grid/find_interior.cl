// SPDX-License-Identifier: MIT
// Which objects lie deep inside a box and need no second look. All others are odd: those outside
// of it, those that are bad, and those of which float cannot tell.
//
//   objects  [n] poses or bounds; those from interior_from on, a multiple of INTERIOR_ROWS, are looked at
//   inside_lower, inside_upper   a pose's centre lies between them, or all of bounds
//   blocks   [n / INTERIOR_ROWS, rounded up]
//
// The square is that of the half diagonal of a pose, or of half the longest edge of bounds. A half
// edge is rounded once, and a sum of squares by fma thrice. What is rounded where numbers are
// denormal, or flushed to 0 there, is below 2^-126, and squares below 2^-100 that are not of points
// are odd. So a square falls short by less than 2^-21 of itself. Squares above 2^100 are odd too.
#define SMALL_SQUARE 0x1p-100f
#define LARGE_SQUARE 0x1p100f

#if SHAPE == 0
#define ROW_PAIRS 5
#else
#define ROW_PAIRS 3
#endif

// Around those that a work-item, or a group, has seen.
typedef struct {
    float lower[3], upper[3], square;
} around;

// Also where a device takes denormal numbers for 0.
static inline bool is_negative(float x)
{
    return as_uint(x) > 0x80000000u;
}

static inline bool is_zero(float x)
{
    return as_uint(x) << 1 == 0;
}

// Infinite numbers and NaNs do not become 0.
static inline float nought(float x, float sum)
{
    return fma(x, 0.0f, sum);
}

static inline bool fits(float square, bool is_point)
{
    return square < LARGE_SQUARE && (is_point || square > SMALL_SQUARE);
}

// The box around a deep object's point, or around all of it, and its square.
static inline bool is_deep(const float2 row[ROW_PAIRS], const float inside_lower[3],
                           const float inside_upper[3], around *of)
{
#if SHAPE == 0
    float at[3] = {row[0].x, row[0].y, row[1].x};
    float half_x = row[1].y, half_y = row[2].x, half_z = row[2].y;
    float zero = 0.0f;
    for (int k = 0; k < ROW_PAIRS; ++k)
        zero = nought(row[k].x, nought(row[k].y, zero));
    bool deep = zero == 0.0f && !(is_zero(row[4].x) && is_zero(row[4].y));
    deep &= !(is_negative(half_x) || is_negative(half_y) || is_negative(half_z));
    bool is_point = is_zero(half_x) && is_zero(half_y);
    of->square = fma(half_x, half_x, half_y * half_y);
#if DIMS == 3
    is_point &= is_zero(half_z);
    of->square = fma(half_z, half_z, of->square);
#endif
    for (int k = 0; k < 3; ++k)
        of->lower[k] = of->upper[k] = k < DIMS ? at[k] : 0.0f;
#else
    const float corners[6] = {row[0].x, row[0].y, row[1].x, row[1].y, row[2].x, row[2].y};
    bool deep = true, is_point = true;
    of->square = 0.0f;
    for (int k = 0; k < 3; ++k) {
        float lower = k < DIMS ? corners[k] : 0.0f, upper = k < DIMS ? corners[3 + k] : 0.0f;
        float half_edge = 0.5f * upper - 0.5f * lower;
        deep &= nought(lower, nought(upper, 0.0f)) == 0.0f && lower <= upper;
        is_point &= as_uint(lower) == as_uint(upper);
        of->square = fmax(of->square, half_edge * half_edge);
        of->lower[k] = lower;
        of->upper[k] = upper;
    }
#endif
    for (int k = 0; k < DIMS; ++k)
        deep &= of->lower[k] > inside_lower[k] && of->upper[k] < inside_upper[k];
    return deep && fits(of->square, is_point);
}

static inline void add(around *to, const around *of)
{
    for (int k = 0; k < 3; ++k) {
        to->lower[k] = fmin(to->lower[k], of->lower[k]);
        to->upper[k] = fmax(to->upper[k], of->upper[k]);
    }
    to->square = fmax(to->square, of->square);
}

__kernel void find_interior(FIND_INTERIOR_ARGS)
{
    __local uint odd[INTERIOR_WORDS];
    __local uint n_odd;
    __local around seen[WG];
    const uint me = get_local_id(0);
    const uint first = interior_from + get_group_id(0) * INTERIOR_ROWS;
    const float lower[3] = {inside_lower.x, inside_lower.y, inside_lower.z};
    const float upper[3] = {inside_upper.x, inside_upper.y, inside_upper.z};
    around mine = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}, 0.0f};
    for (uint w = me; w < INTERIOR_WORDS; w += WG)
        odd[w] = 0;
    if (me == 0)
        n_odd = 0;
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint at = me; at < INTERIOR_ROWS; at += WG) {
        if (first + at >= n)
            break;
        __global const float2 *object = (__global const float2 *)objects + (size_t)(first + at) * ROW_PAIRS;
        float2 row[ROW_PAIRS];
        around of;
        for (int k = 0; k < ROW_PAIRS; ++k)
            row[k] = object[k];
        if (is_deep(row, lower, upper, &of)) {
            add(&mine, &of);
        } else {
            atomic_or(odd + at / 32, 1u << (at & 31u));
            atomic_inc(&n_odd);
        }
    }
    seen[me] = mine;
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint half_way = WG / 2; half_way > 0; half_way /= 2) {
        if (me < half_way) {
            around other = seen[me + half_way];
            add(&mine, &other);
            seen[me] = mine;
        }
        barrier(CLK_LOCAL_MEM_FENCE);
    }
    __global interior_block *block = blocks + first / INTERIOR_ROWS;
    for (uint w = me; w < INTERIOR_WORDS; w += WG)
        block->odd[w] = odd[w];
    if (me == 0) {
        block->n_odd = n_odd;
        block->square = mine.square;
        for (int k = 0; k < 3; ++k) {
            block->lower[k] = mine.lower[k];
            block->upper[k] = mine.upper[k];
        }
    }
}
