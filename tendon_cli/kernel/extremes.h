/* What designs come to over all their states: a fold of `state_at`, for each pretension over the same lines.
 *
 * Where there are enough pretensions these lie along the lanes, so that each is folded in a lane of its own; else
 * angles do, and the lanes are put together at the end.
 */

#include "state.h"

#define VECTORS 32 /* of angles, whose lines fit the innermost cache */
#define TOGETHER 6 /* as many vectors of states as putting the lanes together takes the time of */

/* Over some states; and over the same before any pretension. */
typedef struct {
    Lanes low_x, high_x, low_y, high_y, low_motor, high_motor, stiffness, unstable, slack, first, longest;
} Found;

typedef struct {
    double shortfall, limit, low_torque, high_torque, no_equilibrium;
} Before;

/* Lanes by halves: of all, the upper half folded onto the lower one until one is left. */
#define BY_HALVES(name, type, take)                                    \
    INLINE type name(Lanes a) {                                        \
        double lane[LANES];                                            \
        memcpy(lane, &a, sizeof a);                                    \
        for (int half = LANES / 2; half; half /= 2)                    \
            for (int i = 0; i < half; i++) lane[i] = take(lane[i], lane[i + half]); \
        return lane[0];                                                \
    }
#define LESS(a, b) ((b) < (a) ? (b) : (a))
#define MORE(a, b) ((b) > (a) ? (b) : (a))
#define SUM(a, b) ((a) + (b))
BY_HALVES(lowest_of, double, LESS)
BY_HALVES(highest_of, double, MORE)
BY_HALVES(sum_of, double, SUM)

INLINE Found nothing(void) {
    Lanes high = same(INFINITY), low = same(-INFINITY), zero = same(0.0);
    return (Found){high, low, high, low, high, low, high, zero, zero, high, low};
}

