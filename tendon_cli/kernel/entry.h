/* What can be called, for one kind of processor: whoever includes this says how many LANES it has, and its name. */

#include "extremes.h"
#include "rows.h"
#include "window.h"

void NAMED(tendon_extremes)(Extremes *what) { extremes(what); }
void NAMED(tendon_rows)(Rows *what) { rows(what); }
void NAMED(tendon_window)(Window *what) { window(what); }
