/* Between which pretensions designs keep every limit in all their states: a fold over `lines_at`, `model/window.py`.
 *
 * Over v = F - shortfall a limited quantity is a line, base + gain v, which may be `most` at most: so a limit is an upper
 * end where the gain is positive, a lower one where it is negative, and where it is zero pretension changes nothing.
 */

#include "beside.h"

#define NEVER 1e300 /* beyond any number of a state */

/* The tightest ends of some states of each design, and where they are; and the first state that no pretension could
 * help. */
typedef struct {
    Lanes low, high, low_at, high_at, blocked;
} Tightest;

INLINE void limit(Lanes *low, Lanes *high, Mask *hopeless, Lanes base, Lanes gain, Lanes most) {
    Lanes end = (most - base) / gain, none = same(INFINITY);
    *low = larger(pick(gain < 0.0, end, -none), *low), *high = smaller(pick(gain > 0.0, end, none), *high);
    *hopeless |= (gain == 0.0) & (base - most > TOLERANCE * magnitude(most));
}

/* Which bounds are asked for. */
typedef struct {
    int flexor_least, extensor_least, flexor_most, extensor_most, torque, stiffness;
} Asked;

/* A state more of each design, with what each is held to; `place` is its number. */
INLINE void tighten(Tightest *t, const Lines *l, const Lanes *in, const Asked *asked, const Drive *d, Lanes place) {
    Lanes low = same(0.0), high = same(INFINITY);
    Mask hopeless = ~l->able;
    if (asked->flexor_least) low = larger((in[IN_flexor_least] - l->x) / l->x_gain, low);
    if (asked->extensor_least) low = larger((in[IN_extensor_least] - l->y) / l->y_gain, low);
    if (asked->flexor_most) high = smaller((in[IN_flexor_most] - l->x) / l->x_gain, high);
    if (asked->extensor_most) high = smaller((in[IN_extensor_most] - l->y) / l->y_gain, high);
    if (asked->torque) {
        Lanes base = l->x * d->motor_x - l->y * d->motor_y, gain = l->x_gain * d->motor_x - l->y_gain * d->motor_y;
        limit(&low, &high, &hopeless, base, gain, in[IN_torque_most]);
        limit(&low, &high, &hopeless, -base, -gain, in[IN_torque_most]);
    }
    if (asked->stiffness) {
        Lanes base = -(l->stiffness - l->x * l->arm_slope), gain = l->x_gain * l->arm_slope;
        limit(&low, &high, &hopeless, base, gain, -in[IN_stiffness_least]);
    }
    low = l->shortfall + low, high = l->shortfall + high;
    t->low_at = pick(low > t->low, place, t->low_at), t->low = larger(low, t->low);
    t->high_at = pick(high < t->high, place, t->high_at), t->high = smaller(high, t->high);
    t->blocked = pick(hopeless, smaller(place, t->blocked), t->blocked);
}

/* The tighter of an end and what was found before; of equal ends that of the first state. */
INLINE void settle(char *const *end, char *const *at, long count, Lanes ends, Lanes places, double sign) {
    for (long lane = 0; lane < count; lane++) {
        double *found = (double *)end[lane], *where = (double *)at[lane];
        double mine = sign * ends[lane], best = sign * *found;
        if (mine > best || (mine == best && mine < NEVER && mine > -NEVER && places[lane] < *where))
            *found = ends[lane], *where = places[lane];
    }
}

/* Which bounds any of some designs has. */
INLINE Asked asked_of(const Lanes *in) {
    Lanes none = same(INFINITY);
    return (Asked){any(in[IN_flexor_least] > -none), any(in[IN_extensor_least] > -none),
                   any(in[IN_flexor_most] < none),   any(in[IN_extensor_most] < none),
                   any(in[IN_torque_most] < none),   any(in[IN_stiffness_least] > -none)};
}

INLINE void fold_states(void *what, const Beside *of, const Lanes *in, const Drive *d, long direction) {
    const Window *w = what;
    double first = (double)(direction * w->total + w->first);
    Lanes none = same(INFINITY), nowhere = same(-1.0);
    Asked asked = asked_of(in);
    Tightest t = {-none, none, nowhere, nowhere, none};
    for (long at = 0, angles = w->walk.length[w->walk.axes - 1]; at < angles; at++) {
        Angle here = angle_across(of, at);
        Lines l = lines_at(d, &here);
        tighten(&t, &l, in, &asked, d, same(first + (double)at));
    }
    char *const(*found)[LANES] = of->at + LIMITED;
    settle(found[END_low], found[END_low_state], of->count, t.low, t.low_at, 1.0);
    settle(found[END_high], found[END_high_state], of->count, t.high, t.high_at, -1.0);
    for (long lane = 0; lane < of->count; lane++)
        if (t.blocked[lane] < *(double *)found[END_blocked][lane]) *(double *)found[END_blocked][lane] = t.blocked[lane];
}

static void window(Window *w) { over_designs(&w->walk, w->arrays, LIMITED, ENDS, fold_states, w); }
