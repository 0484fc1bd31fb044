/* Vectors of LANES numbers, as many as the processor takes at a time; the including file defines
 * LANES.
 *
 * Written for GCC and Clang, whose vectors take operators. Compile it without contraction of
 * multiply-adds and without fast math, so that the bits are those of NumPy.
 */

#ifndef TENDON_LANES_H
#define TENDON_LANES_H

#include <float.h>
#include <math.h>
#include <string.h>

#if defined(__FAST_MATH__) || FLT_EVAL_METHOD != 0
#error "these options round otherwise than NumPy, which is used instead if this does not compile"
#endif

#if defined(__AVX2__)
#include <immintrin.h>
#endif

typedef double Lanes __attribute__((vector_size(8 * LANES)));
typedef long long Mask __attribute__((vector_size(8 * LANES)));
typedef signed char Bytes __attribute__((vector_size(LANES)));

#define INLINE static inline __attribute__((always_inline))

/* The same number in each lane. */
INLINE Lanes all_lanes(double x) {
    return x - (Lanes){0};
}

/* `a` where the mask is set, else `b`. */
INLINE Lanes pick(Mask mask, Lanes a, Lanes b) {
    return (Lanes)((mask & (Mask)a) | (~mask & (Mask)b));
}

/* Absolute value. */
INLINE Lanes magnitude(Lanes a) {
    return (Lanes)((Mask)a & 0x7fffffffffffffffLL);
}

/* Mask of lanes that are not NaN. */
INLINE Mask is_number(Lanes a) {
    return a == a;
}

/* The larger and the smaller of two numbers; the second one if either is not a number. */
#if LANES == 8 && defined(__AVX512F__)
INLINE Lanes larger(Lanes a, Lanes b) {
    return _mm512_max_pd(a, b);
}
INLINE Lanes smaller(Lanes a, Lanes b) {
    return _mm512_min_pd(a, b);
}
#elif LANES == 4 && defined(__AVX2__)
INLINE Lanes larger(Lanes a, Lanes b) {
    return _mm256_max_pd(a, b);
}
INLINE Lanes smaller(Lanes a, Lanes b) {
    return _mm256_min_pd(a, b);
}
#else
INLINE Lanes larger(Lanes a, Lanes b) {
    return pick(a > b, a, b);
}
INLINE Lanes smaller(Lanes a, Lanes b) {
    return pick(a < b, a, b);
}
#endif

/* Sum of two numbers. */
INLINE Lanes sum(Lanes a, Lanes b) {
    return a + b;
}

/* True if the mask is set in any lane. */
#if LANES == 8 && defined(__AVX512F__)
INLINE int any(Mask mask) {
    return _mm512_test_epi64_mask((__m512i)mask, (__m512i)mask) != 0;
}
#elif LANES == 4 && defined(__AVX2__)
INLINE int any(Mask mask) {
    return _mm256_movemask_pd((__m256d)mask) != 0;
}
#else
INLINE int any(Mask mask) {
    long long bits = 0;
    for (int lane = 0; lane < LANES; lane++) {
        bits |= mask[lane];
    }
    return bits != 0;
}
#endif

/* The number, or `low` if it is less; NaN stays NaN. */
INLINE Lanes at_least(Lanes low, Lanes a) {
    return larger(low, a);
}

/* Store the first `count` lanes, at most all. */
INLINE void store(double *target, Lanes values, long count) {
    if (count >= LANES) {
        memcpy(target, &values, sizeof values);
    } else {
        memcpy(target, &values, 8 * (unsigned long)count);
    }
}

/* Store the first `count` lanes, at most all, as a byte each. */
INLINE void store_bytes(signed char *target, Mask values, long count) {
    Bytes bytes = __builtin_convertvector(values, Bytes);
    if (count >= LANES) {
        memcpy(target, &bytes, sizeof bytes);
    } else {
        memcpy(target, &bytes, (unsigned long)count);
    }
}

#endif
