/* What Python finds in the library besides the code in `entry.h`: names, in order, and which code this processor runs. */

#include "arrays.h"

#define SPACED(name) #name " "
const char *const tendon_given = GIVEN(SPACED), *const tendon_results = RESULTS(SPACED);
const char *const tendon_extremes = EXTREMES(SPACED), *const tendon_bounds = BOUNDS(SPACED);
const char *const tendon_form = FORM(SPACED), *const tendon_window = WINDOW(SPACED);
const long tendon_version = KERNEL_VERSION, tendon_most_axes = MOST_AXES, tendon_most_forms = MOST_FORMS;

/* The kinds of code that this processor can run, the fastest last. */
const char *tendon_kinds(void) {
#if CHOICE
    if (__builtin_cpu_supports("avx512f")) return "plain avx2 avx512";
    if (__builtin_cpu_supports("avx2")) return "plain avx2";
#endif
    return "plain";
}
