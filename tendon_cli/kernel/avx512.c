/* For x86-64 processors with AVX-512. */

#include "arrays.h"

#if SEVERAL_PROCESSORS
#pragma GCC target("avx512f")
#define LANES 8
#define EXPORTED(name) tendon_avx512_##name
#include "entry.h"
#endif
