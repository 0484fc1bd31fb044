/* Numbers side by side, as many as the processor takes at a time: LANES of them, which whoever includes this defines.
 *
 * Written for GCC and Clang, whose vectors take operators. To be compiled without contraction of multiply-adds and
 * without fast math, so that the bits are NumPy's.
 */

#ifndef TENDON_LANES_H
#define TENDON_LANES_H

#include <float.h>
#include <math.h>
#include <string.h>

#if defined(__FAST_MATH__) || FLT_EVAL_METHOD != 0
#error "other bits than NumPy's, to which this is left if it does not compile"
#endif

#if defined(__AVX2__)
#include <immintrin.h>
#endif

typedef double Lanes __attribute__((vector_size(8 * LANES)));
typedef long long Mask __attribute__((vector_size(8 * LANES)));

typedef signed char Small __attribute__((vector_size(LANES)));

#define INLINE static inline __attribute__((always_inline))

INLINE Lanes same(double x) { return x - (Lanes){0}; }
INLINE Lanes pick(Mask which, Lanes a, Lanes b) { return (Lanes)((which & (Mask)a) | (~which & (Mask)b)); }
INLINE Lanes magnitude(Lanes a) { return (Lanes)((Mask)a & 0x7fffffffffffffffLL); }
INLINE Mask is_number(Lanes a) { return a == a; }

/* Of two numbers; where one is not a number, the first of `larger` and `smaller` gives way. */
#if LANES == 8 && defined(__AVX512F__)
INLINE Lanes larger(Lanes a, Lanes b) { return _mm512_max_pd(a, b); }
INLINE Lanes smaller(Lanes a, Lanes b) { return _mm512_min_pd(a, b); }
#elif LANES == 4 && defined(__AVX2__)
INLINE Lanes larger(Lanes a, Lanes b) { return _mm256_max_pd(a, b); }
INLINE Lanes smaller(Lanes a, Lanes b) { return _mm256_min_pd(a, b); }
#else
INLINE Lanes larger(Lanes a, Lanes b) { return pick(a > b, a, b); }
INLINE Lanes smaller(Lanes a, Lanes b) { return pick(a < b, a, b); }
#endif

/* Whether a mask has any lane. */
#if LANES == 8 && defined(__AVX512F__)
INLINE int any(Mask which) { return _mm512_test_epi64_mask((__m512i)which, (__m512i)which) != 0; }
#elif LANES == 4 && defined(__AVX2__)
INLINE int any(Mask which) { return _mm256_movemask_pd((__m256d)which) != 0; }
#else
INLINE int any(Mask which) {
    long long found = 0;
    for (int lane = 0; lane < LANES; lane++) found |= which[lane];
    return found != 0;
}
#endif

/* A number that is at least `low`; what is not a number stays so. */
INLINE Lanes at_least(Lanes low, Lanes a) { return larger(low, a); }

INLINE void put(double *to, Lanes from, long count) {
    if (count >= LANES) memcpy(to, &from, sizeof from);
    else memcpy(to, &from, 8 * (unsigned long)count);
}

INLINE void put_small(signed char *to, Mask from, long count) {
    Small small = __builtin_convertvector(from, Small);
    if (count >= LANES) memcpy(to, &small, sizeof small);
    else memcpy(to, &small, (unsigned long)count);
}

#endif