/* More states, a state a lane; `any_slack` says whether one may be. */
INLINE void take_in(Found *f, const Lines *lines, const Drive *d, Lanes angle, Lanes pretension, int any_slack) {
    Lanes zero = same(0.0), unit = same(1.0);
    State s = state_at(lines, d, pretension);
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

/* All states of some lines, angles along the lanes; every lane has what was found of all. */
INLINE Found along_angles(const Lines *lines, const double *angle, long angles, const Drive *d, Lanes pretension,
                          int any_slack) {
    Found f = nothing();
    for (long at = 0; at < angles; at += LANES, lines++) {
        Lanes here = same(INFINITY);
        memcpy(&here, angle + at, angles - at >= LANES ? sizeof here : 8 * (unsigned long)(angles - at));
        take_in(&f, lines, d, here, pretension, any_slack);
    }
    return (Found){same(lowest_of(f.low_x)), same(highest_of(f.high_x)), same(lowest_of(f.low_y)),
                   same(highest_of(f.high_y)), same(lowest_of(f.low_motor)), same(highest_of(f.high_motor)),
                   same(lowest_of(f.stiffness)), same(sum_of(f.unstable)), same(sum_of(f.slack)),
                   same(lowest_of(f.first)), same(highest_of(f.longest))};
}

/* The same of a pretension a lane. */
INLINE Found along_pretensions(const Lines *lines, const double *angle, long angles, const Drive *d, Lanes pretension,
                               int any_slack) {
    Found f = nothing();
    for (long at = 0; at < angles; at++) {
        Lines here;
        const double *from = (const double *)(lines + at / LANES) + at % LANES;
        Lanes *to = (Lanes *)&here;
        for (long field = 0; field < (long)(sizeof here / sizeof *to); field++) to[field] = same(from[field * LANES]);
        take_in(&f, &here, d, same(angle[at]), pretension, any_slack);
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

/* The smaller, or the larger, of what was found before and of a value for each pretension; or their sum. */
#define INTO(name, take)                                                                                     \
    INLINE void name(const Array *found, long axis, long first, long count, Lanes values) {                  \
        for (long lane = 0; lane < count; lane++) {                                                          \
            double *to = (double *)(found->at + (first + lane) * found->step[axis]), value = values[lane];   \
            *to = take(*to, value);                                                                          \
        }                                                                                                    \
    }
INTO(least, LESS)
INTO(most, MORE)
INTO(more, SUM)

/* What was found at `count` pretensions, from `first` on, into the accumulators of their designs. */
INLINE void note(const Array *a, long axis, long first, long count, const Found *f, const Before *b, const Drive *d,
                 long angles, Lanes pretension, Lanes smaller_side) {
#define INTO_ITS(name) a + INPUTS + AT_##name, axis, first, count
    Lanes capstan_x = same(one(a, IN_flexor_capstan)), capstan_y = same(one(a, IN_extensor_capstan));
    Lanes low = same(-INFINITY), margin = pretension - b->shortfall;
    Lanes max_x = larger(f->high_x, f->high_x / capstan_x), max_y = larger(f->high_y, f->high_y / capstan_y);
    Mask any_taut = (double)angles > f->slack + b->no_equilibrium;
    Lanes at_spring = larger(f->high_y * one(a, IN_extensor_spring), low);
    least(INTO_ITS(min_flexor_tension), smaller(f->low_x, f->low_x / capstan_x));
    least(INTO_ITS(min_extensor_tension), smaller(f->low_y, f->low_y / capstan_y));
    most(INTO_ITS(max_tension), larger(max_x, max_y)), most(INTO_ITS(max_extensor_distal), f->high_y);
    most(INTO_ITS(max_spring_extension), larger(f->high_x * one(a, IN_flexor_spring), at_spring));
    most(INTO_ITS(max_slack), d->unilateral ? larger(pick(any_taut, same(0.0), low), f->longest) : f->longest);
    least(INTO_ITS(lowest_elbow_torque), same(b->low_torque));
    most(INTO_ITS(highest_elbow_torque), same(b->high_torque));
    least(INTO_ITS(lowest_motor_torque), f->low_motor), most(INTO_ITS(highest_motor_torque), f->high_motor);
    least(INTO_ITS(min_elbow_stiffness), f->stiffness), least(INTO_ITS(first_slack_angle), f->first);
    most(INTO_ITS(required_pretension), same(b->shortfall)), least(INTO_ITS(margin), smaller(margin, smaller_side));
    more(INTO_ITS(slack), f->slack), more(INTO_ITS(unstable), f->unstable);
    more(INTO_ITS(no_equilibrium), same(b->no_equilibrium));
#undef INTO_ITS
}

/* Some lines at all pretensions, `at_once` of which are taken together: LANES, or one. */
INLINE void fold_lines(const Extremes *e, const Lines *lines, const Before *b, const Drive *d, const double *angle,
                       long angles, long axis, long pretensions, long at_once) {
    const Array *a = e->arrays, *flexor = a + IN_flexor_pretension, *extensor = a + IN_extensor_pretension;
    for (long first = 0; first < pretensions; first += at_once) {
        long count = pretensions - first < at_once ? pretensions - first : at_once;
        Lanes pretension, smaller_side;
        for (long lane = 0; lane < LANES; lane++) {
            long p = first + (lane < count ? lane : 0); /* what is left of the lanes repeats the first */
            double x = *(const double *)(flexor->at + p * flexor->step[axis]);
            double y = *(const double *)(extensor->at + p * extensor->step[axis]);
            pretension[lane] = common_pretension(d, x, y), smaller_side[lane] = LESS(y, x);
        }
        int any_slack = lowest_of(pretension) < b->limit;
        Found f;
        if (at_once == 1) f = any_slack ? along_angles(lines, angle, angles, d, pretension, 1)
                                        : along_angles(lines, angle, angles, d, pretension, 0);
        else f = any_slack ? along_pretensions(lines, angle, angles, d, pretension, 1)
                           : along_pretensions(lines, angle, angles, d, pretension, 0);
        note(a, axis, first, count, &f, b, d, angles, pretension, smaller_side);
    }
}

/* A design and direction at all pretensions; `lines` is there to work in. */
static void fold_line(const Extremes *e, Lines *lines) {
    const Array *a = e->arrays;
    long angle_axis = e->walk.axes - 1, angles = e->walk.length[angle_axis];
    long axis = e->pretensions < 0 ? 0 : e->pretensions;
    long pretensions = e->pretensions < 0 ? 1 : e->walk.length[axis];
    Drive d = drive_at(a);
    for (long from = 0; from < angles; from += VECTORS * LANES) {
        long count = angles - from < VECTORS * LANES ? angles - from : VECTORS * LANES;
        long alone = pretensions * ((count + LANES - 1) / LANES + TOGETHER);
        long together = (pretensions + LANES - 1) / LANES * count;
        Before b = prepare(lines, a, &d, angle_axis, from, count);
        if (together < alone) fold_lines(e, lines, &b, &d, e->angle + from, count, axis, pretensions, LANES);
        else fold_lines(e, lines, &b, &d, e->angle + from, count, axis, pretensions, 1);
    }
}

static void extremes(Extremes *e) {
    Lines lines[VECTORS];
    do fold_line(e, lines);
    while (next_line(&e->walk, e->arrays, INPUTS + ACCUMULATORS, e->pretensions));
}
