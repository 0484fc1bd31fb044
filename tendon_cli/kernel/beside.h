/* Designs beside each other, one a lane, as a walk comes to them: their inputs, and what was found of them. */

#ifndef TENDON_BESIDE_H
#define TENDON_BESIDE_H

#include "state.h"

typedef struct {
    char *at[LIMITED + ACCUMULATORS][LANES]; /* each input and then each result, in one direction */
    int alike[LIMITED];                      /* whether all lanes have the same of an input */
    int one_arm;                             /* and of all that may depend on the angle, the first ones */
    int plain;                               /* whether the drives of the design are plain */
    long step[INPUTS];                       /* of an input from an angle to the next */
    int adjoining;                           /* whether results of one design follow those of the other */
    long count;                              /* designs; what is left of the lanes repeats the first, for nobody */
} Beside;

/* The designs that a walk comes to, which leaves out direction and angle; returns zero where these are the last. */
static int gather(Beside *b, Walk *walk, Array *arrays, int inputs, int results) {
    int more = 1, all = inputs + results;
    b->count = 0, b->adjoining = b->one_arm = 1;
    for (int lane = 0; lane < LANES; lane++) {
        for (int i = 0; i < all; i++) b->at[i][lane] = arrays[i].at;
        if (more) b->count++, more = next_line(walk, arrays, all);
    }
    for (int i = 0; i < inputs; i++) {
        b->alike[i] = 1;
        for (int lane = 1; lane < LANES; lane++) b->alike[i] &= b->at[i][lane] == b->at[i][0];
    }
    for (int i = 0; i < INPUTS; i++) {
        b->step[i] = arrays[i].step[walk->axes - 1];
        b->one_arm &= b->alike[i] || i >= IN_gravity_moment;
    }
    for (int i = inputs; i < all; i++)
        for (int lane = 1; lane < LANES; lane++) b->adjoining &= b->at[i][lane] == b->at[i][0] + 8 * lane;
    return more;
}

/* From one direction to the next, where inputs have steps along it. */
static void turn(Beside *b, const Walk *walk, const Array *arrays, int inputs) {
    for (int i = 0; i < inputs; i++)
        for (int lane = 0; lane < LANES; lane++) b->at[i][lane] += arrays[i].step[walk->axes - 2];
}

/* An input of each design, so many bytes from its first value. */
INLINE Lanes across(const Beside *b, int input, long offset) {
    Lanes to = same(*(const double *)(b->at[input][0] + offset));
    if (!b->alike[input])
        for (int lane = 1; lane < LANES; lane++) to[lane] = *(const double *)(b->at[input][lane] + offset);
    return to;
}

INLINE Angle angle_across(const Beside *b, long angle) {
#define ONE(name) same(*(const double *)(b->at[IN_##name][0] + angle * b->step[IN_##name]))
#define ACROSS(name) across(b, IN_##name, angle * b->step[IN_##name])
    if (b->one_arm)
        return (Angle){ONE(pulling_arm), ONE(flexor_slope), ONE(flexor_travel), ONE(extensor_travel),
                       ONE(sine),        ONE(cosine),       ONE(other_torque),  ONE(other_slope)};
    return (Angle){ACROSS(pulling_arm), ACROSS(flexor_slope), ACROSS(flexor_travel), ACROSS(extensor_travel),
                   ACROSS(sine),        ACROSS(cosine),       ACROSS(other_torque),  ACROSS(other_slope)};
#undef ACROSS
#undef ONE
}

/* The inputs at an angle, where they depend on it, and the drive of these. */
INLINE Drive drive_across(const Beside *b, Lanes *in, long angle) {
    for (int i = 0; i < INPUTS; i++) in[i] = across(b, i, angle * b->step[i]);
    return drive_at(in);
}

/* What is done with designs in one direction, of which `in` are the inputs. */
typedef void Visit(void *what, const Beside *of, const Lanes *in, const Drive *d, long direction);

/* To all designs, in each direction; always with the visit itself, so that it is written out here. */
INLINE void over_designs(Walk *walk, Array *arrays, int inputs, int results, Visit *visit, void *what) {
    Beside of;
    int more;
    long directions = walk->length[walk->axes - 2];
    walk->length[walk->axes - 2] = 1;
    do {
        more = gather(&of, walk, arrays, inputs, results);
        for (long direction = 0; direction < directions; direction++, turn(&of, walk, arrays, inputs)) {
            Lanes in[LIMITED];
            for (int i = 0; i < inputs; i++) in[i] = across(&of, i, 0);
            Drive d = drive_at(in);
            of.plain = adds_nothing(&d);
            for (int i = IN_gravity_moment; i < INPUTS; i++) of.plain &= !of.step[i];
            visit(what, &of, in, &d, direction);
        }
    } while (more);
    walk->length[walk->axes - 2] = directions;
}

#endif
