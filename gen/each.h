// SPDX-License-Identifier: MIT
// EACH(f, a, b, x, y, ...) is f(a, b, x), f(a, b, y), ... of up to 16 names.
#ifndef GEN_EACH_H
#define GEN_EACH_H

// clang-format off
#define EACH_1(f, a, b, x) f(a, b, x)
#define EACH_2(f, a, b, x, ...) f(a, b, x), EACH_1(f, a, b, __VA_ARGS__)
#define EACH_3(f, a, b, x, ...) f(a, b, x), EACH_2(f, a, b, __VA_ARGS__)
#define EACH_4(f, a, b, x, ...) f(a, b, x), EACH_3(f, a, b, __VA_ARGS__)
#define EACH_5(f, a, b, x, ...) f(a, b, x), EACH_4(f, a, b, __VA_ARGS__)
#define EACH_6(f, a, b, x, ...) f(a, b, x), EACH_5(f, a, b, __VA_ARGS__)
#define EACH_7(f, a, b, x, ...) f(a, b, x), EACH_6(f, a, b, __VA_ARGS__)
#define EACH_8(f, a, b, x, ...) f(a, b, x), EACH_7(f, a, b, __VA_ARGS__)
#define EACH_9(f, a, b, x, ...) f(a, b, x), EACH_8(f, a, b, __VA_ARGS__)
#define EACH_10(f, a, b, x, ...) f(a, b, x), EACH_9(f, a, b, __VA_ARGS__)
#define EACH_11(f, a, b, x, ...) f(a, b, x), EACH_10(f, a, b, __VA_ARGS__)
#define EACH_12(f, a, b, x, ...) f(a, b, x), EACH_11(f, a, b, __VA_ARGS__)
#define EACH_13(f, a, b, x, ...) f(a, b, x), EACH_12(f, a, b, __VA_ARGS__)
#define EACH_14(f, a, b, x, ...) f(a, b, x), EACH_13(f, a, b, __VA_ARGS__)
#define EACH_15(f, a, b, x, ...) f(a, b, x), EACH_14(f, a, b, __VA_ARGS__)
#define EACH_16(f, a, b, x, ...) f(a, b, x), EACH_15(f, a, b, __VA_ARGS__)
#define EACH_PICK(x1, x2, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12, x13, x14, x15, x16, each, ...) each
#define EACH(f, a, b, ...) EACH_PICK(__VA_ARGS__, EACH_16, EACH_15, EACH_14, EACH_13, EACH_12, EACH_11, \
    EACH_10, EACH_9, EACH_8, EACH_7, EACH_6, EACH_5, EACH_4, EACH_3, EACH_2, EACH_1, )(f, a, b, __VA_ARGS__)
// clang-format on

#endif
