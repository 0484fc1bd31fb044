/* What can be called, for one kind of processor: whoever includes this says how many LANES it has, and its name. */

#include "extremes.h"
#include "rows.h"
#include "window.h"

void NAMED(extremes)(Extremes *what) { extremes(what); }
void NAMED(rows)(Rows *what) { rows(what); }
void NAMED(window)(Window *what) { window(what); }
