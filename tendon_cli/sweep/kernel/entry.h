/* What can be called, for one kind of processor: whoever includes this says how many LANES it has, and its name. */

#include "look.h"
#include "rows.h"

int NAMED(tendon_look)(const Tile *tile, const Seen *seen) { return look(tile, seen); }

void NAMED(tendon_rows)(const Block *block, const Table *table, long first, long count, char *nulls) {
    rows(block, table, first, count, nulls);
}
