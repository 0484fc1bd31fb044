/* Extremes of designs over all their states: a fold of `state_at`, for many pretensions over the
 * same lines.
 *
 * Designs lie along the lanes, which share neither states nor results. If only pretension depends
 * on an axis, its values are taken one by one with the same lines; that axis is cut into runs if
 * the other axes have fewer designs than there are lanes.
 */

#include "batch.h"

#define ANGLES_AT_ONCE 24      /* their lines fit the innermost cache */
#define PRETENSIONS_AT_ONCE 32 /* they share the lines of some angles */

/* Lines of the states of each design at one angle, and what the parts there allow. */
typedef struct {
    Lines lines;
    Lanes pressed;     /* one where the extensor's strap presses, else zero */
    Lanes spring_room; /* length by which the flexor's spring may be extended, m */
} Angle;

/* Extremes over some states of each design at one pretension. */
typedef struct {
    Lanes low_x; /* smallest distal tension of the flexor, N */
    Lanes high_x;
    Lanes low_y; /* smallest distal tension of the extensor, N */
    Lanes high_y;
    Lanes high_strap; /* largest distal tension of the extensor where its strap presses, N */
    Lanes low_room;   /* smallest room left for the flexor's spring, m */
    Lanes low_motor; /* smallest motor torque, N m */
    Lanes high_motor;
    Lanes stiffness;     /* smallest elbow stiffness, N m/rad */
    Lanes unstable;      /* number of states with a negative stiffness */
    Lanes slack;         /* number of slack states */
    Lanes first_slack;   /* smallest angle of a slack state, rad */
    Lanes longest_slack; /* largest slack length, m */
} Extremes;

/* Extremes over the same states of what scales along the sheath, and the smallest margin. */
typedef struct {
    Lanes low_x;     /* smallest tension of the flexor at either end, N */
    Lanes low_y;     /* smallest tension of the extensor at either end, N */
    Lanes high;      /* largest tension, N */
    Lanes extension; /* largest extension of a spring, m */
    Lanes margin;    /* smallest margin of pretension, N */
} ScaledExtremes;

/* Extremes over the same states that no pretension changes. */
typedef struct {
    Lanes required;       /* largest pretension that a state requires, N */
    Lanes low_torque;     /* smallest elbow torque, N m */
    Lanes high_torque;
    Lanes no_equilibrium; /* number of states without equilibrium */
} LoadExtremes;

/* Extremes over no states. */
INLINE Extremes no_extremes(void) {
    Lanes high = all_lanes(INFINITY);
    Lanes low = all_lanes(-INFINITY);
    Lanes zero = all_lanes(0.0);
    return (Extremes){
        .low_x = high,
        .high_x = low,
        .low_y = high,
        .high_y = low,
        .high_strap = low,
        .low_room = high,
        .low_motor = high,
        .high_motor = low,
        .stiffness = high,
        .unstable = zero,
        .slack = zero,
        .first_slack = high,
        .longest_slack = low,
    };
}

/* Scaled extremes over no states. */
INLINE ScaledExtremes no_scaled_extremes(void) {
    Lanes high = all_lanes(INFINITY);
    Lanes low = all_lanes(-INFINITY);
    return (ScaledExtremes){
        .low_x = high,
        .low_y = high,
        .high = low,
        .extension = low,
        .margin = high,
    };
}

/* Load extremes over no states. */
INLINE LoadExtremes no_load_extremes(void) {
    return (LoadExtremes){
        .required = all_lanes(-INFINITY),
        .low_torque = all_lanes(INFINITY),
        .high_torque = all_lanes(-INFINITY),
        .no_equilibrium = all_lanes(0.0),
    };
}

/* Add a state of each design and return it. `any_slack` is zero if none of them can be slack. */
INLINE State add_state(Extremes *e, const Angle *at, const Drive *d, Lanes angle,
                      Lanes pretension, int any_slack, int is_plain) {
    const Lines *lines = &at->lines;
    Lanes zero = all_lanes(0.0);
    Lanes unit = all_lanes(1.0);
    State s = state_at(lines, d, pretension, is_plain);
    e->low_x = smaller(s.x, e->low_x);
    e->high_x = larger(s.x, e->high_x);
    e->low_y = smaller(s.y, e->low_y);
    e->high_y = larger(s.y, e->high_y);
    e->high_strap = larger(s.y * at->pressed, e->high_strap);
    e->low_room = smaller(at->spring_room - s.x * d->spring_x, e->low_room);
    e->low_motor = smaller(s.motor, e->low_motor);
    e->high_motor = larger(s.motor, e->high_motor);
    e->stiffness = smaller(s.stiffness, e->stiffness);
    e->unstable += pick(s.stiffness < 0.0, unit, zero);
    if (any_slack) {
        Lanes slack_length = s.path * lines->per_path;
        e->slack += pick(s.slack, unit, zero);
        e->first_slack = pick(s.slack, smaller(angle, e->first_slack), e->first_slack);
        e->longest_slack = pick(s.slack, larger(slack_length, e->longest_slack), e->longest_slack);
    }
    return s;
}

