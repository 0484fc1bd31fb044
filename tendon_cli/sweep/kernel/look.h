/* A look at all states of a tile: what `lines.py` does in NumPy, operation by operation and to the same bits.
 *
 * Designs lie along the lanes. Per angle, direction and design the lines in pretension are worked out, then each
 * pretension takes a difference, a maximum, four multiply-adds and a dozen comparisons per state. ANGLES angles of lines
 * fit the innermost cache. A state without equilibrium is not a number all through, and comparisons leave it out.
 */

#include <stdlib.h>

#include "lines.h"

#define ANGLES 32

/* As `tile.Tile` has it: states over (angles, directions, designs), pretension over (pretensions, directions, designs). */
typedef struct {
    States states;
    Field pretension;
    const double *angle;
    long angles, directions, designs, pretensions, any_bilateral;
} Tile;

/* Over the angles so far, at one pretension. */
typedef struct {
    Lanes low_x, high_x, low_y, high_y, low_motor, high_motor, stiffness, unstable, slack, first;
} Found;

/* And before any. */
typedef struct {
    Lanes shortfall, flexor_shortfall, flexor_limit, extensor_shortfall, extensor_limit, one_sided, both_limit, nowhere,
        low_torque, high_torque;
} Aside;

#define FOUND (long)(sizeof(Found) / sizeof(Lanes))
#define ASIDE (long)(sizeof(Aside) / sizeof(Lanes))

/* Each result is an array over (pretensions, directions, designs), or over (directions, designs). */
typedef struct {
    double *found[FOUND], *aside[ASIDE];
} Seen;

INLINE Found begin(void) {
    Lanes most = all(INFINITY), least = all(-INFINITY), none = all(0.0);
    return (Found){most, least, most, least, most, least, most, none, none, most};
}

INLINE Aside begin_aside(void) {
    Lanes most = all(INFINITY), least = all(-INFINITY), none = all(0.0);
    return (Aside){least, least, least, least, least, none, most, none, most, least};
}

/* One angle more at a pretension. */
INLINE void look_on(Found *f, const Lines *l, Lanes angle, Lanes pretension) {
    Mask slack = pretension < l->limit;
    Lanes v = clip(pretension - l->shortfall, l->lowest), one = all(1.0), none = all(0.0);
    Lanes x = l->x_gain * v + l->x, y = l->y_gain * v + l->y, motor = l->motor_gain * v + l->motor;
    Lanes taut = l->k_gain * v + l->k, k = pick(slack, least(l->k_slack, taut), taut);
    f->low_x = least(x, f->low_x), f->high_x = most(x, f->high_x);
    f->low_y = least(y, f->low_y), f->high_y = most(y, f->high_y);
    f->low_motor = least(motor, f->low_motor), f->high_motor = most(motor, f->high_motor);
    f->stiffness = least(k, f->stiffness);
    f->unstable += pick(k < 0.0, one, none);
    f->slack += pick(slack, one, none);
    f->first = pick(slack, least(angle, f->first), f->first);
}

/* What no pretension changes: how far states are from slack, and on which side. */
INLINE void look_aside(Aside *a, const Lines *l, const Given *g) {
    Mask somewhere = is_number(l->limit), alone = somewhere & (l->idle == 0.0), able = g->arm > 0.0;
    Mask backward = alone & (g->torque < 0.0), forward = alone & ~backward;
    a->shortfall = most(l->shortfall, a->shortfall);
    a->flexor_shortfall = pick(backward, most(l->shortfall, a->flexor_shortfall), a->flexor_shortfall);
    a->flexor_limit = pick(backward, most(l->limit, a->flexor_limit), a->flexor_limit);
    a->extensor_shortfall = pick(forward, most(l->shortfall, a->extensor_shortfall), a->extensor_shortfall);
    a->extensor_limit = pick(forward, most(l->limit, a->extensor_limit), a->extensor_limit);
    a->one_sided = pick(alone, all(1.0), a->one_sided);
    a->both_limit = pick(l->idle > 0.0, least(l->limit, a->both_limit), a->both_limit);
    a->nowhere += pick(somewhere, all(0.0), all(1.0));
    a->low_torque = pick(able, least(g->torque, a->low_torque), a->low_torque);
    a->high_torque = pick(able, most(g->torque, a->high_torque), a->high_torque);
}

/* All angles of a stretch before any pretension. */
static void prepare(Lines *lines, Aside *a, const Tile *t, const Designs *d, long from, long angles, long direction,
                    long design, long count) {
    Aside aside = *a;
    for (long i = 0; i < angles; i++) {
        Given g = given_at(&t->states, d, from + i, direction, design, count);
        Lines l = lines_of(&g, d);
        if (t->any_bilateral) {
            Lanes flexor, extensor;
            side_limits(&l, &g, d, &flexor, &extensor);
            go_on(&l, d, most(flexor, extensor));
        }
        look_aside(&aside, &l, &g);
        lines[i] = l;
    }
    *a = aside;
}

/* All angles of a stretch at one pretension. */
static void over_angles(Found *f, const Lines *lines, const double *angle, long angles, Lanes pretension) {
    Found found = *f;
    for (long i = 0; i < angles; i++) look_on(&found, lines + i, all(angle[i]), pretension);
    *f = found;
}

/* Infinity, with which a search begins, is no number where nothing was found; no true result is infinite. */
INLINE Lanes result(Lanes found) { return pick(magnitude(found) == INFINITY, all(NAN), found); }

/* Some designs in one direction: `lines` and `found` are there to work in. */
static void look_at(const Tile *t, const Seen *s, Lines *lines, Found *found, long direction, long design) {
    long count = t->designs - design < LANES ? t->designs - design : LANES;
    Designs d = designs_at(&t->states, 0, direction, design, count);
    Aside aside = begin_aside();
    for (long p = 0; p < t->pretensions; p++) found[p] = begin();
    for (long from = 0; from < t->angles; from += ANGLES) {
        long angles = t->angles - from < ANGLES ? t->angles - from : ANGLES;
        prepare(lines, &aside, t, &d, from, angles, direction, design, count);
        for (long p = 0; p < t->pretensions; p++)
            over_angles(found + p, lines, t->angle + from, angles, take(&t->pretension, p, direction, design, count));
    }
    aside.shortfall = result(aside.shortfall);
    aside.low_torque = result(aside.low_torque), aside.high_torque = result(aside.high_torque);
    long at = direction * t->designs + design;
    for (long r = 0; r < ASIDE; r++) put(s->aside[r] + at, (&aside.shortfall)[r], count);
    for (long p = 0; p < t->pretensions; p++, at += t->directions * t->designs)
        for (long r = 0; r < FOUND; r++) put(s->found[r] + at, result((&found[p].low_x)[r]), count);
}

/* Returns nought, or one where there is no memory. */
static int look(const Tile *t, const Seen *s) {
    Lines *lines = aligned_alloc(64, ANGLES * sizeof(Lines));
    Found *found = aligned_alloc(64, ((unsigned long)t->pretensions * sizeof(Found) + 63) / 64 * 64);
    int failed = !lines || !found;
    for (long direction = 0; direction < t->directions && !failed; direction++)
        for (long design = 0; design < t->designs; design += LANES) look_at(t, s, lines, found, direction, design);
    free(lines), free(found);
    return failed;
}
