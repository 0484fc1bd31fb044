/* Calls from Python, for one kind of processor. The including file defines LANES and EXPORTED,
 * which gives each function the name of that kind. */

#include "extremes.h"
#include "rows.h"
#include "window.h"

/* Find the extremes of designs. */
void EXPORTED(extremes)(ExtremesCall *call) {
    find_extremes(call);
}

/* Write rows of the states table. */
void EXPORTED(rows)(RowsCall *call) {
    write_rows(call);
}

/* Find the windows of designs. */
void EXPORTED(window)(WindowCall *call) {
    find_windows(call);
}