/* Add the distal tensions of states between which tension scales alike, from `low` to `high` on
 * either side, and a margin of pretension, N. `in` are the inputs of these states. */
INLINE void add_scaled(ScaledExtremes *e, Lanes low_x, Lanes high_x, Lanes low_y, Lanes high_y,
                       const Lanes *in, Lanes margin) {
    Lanes capstan_x = in[IN_flexor_capstan];
    Lanes capstan_y = in[IN_extensor_capstan];
    Lanes max_x = larger(high_x, high_x / capstan_x);
    Lanes max_y = larger(high_y, high_y / capstan_y);
    Lanes extension_x = high_x * in[IN_flexor_spring];
    Lanes extension_y = high_y * in[IN_extensor_spring];
    e->low_x = smaller(smaller(low_x, low_x / capstan_x), e->low_x);
    e->low_y = smaller(smaller(low_y, low_y / capstan_y), e->low_y);
    e->high = larger(larger(max_x, max_y), e->high);
    e->extension = larger(larger(extension_x, extension_y), e->extension);
    e->margin = smaller(margin, e->margin);
}

/* Add the states of each design at several angles, with plain drives. */
INLINE Extremes add_angles(Extremes e, const Angle *at, const double *angle, long angles,
                           const Drive *d, Lanes pretension, int any_slack) {
    for (long i = 0; i < angles; i++) {
        add_state(&e, at + i, d, all_lanes(angle[i]), pretension, any_slack, 1);
    }
    return e;
}

/* Compute the lines at some angles and these angles, and add their loads. Returns the pretension
 * below which at least one of the states is slack. `is_plain` and `is_shared` are constants. */
INLINE Lanes prepare_lines(Angle *at, double *angle, LoadExtremes *loads,
                           const ExtremesCall *call, const Batch *b, const Drive *d, long first,
                           long angles, int is_plain, int is_shared) {
    Lanes limit = all_lanes(-INFINITY);
    Lanes in[IN_gravity_moment];
    long angle_step = call->angle->step[call->walk.axes - 1];
    for (long i = 0; i < angles; i++) {
        angle[i] = *(const double *)(call->angle->value + (first + i) * angle_step);
        load_angle(b, in, first + i, is_shared);
        load_at_angle(b, in, first + i, is_shared, IN_pressed, IN_gravity_moment);
        at[i].lines = lines_at(d, in, is_plain);
        at[i].pressed = in[IN_pressed];
        at[i].spring_room = in[IN_spring_room];
        const Lines *l = &at[i].lines;
        limit = larger(l->limit, limit);
        loads->required = larger(l->required, loads->required);
        Lanes low = smaller(l->torque, loads->low_torque);
        Lanes high = larger(l->torque, loads->high_torque);
        loads->low_torque = pick(l->able, low, loads->low_torque);
        loads->high_torque = pick(l->able, high, loads->high_torque);
        loads->no_equilibrium += pick(l->able, all_lanes(0.0), all_lanes(1.0));
    }
    return limit;
}

/* Accumulators of a batch at one pretension. */
typedef struct {
    const Batch *batch;
    const long *step; /* of each array from one pretension to the next, bytes */
    long place;       /* of the pretension */
} Accumulators;

/* Smaller or larger of two numbers, or their sum. */
typedef Lanes Combine(Lanes, Lanes);

/* Combine values with an accumulator, one of EXTREMES. `combine` is a constant. */
INLINE void accumulate(const Accumulators *to, int extreme, Combine *combine, Lanes values) {
    const Batch *b = to->batch;
    int result = INPUT_COUNT + extreme;
    long offset = to->place * to->step[result];
    Lanes combined = values;
    if (b->is_contiguous) {
        memcpy(&combined, b->value[result][0] + offset, sizeof combined);
        combined = combine(values, combined);
        memcpy(b->value[result][0] + offset, &combined, sizeof combined);
        return;
    }
    for (long lane = 0; lane < b->count; lane++) {
        combined[lane] = *(double *)(b->value[result][lane] + offset);
    }
    combined = combine(values, combined);
    for (long lane = 0; lane < b->count; lane++) {
        *(double *)(b->value[result][lane] + offset) = combined[lane];
    }
}

/* Add the extremes at one pretension, over `states` states of each design, to the accumulators of a
 * batch. */
