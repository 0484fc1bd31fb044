/* What is called from Python: the code for the processor that it runs on. */

#include "processors.h"

const int tendon_native_version = 3; /* of the calls, and of what they come to */

#define DECLARE(kind)                                              \
    int tendon_look_##kind(const void *tile, const void *seen);    \
    void tendon_rows_##kind(const void *block, const void *table, long first, long count, char *nulls);

DECLARE(plain)
#if CHOICE
DECLARE(avx2)
DECLARE(avx512)
#define FOR_THIS_PROCESSOR(call)                                   \
    (__builtin_cpu_supports("avx512f") ? call##_avx512 : __builtin_cpu_supports("avx2") ? call##_avx2 : call##_plain)
#else
#define FOR_THIS_PROCESSOR(call) call##_plain
#endif

/* The tile, and where to put what is seen: `Tile` and `Seen` in look.h. Returns nought, or one without memory. */
int tendon_look(const void *tile, const void *seen) { return FOR_THIS_PROCESSOR(tendon_look)(tile, seen); }

/* Some rows of a block, where to put them, and which results have nulls: `Block` and `Table` in rows.h. */
void tendon_rows(const void *block, const void *table, long first, long count, char *nulls) {
    FOR_THIS_PROCESSOR(tendon_rows)(block, table, first, count, nulls);
}
