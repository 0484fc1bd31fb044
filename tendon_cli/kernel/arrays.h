/* What Python hands over, as `native.py` has it: arrays over the axes of designs, then direction, then elbow angle, and
 * a walk over them. */

#ifndef TENDON_ARRAYS_H
#define TENDON_ARRAYS_H

/* Whether there is a choice of processors when this runs: the compiler can make code for others than its own. */
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__)
#define CHOICE 1
#else
#define CHOICE 0
#endif

#define MOST_AXES 64

/* What a state depends on, by the names that Python uses; SI units. `moment_arm` may be negative, `pulling_arm` is then
 * not a number; `unilateral` is one or zero. The first ones up to `gravity_moment` differ from angle to angle; what
 * follows does not in a plain sheath and joint. `resting` is where the pretension is set. */
#define GIVEN(X)                                                                                                       \
    X(moment_arm) X(pulling_arm) X(flexor_slope) X(flexor_travel) X(extensor_travel) X(sine) X(cosine)                 \
    X(other_torque) X(other_slope) X(gravity_moment) X(extensor_arm) X(extensor_slope) X(flexor_radius) X(ratio)       \
    X(flexor_capstan) X(extensor_capstan) X(flexor_tendon) X(extensor_tendon) X(flexor_spring) X(extensor_spring)      \
    X(flexor_anchor) X(extensor_anchor) X(flexor_tendon_resting) X(extensor_tendon_resting)                            \
    X(flexor_spring_resting) X(extensor_spring_resting) X(flexor_pretension) X(extensor_pretension) X(unilateral)

/* Results of a state: columns of `states`, by name; what Python has besides these and the status is left to NumPy. */
#define RESULTS(X)                                                                                                     \
    X(flexor_tension_proximal) X(flexor_tension_distal) X(extensor_tension_proximal) X(extensor_tension_distal)        \
    X(flexor_tendon_stretch) X(extensor_tendon_stretch) X(flexor_spring_stretch) X(extensor_spring_stretch)            \
    X(flexor_slack) X(extensor_slack) X(elbow_torque) X(motor_torque) X(spool_angle) X(elbow_stiffness)                \
    X(flexor_moment_arm) X(flexor_travel) X(extensor_travel)

/* What a design comes to over its states: smallest, largest, counted. */
#define EXTREMES(X)                                                                                                    \
    X(min_flexor_tension) X(min_extensor_tension) X(max_tension) X(max_extensor_distal) X(max_spring_extension)        \
    X(max_slack) X(lowest_elbow_torque) X(highest_elbow_torque) X(lowest_motor_torque) X(highest_motor_torque)         \
    X(min_elbow_stiffness) X(first_slack_angle) X(required_pretension) X(margin) X(slack) X(unstable) X(no_equilibrium)

/* What both distal tensions and the elbow stiffness are held to; infinite where nothing is asked. */
#define BOUNDS(X)                                                                                                      \
    X(flexor_least) X(flexor_most) X(extensor_least) X(extensor_most) X(stiffness_least) X(stiffness_most)

/* A form of several of them, flexor x + extensor y + stiffness k, is held to [least, most]; so many there may be. */
#define FORM(X) X(flexor) X(extensor) X(stiffness) X(least) X(most)
#define MOST_FORMS 8

/* Between which pretensions a design keeps these, the states that bind, and the first that no pretension could help. */
#define WINDOW(X) X(low) X(high) X(low_state) X(high_state) X(blocked)

#define IN_ENUM(name) IN_##name,
#define OF_ENUM(name) OF_##name,
#define AT_ENUM(name) AT_##name,
#define END_ENUM(name) END_##name,
#define FORM_ENUM(name) FORM_##name,
enum { FORM(FORM_ENUM) PER_FORM };
enum { GIVEN(IN_ENUM) INPUTS, BEFORE_BOUNDS = INPUTS - 1, BOUNDS(IN_ENUM) BOUNDED };
enum { LIMITED = BOUNDED + PER_FORM * MOST_FORMS };
enum { WINDOW(END_ENUM) ENDS };
enum { RESULTS(OF_ENUM) COLUMNS };
enum { EXTREMES(AT_ENUM) ACCUMULATORS };

/* An array over all axes: where it is now, and its steps in bytes; none where it is broadcast. */
typedef struct {
    char *at;
    long step[MOST_AXES];
} Array;

/* The lengths of all axes, and where the walk is on each but the last, the angle. */
typedef struct {
    long axes, length[MOST_AXES], index[MOST_AXES];
} Walk;

/* To the next line of angles, the last axis but the angle fastest; moves along the arrays that are named. Returns zero
 * after the last, and is at the first again. */
static inline int next_line(Walk *walk, Array *arrays, const int *named, int count) {
    for (long axis = walk->axes - 2; axis >= 0; axis--) {
        if (walk->length[axis] == 1) continue;
        long move = ++walk->index[axis] < walk->length[axis] ? 1 : 1 - walk->length[axis];
        for (int k = 0; k < count; k++) arrays[named[k]].at += move * arrays[named[k]].step[axis];
        if (move == 1) return 1;
        walk->index[axis] = 0;
    }
    return 0;
}

/* To a line by its number, from the first. */
static inline void to_line(Walk *walk, Array *arrays, int count, long number) {
    for (long axis = walk->axes - 2; axis >= 0; axis--) {
        walk->index[axis] = number % walk->length[axis], number /= walk->length[axis];
        for (int i = 0; i < count; i++) arrays[i].at += walk->index[axis] * arrays[i].step[axis];
    }
}

/* A column that is copied as it is, of `bytes` a value: `from` is over all axes, `to` a row after the other. */
typedef struct {
    char *to;
    long bytes;
} Key;

/* Rows of states: `columns` in the order of RESULTS, then the keys' sources; a column that nobody wants is null.
 * `no_number` becomes true of a column in which something is not a number. */
typedef struct {
    Walk walk;
    Array *arrays;
    double **column;
    int *no_number;
    signed char *status;
    Key *key;
    long keys, first, count;
} Rows;

/* Extremes over states: the inputs, then an accumulator for each of EXTREMES, which has no step along direction and
 * angle. */
typedef struct {
    Walk walk;
    Array *arrays, *angle;
} Extremes;

/* Ends of windows over states: the inputs, the bounds, the forms, then an accumulator for each of WINDOW. The angles are
 * those from `first` on of `total` in each direction. */
typedef struct {
    Walk walk;
    Array *arrays;
    long forms, first, total;
} Window;

#endif
