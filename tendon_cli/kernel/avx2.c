/* For x86-64 processors with AVX2. */

#include "arrays.h"

#if SEVERAL_PROCESSORS
#pragma GCC target("avx2")
#define LANES 4
#define EXPORTED(name) tendon_avx2_##name
#include "entry.h"
#endif
