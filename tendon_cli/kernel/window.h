/* Between which pretensions designs keep every limit in all their states: a fold over `lines_at`, `model/window.py`.
 *
 * No limit is known here by name. Held are both tensions, the elbow stiffness, and forms of all three; over
 * v = F - shortfall each is a line, base + gain v. So a bound on it is an end from the side that the gain says, and where
 * the gain is zero pretension changes nothing.
 */

#include "beside.h"

#define NEVER 1e300 /* beyond any number of a state */

/* The tightest ends of some states of each design, and where they are; and the first state that no pretension could
 * help. */
typedef struct {
    Lanes low, high, low_at, high_at, blocked;
} Tightest;

/* The ends of one state of each design. */
typedef struct {
    Lanes low, high;
    Mask hopeless;
} Range;

/* Which bounds, and which shares of forms, any of some designs has, and which of these change from angle to angle. */
typedef struct {
    int bound[LIMITED], moving[LIMITED], moves;
} Asked;

/* A line that is held: `below` where it may not be less than the bound, else not more. */
INLINE void bounded(Range *r, Lanes base, Lanes gain, Lanes bound, int below) {
    Lanes end = (bound - base) / gain, none = same(INFINITY);
    Lanes short_of = below ? bound - base : base - bound;
    Mask rises = gain > 0.0, falls = gain < 0.0;
    r->low = larger(pick(below ? rises : falls, end, -none), r->low);
    r->high = smaller(pick(below ? falls : rises, end, none), r->high);
    r->hopeless |= (gain == 0.0) & (short_of > TOLERANCE * magnitude(bound));
}

/* A state more of each design, with what each is held to; `place` is its number. */
INLINE void tighten(Tightest *t, const Lines *l, const Lanes *in, const Asked *asked, int forms, const Drive *d, Lanes place,
                    int plain) {
    Range r = {same(0.0), same(INFINITY), ~l->able};
    const int *bound = asked->bound;
    if (bound[IN_flexor_least]) r.low = larger((in[IN_flexor_least] - l->x) / l->x_gain, r.low);
    if (bound[IN_extensor_least]) r.low = larger((in[IN_extensor_least] - l->y) / l->y_gain, r.low);
    if (bound[IN_flexor_most]) r.high = smaller((in[IN_flexor_most] - l->x) / l->x_gain, r.high);
    if (bound[IN_extensor_most]) r.high = smaller((in[IN_extensor_most] - l->y) / l->y_gain, r.high);
    Lanes k = l->stiffness - l->x * l->slope_x, k_gain = -(l->x_gain * l->slope_x);
    if (!plain) k += l->y * d->slope_y, k_gain += l->y_gain * d->slope_y;
    if (bound[IN_stiffness_least]) bounded(&r, k, k_gain, in[IN_stiffness_least], 1);
    if (bound[IN_stiffness_most]) bounded(&r, k, k_gain, in[IN_stiffness_most], 0);
    for (int form = 0; form < forms; form++) {
        const Lanes *f = in + BOUNDED + PER_FORM * form;
        const int *its = bound + BOUNDED + PER_FORM * form;
        Lanes base = f[FORM_flexor] * l->x + f[FORM_extensor] * l->y;
        Lanes gain = f[FORM_flexor] * l->x_gain + f[FORM_extensor] * l->y_gain;
        if (its[FORM_stiffness]) base += f[FORM_stiffness] * k, gain += f[FORM_stiffness] * k_gain;
        if (its[FORM_least]) bounded(&r, base, gain, f[FORM_least], 1);
        if (its[FORM_most]) bounded(&r, base, gain, f[FORM_most], 0);
    }
    Lanes low = l->shortfall + r.low, high = l->shortfall + r.high;
    t->low_at = pick(low > t->low, place, t->low_at), t->low = larger(low, t->low);
    t->high_at = pick(high < t->high, place, t->high_at), t->high = smaller(high, t->high);
    t->blocked = pick(r.hopeless, smaller(place, t->blocked), t->blocked);
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

INLINE Asked asked_of(const Window *w, const Lanes *in, int inputs) {
    Asked asked;
    asked.moves = 0;
    for (int i = INPUTS; i < inputs; i++) {
        int is_share = i >= BOUNDED && (i - BOUNDED) % PER_FORM == FORM_stiffness;
        asked.bound[i] = is_share ? any(in[i] != 0.0) : any(magnitude(in[i]) < INFINITY);
        if (w->arrays[i].step[w->walk.axes - 1]) asked.bound[i] = 1, asked.moving[asked.moves++] = i;
    }
    return asked;
}

/* All angles of designs in one direction; `plain` and `moves` are constants, and so is `forms` if it is zero. */
INLINE void over_angles(Tightest *t, const Window *w, const Beside *of, const Lanes *in, const Drive *d, const Asked *asked,
                  double first, int forms, int moves, int plain) {
    Lanes now[LIMITED], here[IN_gravity_moment], its[INPUTS];
    if (moves)
        for (int i = INPUTS; i < BOUNDED + PER_FORM * forms; i++) now[i] = in[i];
    for (long at = 0, angles = w->walk.length[w->walk.axes - 1]; at < angles; at++) {
        for (int i = 0; moves && i < asked->moves; i++) {
            int input = asked->moving[i];
            now[input] = across(of, input, at * w->arrays[input].step[w->walk.axes - 1]);
        }
        if (plain) {
            angle_across(of, here, at);
            Lines l = lines_at(d, here, plain);
            tighten(t, &l, moves ? now : in, asked, forms, d, same(first + (double)at), 1);
        } else {
            Drive own = drive_across(of, its, at);
            Lines l = lines_at(&own, its, 0);
            tighten(t, &l, moves ? now : in, asked, forms, &own, same(first + (double)at), 0);
        }
    }
}

INLINE void fold_states(void *what, const Beside *of, const Lanes *in, const Drive *d, long direction) {
    const Window *w = what;
    int inputs = BOUNDED + PER_FORM * w->forms;
    double first = (double)(direction * w->total + w->first);
    Lanes none = same(INFINITY), nowhere = same(-1.0);
    Asked asked = asked_of(w, in, inputs);
    Tightest t = {-none, none, nowhere, nowhere, none};
    if (!of->plain || asked.moves) over_angles(&t, w, of, in, d, &asked, first, w->forms, 1, 0);
    else if (w->forms) over_angles(&t, w, of, in, d, &asked, first, w->forms, 0, 1);
    else over_angles(&t, w, of, in, d, &asked, first, 0, 0, 1);
    char *const(*found)[LANES] = of->at + inputs;
    settle(found[END_low], found[END_low_state], of->count, t.low, t.low_at, 1.0);
    settle(found[END_high], found[END_high_state], of->count, t.high, t.high_at, -1.0);
    for (long lane = 0; lane < of->count; lane++)
        if (t.blocked[lane] < *(double *)found[END_blocked][lane]) *(double *)found[END_blocked][lane] = t.blocked[lane];
}

static void window(Window *w) {
    over_designs(&w->walk, w->arrays, BOUNDED + PER_FORM * w->forms, ENDS, fold_states, w);
}
