/* What designs come to over all their states: a fold of `state_at`, for each pretension over the same lines.
 *
 * Designs lie along the lanes, which share neither state nor result. Where nothing but pretension depends on an axis
 * its values are gone through with the lines at hand; where there are fewer designs else than lanes, it is cut in runs.
 */

#include "beside.h"

#define ANGLES 24      /* whose lines fit the innermost cache */
#define PRETENSIONS 32 /* that are gone through together */

/* Over some states of each design; and over the same before any pretension. */
typedef struct {
    Lanes low_x, high_x, low_y, high_y, low_motor, high_motor, stiffness, unstable, slack, first, longest;
} Found;

typedef struct {
    Lanes shortfall, low_torque, high_torque, no_equilibrium;
} Before;

INLINE Found nothing(void) {
    Lanes high = same(INFINITY), low = same(-INFINITY), zero = same(0.0);
    return (Found){high, low, high, low, high, low, high, zero, zero, high, low};
}

/* A state more of each design; `any_slack` says whether one may be. */
INLINE void take_in(Found *f, const Lines *lines, const Drive *d, Lanes angle, Lanes pretension, int any_slack,
                    int plain) {
    Lanes zero = same(0.0), unit = same(1.0);
    State s = state_at(lines, d, pretension, plain);
    f->low_x = smaller(s.x, f->low_x), f->high_x = larger(s.x, f->high_x);
    f->low_y = smaller(s.y, f->low_y), f->high_y = larger(s.y, f->high_y);
    f->low_motor = smaller(s.motor, f->low_motor), f->high_motor = larger(s.motor, f->high_motor);
    f->stiffness = smaller(s.stiffness, f->stiffness);
    f->unstable += pick(s.stiffness < 0.0, unit, zero);
    if (!any_slack) return;
    f->slack += pick(s.slack, unit, zero);
    f->first = pick(s.slack, smaller(angle, f->first), f->first);
    f->longest = pick(s.slack, larger(s.loose * lines->per_side, f->longest), f->longest);
}

INLINE Found along_angles(Found f, const Lines *lines, const double *angle, long angles, const Drive *d,
                          Lanes pretension, int any_slack, int plain) {
    for (long at = 0; at < angles; at++) take_in(&f, lines + at, d, same(angle[at]), pretension, any_slack, plain);
    return f;
}

/* The lines of some angles, and these; returns the pretension below which one of their states is slack. */
static Lanes prepare(Lines *lines, double *angle, Before *b, const Extremes *e, const Beside *of, const Drive *d, long from,
                     long angles, int plain) {
    Lanes limit = same(-INFINITY), in[IN_gravity_moment];
    for (long at = 0; at < angles; at++, lines++) {
        angle[at] = *(const double *)(e->angle->at + (from + at) * e->angle->step[e->walk.axes - 1]);
        angle_across(of, in, from + at);
        *lines = lines_at(d, in, plain);
        limit = larger(lines->limit, limit), b->shortfall = larger(lines->shortfall, b->shortfall);
        b->low_torque = pick(lines->able, smaller(lines->torque, b->low_torque), b->low_torque);
        b->high_torque = pick(lines->able, larger(lines->torque, b->high_torque), b->high_torque);
        b->no_equilibrium += pick(lines->able, same(0.0), same(1.0));
    }
    return limit;
}

/* The smaller, or the larger, of what was found of each design before and of a value; or their sum. */
#define INTO(name, take)                                                        \
    INLINE void name(const Beside *of, int result, long offset, Lanes values) { \
        Lanes found = values;                                                   \
        if (of->adjoining) {                                                    \
            memcpy(&found, of->at[result][0] + offset, sizeof found);           \
            found = take(values, found);                                        \
            memcpy(of->at[result][0] + offset, &found, sizeof found);           \
            return;                                                             \
        }                                                                       \
        for (long lane = 0; lane < of->count; lane++)                           \
            found[lane] = *(double *)(of->at[result][lane] + offset);           \
        found = take(values, found);                                            \
        for (long lane = 0; lane < of->count; lane++)                           \
            *(double *)(of->at[result][lane] + offset) = found[lane];           \
    }
INLINE Lanes sum(Lanes a, Lanes b) { return a + b; }
INTO(least, smaller)
INTO(most, larger)
INTO(more, sum)

/* What was found at a pretension, by its place, into the results of the designs. */
INLINE void note(const Extremes *e, const Beside *of, const long *step, long place, const Found *f, const Before *b,
                 const Drive *d, const Lanes *in, Lanes pretension, Lanes smaller_side, long angles) {
#define ITS(name) of, INPUTS + AT_##name, place * step[INPUTS + AT_##name]
    Lanes capstan_x = in[IN_flexor_capstan], capstan_y = in[IN_extensor_capstan], low = same(-INFINITY);
    Lanes max_x = larger(f->high_x, f->high_x / capstan_x), max_y = larger(f->high_y, f->high_y / capstan_y);
    Mask any_taut = (double)angles > f->slack + b->no_equilibrium;
    Lanes no_slack = pick(d->unilateral & any_taut, same(0.0), low);
    least(ITS(min_flexor_tension), smaller(f->low_x, f->low_x / capstan_x));
    least(ITS(min_extensor_tension), smaller(f->low_y, f->low_y / capstan_y));
    most(ITS(max_tension), larger(max_x, max_y)), most(ITS(max_extensor_distal), f->high_y);
    most(ITS(max_spring_extension), larger(f->high_x * in[IN_flexor_spring], f->high_y * in[IN_extensor_spring]));
    most(ITS(max_slack), larger(no_slack, f->longest));
    least(ITS(lowest_elbow_torque), b->low_torque), most(ITS(highest_elbow_torque), b->high_torque);
    least(ITS(lowest_motor_torque), f->low_motor), most(ITS(highest_motor_torque), f->high_motor);
    least(ITS(min_elbow_stiffness), f->stiffness), least(ITS(first_slack_angle), f->first);
    most(ITS(required_pretension), b->shortfall);
    least(ITS(margin), smaller(smaller_side, pretension - b->shortfall));
    more(ITS(slack), f->slack), more(ITS(unstable), f->unstable), more(ITS(no_equilibrium), b->no_equilibrium);
#undef ITS
}