INLINE void store_extremes(const Accumulators *to, const Extremes *e, const ScaledExtremes *scaled,
                           const LoadExtremes *loads, Mask unilateral, long states) {
    Mask any_taut = (double)states > e->slack + loads->no_equilibrium;
    Lanes no_slack = pick(unilateral & any_taut, all_lanes(0.0), all_lanes(-INFINITY));

    accumulate(to, EXTREME_min_flexor_tension, smaller, scaled->low_x);
    accumulate(to, EXTREME_min_extensor_tension, smaller, scaled->low_y);
    accumulate(to, EXTREME_max_tension, larger, scaled->high);
    accumulate(to, EXTREME_max_strap_tension, larger, e->high_strap);
    accumulate(to, EXTREME_max_spring_extension, larger, scaled->extension);
    accumulate(to, EXTREME_max_slack, larger, larger(no_slack, e->longest_slack));
    accumulate(to, EXTREME_lowest_elbow_torque, smaller, loads->low_torque);
    accumulate(to, EXTREME_highest_elbow_torque, larger, loads->high_torque);
    accumulate(to, EXTREME_lowest_motor_torque, smaller, e->low_motor);
    accumulate(to, EXTREME_highest_motor_torque, larger, e->high_motor);
    accumulate(to, EXTREME_min_elbow_stiffness, smaller, e->stiffness);
    accumulate(to, EXTREME_min_room, smaller, e->low_room);
    accumulate(to, EXTREME_first_slack_angle, smaller, e->first_slack);
    accumulate(to, EXTREME_required_pretension, larger, loads->required);
    accumulate(to, EXTREME_margin, smaller, scaled->margin);
    accumulate(to, EXTREME_slack, sum, e->slack);
    accumulate(to, EXTREME_unstable, sum, e->unstable);
    accumulate(to, EXTREME_no_equilibrium, sum, loads->no_equilibrium);
}

/* Load the pretension of one side, N, which is `place` pretensions after the first. */
INLINE Lanes load_pretension(const Batch *b, const long *step, int input, long place) {
    return load_input(b, input, place * step[input]);
}

/* Fold all angles of a batch whose drives are plain, in one direction and at `count` pretensions
 * from `first` on. `step` has the bytes from one pretension to the next in each array. */
static void fold_plain(const ExtremesCall *call, const Batch *b, const long *step, const Lanes *in,
                       const Drive *d, long first, long count) {
    Angle at_angles[ANGLES_AT_ONCE];
    double angle[ANGLES_AT_ONCE];
    Extremes extremes[PRETENSIONS_AT_ONCE];
    Lanes pretension[PRETENSIONS_AT_ONCE];
    Lanes lower_side[PRETENSIONS_AT_ONCE];
    LoadExtremes loads = no_load_extremes();
    long states = call->walk.length[call->walk.axes - 1];
    for (long p = 0; p < count; p++) {
        Lanes x = load_pretension(b, step, IN_flexor_pretension, first + p);
        Lanes y = load_pretension(b, step, IN_extensor_pretension, first + p);
        extremes[p] = no_extremes();
        pretension[p] = common_pretension(d, x, y);
        lower_side[p] = smaller(x, y);
    }
    for (long from = 0; from < states; from += ANGLES_AT_ONCE) {
        long angles = states - from < ANGLES_AT_ONCE ? states - from : ANGLES_AT_ONCE;
        Lanes limit;
        if (b->shares_angles) {
            limit = prepare_lines(at_angles, angle, &loads, call, b, d, from, angles, 1, 1);
        } else {
            limit = prepare_lines(at_angles, angle, &loads, call, b, d, from, angles, 1, 0);
        }
        for (long p = 0; p < count; p++) {
            Lanes at = pretension[p];
            if (any(at < limit)) {
                extremes[p] = add_angles(extremes[p], at_angles, angle, angles, d, at, 1);
            } else {
                extremes[p] = add_angles(extremes[p], at_angles, angle, angles, d, at, 0);
            }
        }
    }
    for (long p = 0; p < count; p++) {
        Accumulators to = {b, step, first + p};
        const Extremes *e = &extremes[p];
        ScaledExtremes scaled = no_scaled_extremes();
        Lanes margin = smaller(lower_side[p], pretension[p] - loads.required);
        add_scaled(&scaled, e->low_x, e->high_x, e->low_y, e->high_y, in, margin);
        store_extremes(&to, e, &scaled, &loads, d->unilateral, states);
    }
}

/* Fold a batch as `fold_plain` does, each angle with drives of its own, because tension scales
 * differently along a sheath at each. */
