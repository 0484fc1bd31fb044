/* For any processor: 16 bytes at a time, which all 64-bit ones take. */

#define LANES 2
#define EXPORTED(name) tendon_plain_##name
#include "entry.h"
