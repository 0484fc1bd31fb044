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

/* Some of the inputs and results. */
typedef struct {
    int count, at[LIMITED + ACCUMULATORS];
} Some;

/* Those that differ between designs, and the inputs that change from one direction to the next; all else is looked at
 * once. */
typedef struct {
    Some between, turning, either;
} Changing;

static Changing changing(Beside *b, const Walk *walk, const Array *arrays, int inputs, int results) {
    Changing c;
    long angle = walk->axes - 1;
    c.between.count = c.turning.count = c.either.count = 0;
    for (int i = 0; i < inputs + results; i++) {
        int moves = 0, turns = i < inputs && arrays[i].step[angle - 1];
        for (long axis = 0; axis < angle - 1; axis++) moves |= arrays[i].step[axis] && walk->length[axis] > 1;
        if (moves) c.between.at[c.between.count++] = i;
        if (turns) c.turning.at[c.turning.count++] = i;
        if (moves || turns) c.either.at[c.either.count++] = i;
        for (int lane = 0; lane < LANES; lane++) b->at[i][lane] = arrays[i].at;
        if (i < inputs) b->alike[i] = 1;
        if (i < INPUTS) b->step[i] = arrays[i].step[angle];
    }
    return c;
}

/* The designs that a walk comes to, which leaves out direction and angle; returns zero where these are the last. */
static int gather(Beside *b, Walk *walk, Array *arrays, const Changing *c, int inputs) {
    int more = 1;
    b->count = 0, b->one_arm = 1;
    for (int lane = 0; lane < LANES; lane++) {
        for (int k = 0; k < c->either.count; k++) b->at[c->either.at[k]][lane] = arrays[c->either.at[k]].at;
        if (more) b->count++, more = next_line(walk, arrays, c->between.at, c->between.count);
    }
    b->adjoining = c->between.count && c->between.at[c->between.count - 1] >= inputs;
    for (int k = 0; k < c->between.count; k++) {
        int i = c->between.at[k], alike = 1, adjoining = 1;
        for (int lane = 1; lane < LANES; lane++) {
            alike &= b->at[i][lane] == b->at[i][0];
            adjoining &= b->at[i][lane] == b->at[i][0] + 8 * lane;
        }
        if (i >= inputs) b->adjoining &= adjoining;
        else b->alike[i] = alike;
        if (i < IN_gravity_moment) b->one_arm &= alike;
    }
    return more;
}

/* From one direction to the next. */
static void turn(Beside *b, const Walk *walk, const Array *arrays, const Some *turning) {
    for (int k = 0; k < turning->count; k++)
        for (int lane = 0; lane < LANES; lane++) b->at[turning->at[k]][lane] += arrays[turning->at[k]].step[walk->axes - 2];
}

/* An input of each design, so many bytes from its first value. */
INLINE Lanes across(const Beside *b, int input, long offset) {
    Lanes to = same(*(const double *)(b->at[input][0] + offset));
    if (!b->alike[input])
        for (int lane = 1; lane < LANES; lane++) to[lane] = *(const double *)(b->at[input][lane] + offset);
    return to;
}

/* The inputs at an angle that depend on it in any joint. */
INLINE void angle_across(const Beside *b, Lanes *in, long angle) {
    if (b->one_arm)
        for (int i = IN_pulling_arm; i < IN_gravity_moment; i++) in[i] = same(*(const double *)(b->at[i][0] + angle * b->step[i]));
    else
        for (int i = IN_pulling_arm; i < IN_gravity_moment; i++) in[i] = across(b, i, angle * b->step[i]);
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
    Lanes in[LIMITED];
    int more, begun = 0, is_plain = 1;
    long directions = walk->length[walk->axes - 2];
    walk->length[walk->axes - 2] = 1;
    Changing c = changing(&of, walk, arrays, inputs, results);
    for (int i = IN_gravity_moment; i < INPUTS; i++) is_plain &= !of.step[i];
    do {
        more = gather(&of, walk, arrays, &c, inputs);
        for (long direction = 0; direction < directions; direction++, turn(&of, walk, arrays, &c.turning)) {
            const Some *now = direction ? &c.turning : &c.either;
            if (begun)
                for (int k = 0; k < now->count && now->at[k] < inputs; k++) in[now->at[k]] = across(&of, now->at[k], 0);
            else
                for (int i = 0; i < inputs; i++) in[i] = across(&of, i, 0);
            begun = 1;
            Drive d = drive_at(in);
            of.plain = is_plain && adds_nothing(&d);
            visit(what, &of, in, &d, direction);
        }
    } while (more);
    walk->length[walk->axes - 2] = directions;
}

#endif