static void fold_each_angle(const ExtremesCall *call, const Batch *b, const long *step,
                            const Drive *d, long first, long count) {
    Extremes extremes[PRETENSIONS_AT_ONCE];
    ScaledExtremes scaled[PRETENSIONS_AT_ONCE];
    LoadExtremes loads = no_load_extremes();
    Lanes in[INPUT_COUNT];
    long states = call->walk.length[call->walk.axes - 1];
    for (long p = 0; p < count; p++) {
        extremes[p] = no_extremes();
        scaled[p] = no_scaled_extremes();
    }
    for (long i = 0; i < states; i++) {
        Angle here;
        double angle;
        Drive own = load_drive(b, in, i);
        Lanes limit = prepare_lines(&here, &angle, &loads, call, b, &own, i, 1, 0, 0);
        Lanes required = larger(here.lines.required, all_lanes(-INFINITY));
        for (long p = 0; p < count; p++) {
            Lanes x = load_pretension(b, step, IN_flexor_pretension, first + p);
            Lanes y = load_pretension(b, step, IN_extensor_pretension, first + p);
            Lanes at = common_pretension(&own, x, y);
            Lanes margin = smaller(smaller(x, y), at - required);
            int any_slack = any(at < limit);
            State s = add_state(&extremes[p], &here, &own, all_lanes(angle), at, any_slack, 0);
            add_scaled(&scaled[p], s.x, s.x, s.y, s.y, in, margin);
        }
    }
    for (long p = 0; p < count; p++) {
        Accumulators to = {b, step, first + p};
        store_extremes(&to, &extremes[p], &scaled[p], &loads, d->unilateral, states);
    }
}

/* Pretensions that are folded for each design of a walk, the array's values `step` bytes apart. */
typedef struct {
    const ExtremesCall *call;
    const long *step;
    long pretensions;
} PretensionRun;

/* Fold a batch in one direction at all pretensions of a run. */
INLINE void fold_run(void *context, const Batch *b, const Lanes *in, const Drive *d,
                     long direction) {
    const PretensionRun *run = context;
    (void)direction;
    for (long first = 0; first < run->pretensions; first += PRETENSIONS_AT_ONCE) {
        long rest = run->pretensions - first;
        long count = rest < PRETENSIONS_AT_ONCE ? rest : PRETENSIONS_AT_ONCE;
        if (b->is_plain) {
            fold_plain(run->call, b, run->step, in, d, first, count);
        } else {
            fold_each_angle(run->call, b, run->step, d, first, count);
        }
    }
}

/* Fold all designs of a walk at `pretensions` pretensions each. */
static void fold_designs(ExtremesCall *call, const long *step, long pretensions) {
    PretensionRun run = {call, step, pretensions};
    for_each_batch(&call->walk, call->arrays, INPUT_COUNT, EXTREME_COUNT, fold_run, &run);
}

/* True if no input but the pretensions changes along an axis. */
static int is_pretension_axis(const ExtremesCall *call, long axis) {
    for (int i = 0; i < INPUT_COUNT; i++) {
        int is_pretension = i == IN_flexor_pretension || i == IN_extensor_pretension;
        if (!is_pretension && call->arrays[i].step[axis]) {
            return 0;
        }
    }
    return 1;
}

/* Longest axis of designs on which only pretension depends; -1 if there is none. */
static long pretension_axis(const ExtremesCall *call) {
    const long *length = call->walk.length;
    long longest = -1;
    for (long axis = 0; axis < call->walk.axes - 2; axis++) {
        if (is_pretension_axis(call, axis) && (longest < 0 || length[axis] > length[longest])) {
            longest = axis;
        }
    }
    return longest;
}

/* Find the extremes of all designs. */
static void find_extremes(ExtremesCall *call) {
    long step[INPUT_COUNT + EXTREME_COUNT] = {0};
    long axis = pretension_axis(call);
    if (axis < 0) {
        fold_designs(call, step, 1);
        return;
    }
    long pretensions = call->walk.length[axis];
    long other_designs = 1;
    for (long other = 0; other < call->walk.axes - 2; other++) {
        if (other != axis) {
            other_designs *= call->walk.length[other];
        }
    }
    for (int i = 0; i < INPUT_COUNT + EXTREME_COUNT; i++) {
        step[i] = call->arrays[i].step[axis];
    }
    /* Along this axis the walk goes from run to run, each of them of as many pretensions. */
    long runs = other_designs < LANES ? LANES / other_designs : 1;
    long done = 0;
    while (done < pretensions) {
        long rest = pretensions - done;
        runs = runs < rest ? runs : rest;
        long run_length = rest / runs;
        call->walk.length[axis] = runs;
        for (int i = 0; i < INPUT_COUNT + EXTREME_COUNT; i++) {
            call->arrays[i].step[axis] = run_length * step[i];
        }
        fold_designs(call, step, run_length);
        for (int i = 0; i < INPUT_COUNT + EXTREME_COUNT; i++) {
            call->arrays[i].value += runs * run_length * step[i];
        }
        done += runs * run_length;
    }
}
