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
    long count; /* of designs; the remaining lanes repeat the last one, without results */
} Batch;

/* Indices of some inputs and results, ascending. */
typedef struct {
    int count;
    int index[LIMITED_COUNT + EXTREME_COUNT];
} Indices;

/* Inputs and results that change between designs or directions; everything else is loaded once. */
typedef struct {
    Indices by_direction; /* inputs that change between directions */
    Indices either;
    char *value[LIMITED_COUNT + EXTREME_COUNT]; /* of each at the next design */
    long move[LIMITED_COUNT + EXTREME_COUNT][MOST_AXES]; /* of each along an axis, bytes */
} Changing;

/* Add an index. */
static void append(Indices *indices, int index) {
    indices->index[indices->count] = index;
    indices->count++;
}

/* Set up a batch at the first design and find out which arrays change. */
static void begin_batches(Batch *b, Changing *changing, const Walk *walk, const Array *arrays,
                          int inputs, int results) {
    long angle = walk->axes - 1;
    long direction = walk->axes - 2;
    changing->by_direction.count = 0;
    changing->either.count = 0;
    for (int i = 0; i < inputs + results; i++) {
        int by_design = 0;
        for (long axis = 0; axis < direction; axis++) {
            by_design |= arrays[i].step[axis] && walk->length[axis] > 1;
            changing->move[i][axis] = move_along(&arrays[i], walk, axis);
        }
        int by_direction = i < inputs && arrays[i].step[direction];
        if (by_direction) {
            append(&changing->by_direction, i);
        }
        if (by_design || by_direction) {
            append(&changing->either, i);
        }
        changing->value[i] = arrays[i].value;
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
}

/* Fill a batch with the next designs of a walk, which leaves out direction and angle, and find out
 * what the lanes have in common. Returns zero if these are the last designs. */
static int next_batch(Batch *b, Changing *changing, Walk *walk, int inputs) {
    long axis[LANES]; /* along which the walk goes on after each lane; -1 if it does not */
    int has_more = 1;
    b->count = 0;
    for (int lane = 0; lane < LANES; lane++) {
        axis[lane] = -1;
        if (has_more) {
            b->count++;
            axis[lane] = next_line(walk);
            has_more = axis[lane] >= 0;
        }
    }
    const Indices *either = &changing->either;
    b->shares_angles = 1;
    b->is_contiguous = either->count && either->index[either->count - 1] >= inputs;
    for (int k = 0; k < either->count; k++) {
        int i = either->index[k];
        char *first = changing->value[i];
        char *value = first;
        int is_shared = 1;
        int is_contiguous = 1;
        for (int lane = 0; lane < LANES; lane++) {
            b->value[i][lane] = value;
            is_shared &= value == first;
            is_contiguous &= value == first + 8 * lane;
            value += axis[lane] >= 0 ? changing->move[i][axis[lane]] : 0;
        }
        changing->value[i] = value;
        if (i >= inputs) {
            b->is_contiguous &= is_contiguous;
        } else {
            b->is_shared[i] = is_shared;
        }
        if (i < IN_gravity_moment) {
            b->shares_angles &= is_shared;
        }
    }
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

/* Load the inputs from `first` to before `end` at an angle. `is_shared` is a constant, true if the
 * lanes share them. */
INLINE void load_at_angle(const Batch *b, Lanes *in, long angle, int is_shared, int first,
                          int end) {
    for (int i = first; i < end; i++) {
        long offset = angle * b->angle_step[i];
        if (is_shared) {
            in[i] = all_lanes(*(const double *)(b->value[i][0] + offset));
        } else {
            in[i] = load_input(b, i, offset);
        }
    }
}

/* Load the inputs of lines at an angle that depend on it in any joint. */
INLINE void load_angle(const Batch *b, Lanes *in, long angle, int is_shared) {
    load_at_angle(b, in, angle, is_shared, IN_pulling_arm, IN_pressed);
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
    Changing changing;
    begin_batches(&b, &changing, walk, arrays, inputs, results);
    for (int i = IN_gravity_moment; i < INPUT_COUNT; i++) {
        is_constant &= !b.angle_step[i];
    }
    for (int i = 0; i < inputs; i++) {
        in[i] = load_input(&b, i, 0);
    }
    do {
        has_more = next_batch(&b, &changing, walk, inputs);
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
