/* Batches of designs, one design a lane: their inputs and results, and the loop over all. */

#ifndef TENDON_BATCH_H
#define TENDON_BATCH_H

#include "state.h"

/* Designs that are computed together, in one direction. */
typedef struct {
    char *value[LIMITED_COUNT + EXTREME_COUNT][LANES]; /* of each input, then of each result */
    int is_shared[LIMITED_COUNT]; /* true if all lanes have the same value of an input */
    int shares_angles;            /* true if that holds for all inputs before IN_gravity_moment */
    int is_plain;                 /* true if the drives of all designs are plain */
    long angle_step[INPUT_COUNT]; /* of an input from an angle to the next, bytes */
    int is_contiguous;            /* true if the results of neighbouring lanes are adjacent */
    long count; /* of designs; the remaining lanes repeat the first one, without results */
} Batch;

/* Indices of some inputs and results, ascending. */
typedef struct {
    int count;
    int index[LIMITED_COUNT + EXTREME_COUNT];
} Indices;

/* Inputs and results that change between designs, inputs that change between directions, and all
 * that change between either. Everything else is loaded once. */
typedef struct {
    Indices by_design;
    Indices by_direction;
    Indices either;
} Changing;

/* Add an index. */
static void append(Indices *indices, int index) {
    indices->index[indices->count] = index;
    indices->count++;
}

/* Set up a batch at the first design and find out which arrays change. */
static Changing begin_batches(Batch *b, const Walk *walk, const Array *arrays, int inputs,
                              int results) {
    Changing changing;
    long angle = walk->axes - 1;
    long direction = walk->axes - 2;
    changing.by_design.count = 0;
    changing.by_direction.count = 0;
    changing.either.count = 0;
    for (int i = 0; i < inputs + results; i++) {
        int by_design = 0;
        for (long axis = 0; axis < direction; axis++) {
            by_design |= arrays[i].step[axis] && walk->length[axis] > 1;
        }
        int by_direction = i < inputs && arrays[i].step[direction];
        if (by_design) {
            append(&changing.by_design, i);
        }
        if (by_direction) {
            append(&changing.by_direction, i);
        }
        if (by_design || by_direction) {
            append(&changing.either, i);
        }
        for (int lane = 0; lane < LANES; lane++) {
            b->value[i][lane] = arrays[i].value;
        }
        if (i < inputs) {
            b->is_shared[i] = 1;
        }
        if (i < INPUT_COUNT) {
            b->angle_step[i] = arrays[i].step[angle];
        }
    }
    return changing;
}

/* Find out what the lanes of a batch have in common. */
static void compare_lanes(Batch *b, const Indices *by_design, int inputs) {
    b->shares_angles = 1;
    b->is_contiguous = by_design->count && by_design->index[by_design->count - 1] >= inputs;
    for (int k = 0; k < by_design->count; k++) {
        int i = by_design->index[k];
        int is_shared = 1;
        int is_contiguous = 1;
        for (int lane = 1; lane < LANES; lane++) {
            is_shared &= b->value[i][lane] == b->value[i][0];
            is_contiguous &= b->value[i][lane] == b->value[i][0] + 8 * lane;
        }
        if (i >= inputs) {
            b->is_contiguous &= is_contiguous;
        } else {
            b->is_shared[i] = is_shared;
        }
        if (i < IN_gravity_moment) {
            b->shares_angles &= is_shared;
        }
    }
}

/* Fill a batch with the designs at the current place of a walk, and move on. The walk leaves out
 * direction and angle. Returns zero if these are the last designs. */
static int next_batch(Batch *b, Walk *walk, Array *arrays, const Changing *changing, int inputs) {
    int has_more = 1;
    b->count = 0;
    const Indices *by_design = &changing->by_design;
    const Indices *either = &changing->either;
    for (int lane = 0; lane < LANES; lane++) {
        for (int k = 0; k < either->count; k++) {
            int i = either->index[k];
            b->value[i][lane] = arrays[i].value;
        }
        if (has_more) {
            b->count++;
            has_more = next_line(walk, arrays, by_design->index, by_design->count);
        }
    }
    compare_lanes(b, by_design, inputs);
    return has_more;
}

/* Go from one direction to the next. */
static void next_direction(Batch *b, const Walk *walk, const Array *arrays,
                           const Indices *by_direction) {
    for (int k = 0; k < by_direction->count; k++) {
        int i = by_direction->index[k];
        for (int lane = 0; lane < LANES; lane++) {
            b->value[i][lane] += arrays[i].step[walk->axes - 2];
        }
    }
}

/* Load an input of each design, `offset` bytes from its first value. */
INLINE Lanes load_input(const Batch *b, int input, long offset) {
    Lanes values = all_lanes(*(const double *)(b->value[input][0] + offset));
    if (!b->is_shared[input]) {
        for (int lane = 1; lane < LANES; lane++) {
            values[lane] = *(const double *)(b->value[input][lane] + offset);
        }
    }
    return values;
}

/* Load the inputs at an angle that depend on it in any joint. */
INLINE void load_angle(const Batch *b, Lanes *in, long angle) {
    if (b->shares_angles) {
        for (int i = IN_pulling_arm; i < IN_gravity_moment; i++) {
            in[i] = all_lanes(*(const double *)(b->value[i][0] + angle * b->angle_step[i]));
        }
    } else {
        for (int i = IN_pulling_arm; i < IN_gravity_moment; i++) {
            in[i] = load_input(b, i, angle * b->angle_step[i]);
        }
    }
}

/* Load all inputs at an angle and return the drives there. */
INLINE Drive load_drive(const Batch *b, Lanes *in, long angle) {
    for (int i = 0; i < INPUT_COUNT; i++) {
        in[i] = load_input(b, i, angle * b->angle_step[i]);
    }
    return drive_at(in);
}

/* Fold the states of a batch in one direction; `in` are its inputs and `d` its drives at the first
 * angle. */
typedef void BatchFold(void *context, const Batch *b, const Lanes *in, const Drive *d,
                       long direction);

/* Call a fold for all designs in each direction. `fold` is a constant, so that it is compiled into
 * the loop. */
INLINE void for_each_batch(Walk *walk, Array *arrays, int inputs, int results, BatchFold *fold,
                           void *context) {
    Batch b;
    Lanes in[LIMITED_COUNT];
    int has_more;
    int is_constant = 1;
    long directions = walk->length[walk->axes - 2];
    walk->length[walk->axes - 2] = 1;
    Changing changing = begin_batches(&b, walk, arrays, inputs, results);
    for (int i = IN_gravity_moment; i < INPUT_COUNT; i++) {
        is_constant &= !b.angle_step[i];
    }
    for (int i = 0; i < inputs; i++) {
        in[i] = load_input(&b, i, 0);
    }
    do {
        has_more = next_batch(&b, walk, arrays, &changing, inputs);
        for (long direction = 0; direction < directions; direction++) {
            const Indices *changed = direction ? &changing.by_direction : &changing.either;
            for (int k = 0; k < changed->count && changed->index[k] < inputs; k++) {
                in[changed->index[k]] = load_input(&b, changed->index[k], 0);
            }
            Drive d = drive_at(in);
            b.is_plain = is_constant && has_plain_terms(&d);
            fold(context, &b, in, &d, direction);
            next_direction(&b, walk, arrays, &changing.by_direction);
        }
    } while (has_more);
    walk->length[walk->axes - 2] = directions;
}

#endif
