/* Facts that Python asks the library for: its version, names of arrays in their order, and the
 * kinds of processors whose code runs here. */

#include "arrays.h"

#define SPACED(name) #name " "
const char *const tendon_given = GIVEN(SPACED);
const char *const tendon_results = RESULTS(SPACED);
const char *const tendon_extremes = EXTREMES(SPACED);
const char *const tendon_bounds = BOUNDS(SPACED);
const char *const tendon_form = FORM(SPACED);
const char *const tendon_window = WINDOW(SPACED);
const long tendon_version = KERNEL_VERSION;
const long tendon_most_axes = MOST_AXES;
const long tendon_most_forms = MOST_FORMS;

/* Return the kinds of code that this processor can run, the fastest last. */
const char *tendon_kinds(void) {
#if SEVERAL_PROCESSORS
    if (__builtin_cpu_supports("avx512f")) {
        return "plain avx2 avx512";
    }
    if (__builtin_cpu_supports("avx2")) {
        return "plain avx2";
    }
#endif
    return "plain";
}
