/* Whether there is a choice of processors when this runs: where the compiler can make code for others than its own. */

#ifndef TENDON_PROCESSORS_H
#define TENDON_PROCESSORS_H

#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__)
#define CHOICE 1
#else
#define CHOICE 0
#endif

#endif
