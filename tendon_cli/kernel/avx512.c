/* For x86-64 processors with AVX-512. */

#include "arrays.h"

#if CHOICE
#pragma GCC target("avx512f")
#define LANES 8
#define NAMED(name) name##_avx512
#include "entry.h"
#endif