/* Designs in a direction at `count` pretensions, from `first` on, and some angles; `step` is from one pretension to the
 * next, of each array. */
INLINE void fold_some(const Extremes *e, const Beside *of, const long *step, const Lanes *in, const Drive *d, long first,
                      long count, long start, long stop, int plain) {
    Lines lines[ANGLES];
    double angle[ANGLES];
    Found found[PRETENSIONS];
    Lanes pretension[PRETENSIONS], smaller_side[PRETENSIONS];
    Before before = {same(-INFINITY), same(INFINITY), same(-INFINITY), same(0.0)};
    for (long p = 0; p < count; p++) {
        Lanes x = across(of, IN_flexor_pretension, (first + p) * step[IN_flexor_pretension]);
        Lanes y = across(of, IN_extensor_pretension, (first + p) * step[IN_extensor_pretension]);
        found[p] = nothing(), pretension[p] = common_pretension(d, x, y), smaller_side[p] = smaller(x, y);
    }
    for (long from = start; from < stop; from += ANGLES) {
        long angles = stop - from < ANGLES ? stop - from : ANGLES;
        Lanes limit = prepare(lines, angle, &before, e, of, d, from, angles, plain);
        for (long p = 0; p < count; p++)
            found[p] = any(pretension[p] < limit)
                           ? along_angles(found[p], lines, angle, angles, d, pretension[p], 1, plain)
                           : along_angles(found[p], lines, angle, angles, d, pretension[p], 0, plain);
    }
    for (long p = 0; p < count; p++)
        note(e, of, step, first + p, found + p, &before, d, in, pretension[p], smaller_side[p], stop - start);
}

static void fold_plain(const Extremes *e, const Beside *of, const long *step, const Lanes *in, const Drive *d, long first,
                       long count) {
    fold_some(e, of, step, in, d, first, count, 0, e->walk.length[e->walk.axes - 1], 1);
}

/* Tension scales differently along a sheath at each angle, so each is folded by itself. */
static void fold_each_angle(const Extremes *e, const Beside *of, const long *step, long first, long count) {
    Lanes in[INPUTS];
    for (long at = 0; at < e->walk.length[e->walk.axes - 1]; at++) {
        Drive d = drive_across(of, in, at);
        fold_some(e, of, step, in, &d, first, count, at, at + 1, 0);
    }
}

/* Designs after each of which come `pretensions` less one, `step` from one another. */
typedef struct {
    const Extremes *e;
    const long *step;
    long pretensions;
} Run;

INLINE void fold_run(void *what, const Beside *of, const Lanes *in, const Drive *d, long direction) {
    const Run *run = what;
    (void)direction;
    for (long first = 0; first < run->pretensions; first += PRETENSIONS) {
        long count = run->pretensions - first < PRETENSIONS ? run->pretensions - first : PRETENSIONS;
        if (of->plain) fold_plain(run->e, of, run->step, in, d, first, count);
        else fold_each_angle(run->e, of, run->step, first, count);
    }
}

static void fold_all(Extremes *e, const long *step, long pretensions) {
    Run run = {e, step, pretensions};
    over_designs(&e->walk, e->arrays, INPUTS, ACCUMULATORS, fold_run, &run);
}

/* The longest axis of designs that nothing but pretension depends on; -1 where there is none. */
static long axis_of_pretension(const Extremes *e) {
    long longest = -1;
    for (long axis = 0; axis < e->walk.axes - 2; axis++) {
        int is_free = 1;
        for (int i = 0; i < INPUTS; i++)
            is_free &= i == IN_flexor_pretension || i == IN_extensor_pretension || !e->arrays[i].step[axis];
        if (is_free && (longest < 0 || e->walk.length[axis] > e->walk.length[longest])) longest = axis;
    }
    return longest;
}

static void extremes(Extremes *e) {
    long axis = axis_of_pretension(e), step[INPUTS + ACCUMULATORS] = {0};
    if (axis < 0) {
        fold_all(e, step, 1);
        return;
    }
    long pretensions = e->walk.length[axis], rest = 1;
    for (long other = 0; other < e->walk.axes - 2; other++)
        if (other != axis) rest *= e->walk.length[other];
    for (int i = 0; i < INPUTS + ACCUMULATORS; i++) step[i] = e->arrays[i].step[axis];
    for (long done = 0, runs = rest < LANES ? LANES / rest : 1, each; done < pretensions; done += runs * each) {
        if (runs > pretensions - done) runs = pretensions - done;
        each = (pretensions - done) / runs;
        e->walk.length[axis] = runs;
        for (int i = 0; i < INPUTS + ACCUMULATORS; i++) e->arrays[i].step[axis] = each * step[i];
        fold_all(e, step, each);
        for (int i = 0; i < INPUTS + ACCUMULATORS; i++) e->arrays[i].at += runs * each * step[i];
    }
}
