/* Between which pretensions designs keep every limit in all their states: a fold over `lines_at`, `model/window.py`.
 *
 * Over v = F - shortfall a limited quantity is a line, base + gain v, which may be `most` at most: so a limit is an upper
 * end where the gain is positive, a lower one where it is negative, and where it is zero pretension changes nothing.
 */

#include "state.h"

#define NEVER 1e300 /* beyond any number of a state */

/* The tightest ends of some states, and where they are; and the first state that no pretension could help. */
typedef struct {
    Lanes low, high, low_at, high_at, blocked;
} Tightest;

INLINE void limit(Lanes *low, Lanes *high, Mask *hopeless, Lanes base, Lanes gain, double most) {
    Lanes end = (most - base) / gain, none = same(INFINITY);
    *low = larger(pick(gain < 0.0, end, -none), *low), *high = smaller(pick(gain > 0.0, end, none), *high);
    *hopeless |= (gain == 0.0) & (base - most > TOLERANCE * magnitude(same(most)));
}

INLINE void tighten(Tightest *t, const Lines *l, const Array *a, const Drive *d, Lanes place) {
    Lanes low = same(0.0), high = same(INFINITY);
    Mask hopeless = ~l->able;
    double x_least = one(a, IN_flexor_least), x_most = one(a, IN_flexor_most);
    double y_least = one(a, IN_extensor_least), y_most = one(a, IN_extensor_most);
    double torque = one(a, IN_torque_most), stiffness = one(a, IN_stiffness_least);
    if (x_least > -INFINITY) low = larger((x_least - l->x) / l->x_gain, low);
    if (y_least > -INFINITY) low = larger((y_least - l->y) / l->y_gain, low);
    if (x_most < INFINITY) high = smaller((x_most - l->x) / l->x_gain, high);
    if (y_most < INFINITY) high = smaller((y_most - l->y) / l->y_gain, high);
    if (torque < INFINITY) {
        Lanes base = l->x * d->motor_x - l->y * d->motor_y, gain = l->x_gain * d->motor_x - l->y_gain * d->motor_y;
        limit(&low, &high, &hopeless, base, gain, torque), limit(&low, &high, &hopeless, -base, -gain, torque);
    }
    if (stiffness > -INFINITY)
        limit(&low, &high, &hopeless, -(l->stiffness - l->x * l->arm_slope), l->x_gain * l->arm_slope, -stiffness);
    low = l->shortfall + low, high = l->shortfall + high;
    t->low_at = pick(low > t->low, place, t->low_at), t->low = larger(low, t->low);
    t->high_at = pick(high < t->high, place, t->high_at), t->high = smaller(high, t->high);
    t->blocked = pick(hopeless, smaller(place, t->blocked), t->blocked);
}

/* The tightest of all lanes into what was found of a design; of equal ends that of the first state. */
INLINE void settle(double *end, double *at, Lanes ends, Lanes places, double sign) {
    for (int lane = 0; lane < LANES; lane++) {
        double mine = sign * ends[lane], best = sign * *end;
        if (mine > best || (mine == best && mine < NEVER && mine > -NEVER && places[lane] < *at))
            *end = ends[lane], *at = places[lane];
    }
}

/* A design in one direction. */
static void window_line(const Window *w) {
    const Array *a = w->arrays;
    long axis = w->walk.axes - 1, angles = w->walk.length[axis];
    double first = (double)(w->walk.index[axis - 1] * w->total + w->first);
    Drive d = drive_at(a);
    Lanes none = same(INFINITY), step, nowhere = same(-1.0);
    for (int lane = 0; lane < LANES; lane++) step[lane] = lane;
    Tightest t = {-none, none, nowhere, nowhere, none};
    for (long at = 0; at < angles; at += LANES) {
        Lines l = lines_at(a, &d, axis, at, angles - at);
        l.able |= ~is_used(angles - at); /* what is no state blocks nothing */
        tighten(&t, &l, a, &d, first + (double)at + step);
    }
    double *found[ENDS];
    for (int i = 0; i < ENDS; i++) found[i] = (double *)a[LIMITED + i].at;
    settle(found[END_low], found[END_low_state], t.low, t.low_at, 1.0);
    settle(found[END_high], found[END_high_state], t.high, t.high_at, -1.0);
    for (int lane = 0; lane < LANES; lane++)
        if (t.blocked[lane] < *found[END_blocked]) *found[END_blocked] = t.blocked[lane];
}

static void window(Window *w) {
    do window_line(w);
    while (next_line(&w->walk, w->arrays, LIMITED + ENDS, -1));
}
