/* What can be called, for one kind of processor: whoever includes this says how many LANES it has, and its name. */

#include "extremes.h"
#include "rows.h"
#include "window.h"

void NAMED(tendon_extremes)(void *what) { extremes(what); }
void NAMED(tendon_rows)(void *what) { rows(what); }
void NAMED(tendon_window)(void *what) { window(what); }
