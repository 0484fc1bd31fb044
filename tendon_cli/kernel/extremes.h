/* What designs come to over all their states: a fold of `state_at`, for each pretension over the same lines. */

#include "state.h"

#define VECTORS 32 /* of angles, whose lines fit the innermost cache */

/* Over some states at one pretension; and over the same before any. */
typedef struct {
    Lanes low_x, high_x, low_y, high_y, low_motor, high_motor, stiffness, unstable, slack, first, longest;
} Found;

typedef struct {
    double shortfall, limit, low_torque, high_torque, no_equilibrium;
} Before;

INLINE double lowest_of(Lanes a) {
    double found = a[0];
    for (int lane = 1; lane < LANES; lane++) found = a[lane] < found ? a[lane] : found;
    return found;
}

INLINE double highest_of(Lanes a) {
    double found = a[0];
    for (int lane = 1; lane < LANES; lane++) found = a[lane] > found ? a[lane] : found;
    return found;
}

INLINE double sum_of(Lanes a) {
    double sum = 0.0;
    for (int lane = 0; lane < LANES; lane++) sum += a[lane];
    return sum;
}

/* All states of some lines at a pretension; `any_slack` says whether one may be. */
INLINE Found over(const Lines *lines, const double *angle, long angles, const Drive *d, double pretension,
                  int any_slack) {
    Lanes high = same(INFINITY), low = same(-INFINITY), zero = same(0.0), unit = same(1.0);
    Found f = {high, low, high, low, high, low, high, zero, zero, high, low};
    for (long at = 0; at < angles; at += LANES, lines++) {
        State s = state_at(lines, d, pretension);
        f.low_x = smaller(s.x, f.low_x), f.high_x = larger(s.x, f.high_x);
        f.low_y = smaller(s.y, f.low_y), f.high_y = larger(s.y, f.high_y);
        f.low_motor = smaller(s.motor, f.low_motor), f.high_motor = larger(s.motor, f.high_motor);
        f.stiffness = smaller(s.stiffness, f.stiffness);
        f.unstable += pick(s.stiffness < 0.0, unit, zero);
        if (!any_slack) continue;
        Lanes here = high;
        memcpy(&here, angle + at, angles - at >= LANES ? sizeof here : 8 * (unsigned long)(angles - at));
        f.slack += pick(s.slack, unit, zero);
        f.first = pick(s.slack, smaller(here, f.first), f.first);
        f.longest = pick(s.slack, larger(s.loose * lines->per_side, f.longest), f.longest);
    }
    return f;
}

static Before prepare(Lines *lines, const Array *a, const Drive *d, long axis, long from, long angles) {
    Lanes shortfall = same(-INFINITY), limit = shortfall, high = shortfall, low = same(INFINITY), able = same(0.0);
    for (long at = 0; at < angles; at += LANES, lines++) {
        *lines = lines_at(a, d, axis, from + at, angles - at);
        shortfall = larger(lines->shortfall, shortfall), limit = larger(lines->limit, limit);
        low = pick(lines->able, smaller(lines->torque, low), low);
        high = pick(lines->able, larger(lines->torque, high), high);
        able += pick(lines->able, same(1.0), same(0.0));
    }
    return (Before){highest_of(shortfall), highest_of(limit), lowest_of(low), highest_of(high),
                    (double)angles - sum_of(able)};
}

INLINE void least(double *to, double value) { *to = value < *to ? value : *to; }
INLINE void most(double *to, double value) { *to = value > *to ? value : *to; }

/* What was found, into the accumulators of a design; `a` stands at the design, `offset` at its pretension. */
INLINE void note(const Array *a, long axis, long offset, const Found *f, const Before *b, const Drive *d, long angles,
                 double pretension, double smaller_side) {
#define ACCUMULATED(name) ((double *)(a[INPUTS + AT_##name].at + offset * a[INPUTS + AT_##name].step[axis]))
    double low_x = lowest_of(f->low_x), high_x = highest_of(f->high_x), slack = sum_of(f->slack);
    double low_y = lowest_of(f->low_y), high_y = highest_of(f->high_y);
    double capstan_x = one(a, IN_flexor_capstan), capstan_y = one(a, IN_extensor_capstan);
    least(ACCUMULATED(min_flexor_tension), low_x), least(ACCUMULATED(min_flexor_tension), low_x / capstan_x);
    least(ACCUMULATED(min_extensor_tension), low_y), least(ACCUMULATED(min_extensor_tension), low_y / capstan_y);
    most(ACCUMULATED(max_tension), high_x), most(ACCUMULATED(max_tension), high_x / capstan_x);
    most(ACCUMULATED(max_tension), high_y), most(ACCUMULATED(max_tension), high_y / capstan_y);
    most(ACCUMULATED(max_extensor_distal), high_y);
    most(ACCUMULATED(max_spring_extension), high_x * one(a, IN_flexor_spring));
    most(ACCUMULATED(max_spring_extension), high_y * one(a, IN_extensor_spring));
    most(ACCUMULATED(max_slack), highest_of(f->longest));
    if (d->unilateral && (double)angles > slack + b->no_equilibrium) most(ACCUMULATED(max_slack), 0.0);
    least(ACCUMULATED(lowest_elbow_torque), b->low_torque), most(ACCUMULATED(highest_elbow_torque), b->high_torque);
    least(ACCUMULATED(lowest_motor_torque), lowest_of(f->low_motor));
    most(ACCUMULATED(highest_motor_torque), highest_of(f->high_motor));
    least(ACCUMULATED(min_elbow_stiffness), lowest_of(f->stiffness));
    least(ACCUMULATED(first_slack_angle), lowest_of(f->first));
    most(ACCUMULATED(required_pretension), b->shortfall), least(ACCUMULATED(margin), pretension - b->shortfall);
    least(ACCUMULATED(margin), smaller_side);
    *ACCUMULATED(slack) += slack, *ACCUMULATED(unstable) += sum_of(f->unstable);
    *ACCUMULATED(no_equilibrium) += b->no_equilibrium;
#undef ACCUMULATED
}

/* A design and direction at all pretensions; `lines` is there to work in. */
static void fold_line(const Extremes *e, Lines *lines) {
    const Array *a = e->arrays;
    long angle_axis = e->walk.axes - 1, axis = e->pretensions < 0 ? 0 : e->pretensions, angles = e->walk.length[angle_axis];
    long pretensions = e->pretensions < 0 ? 1 : e->walk.length[axis];
    Drive d = drive_at(a);
    for (long from = 0; from < angles; from += VECTORS * LANES) {
        long count = angles - from < VECTORS * LANES ? angles - from : VECTORS * LANES;
        Before b = prepare(lines, a, &d, angle_axis, from, count);
        for (long p = 0; p < pretensions; p++) {
            double flexor = *(const double *)(a[IN_flexor_pretension].at + p * a[IN_flexor_pretension].step[axis]);
            double extensor = *(const double *)(a[IN_extensor_pretension].at + p * a[IN_extensor_pretension].step[axis]);
            double pretension = common_pretension(&d, flexor, extensor);
            Found f = pretension < b.limit ? over(lines, e->angle + from, count, &d, pretension, 1)
                                           : over(lines, e->angle + from, count, &d, pretension, 0);
            note(a, axis, p, &f, &b, &d, count, pretension, flexor < extensor ? flexor : extensor);
        }
    }
}

static void extremes(Extremes *e) {
    Lines lines[VECTORS];
    do fold_line(e, lines);
    while (next_line(&e->walk, e->arrays, INPUTS + ACCUMULATORS, e->pretensions));
}
