/* For x86-64 processors with AVX-512. */

#include "arrays.h"

#if CHOICE
#pragma GCC target("avx512f")
#define LANES 8
#define NAMED(name) tendon_avx512_##name
#include "entry.h"
#endif
