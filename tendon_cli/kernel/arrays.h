/* Arrays that Python passes, as `native.py` describes them, and a walk over their axes: those
 * of designs, then direction, then elbow angle. */

#ifndef TENDON_ARRAYS_H
#define TENDON_ARRAYS_H

/* 1 if the compiler can make code for other processors than its own, so that the best is chosen
 * when this runs. */
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__)
#define SEVERAL_PROCESSORS 1
#else
#define SEVERAL_PROCESSORS 0
#endif

#define MOST_AXES 64

/* Inputs of a state, by the names that Python uses; SI units. `moment_arm` may be negative,
 * `pulling_arm` is then not a number; `unilateral` is one or zero, and so is `pressed`, where the
 * extensor's strap presses. The inputs before
 * `gravity_moment` differ from angle to angle; the others do not in a plain sheath and joint. Lines
 * of states take none of `pressed` and `spring_room`. Those with `resting` in their name are taken
 * in the posture in which the pretension is set. */
#define GIVEN(X)                                                                                   \
    X(moment_arm)                                                                                  \
    X(pulling_arm)                                                                                 \
    X(flexor_slope)                                                                                \
    X(flexor_travel)                                                                               \
    X(extensor_travel)                                                                             \
    X(sine)                                                                                        \
    X(cosine)                                                                                      \
    X(other_torque)                                                                                \
    X(other_slope)                                                                                 \
    X(pressed)                                                                                     \
    X(spring_room)                                                                                 \
    X(gravity_moment)                                                                              \
    X(extensor_arm)                                                                                \
    X(extensor_slope)                                                                              \
    X(flexor_radius)                                                                               \
    X(ratio)                                                                                       \
    X(flexor_capstan)                                                                              \
    X(extensor_capstan)                                                                            \
    X(flexor_tendon)                                                                               \
    X(extensor_tendon)                                                                             \
    X(flexor_spring)                                                                               \
    X(extensor_spring)                                                                             \
    X(flexor_anchor)                                                                               \
    X(extensor_anchor)                                                                             \
    X(flexor_tendon_resting)                                                                       \
    X(extensor_tendon_resting)                                                                     \
    X(flexor_spring_resting)                                                                       \
    X(extensor_spring_resting)                                                                     \
    X(flexor_pretension)                                                                           \
    X(extensor_pretension)                                                                         \
    X(unilateral)

/* Results of a state: columns of the states table, by name. NumPy computes the columns that are
 * neither named here nor the status. */
#define RESULTS(X)                                                                                 \
    X(flexor_tension_proximal)                                                                     \
    X(flexor_tension_distal)                                                                       \
    X(extensor_tension_proximal)                                                                   \
    X(extensor_tension_distal)                                                                     \
    X(flexor_tendon_stretch)                                                                       \
    X(extensor_tendon_stretch)                                                                     \
    X(flexor_spring_stretch)                                                                       \
    X(extensor_spring_stretch)                                                                     \
    X(flexor_slack)                                                                                \
    X(extensor_slack)                                                                              \
    X(elbow_torque)                                                                                \
    X(motor_torque)                                                                                \
    X(spool_angle)                                                                                 \
    X(elbow_stiffness)                                                                             \
    X(flexor_moment_arm)                                                                           \
    X(flexor_travel)                                                                               \
    X(extensor_travel)

/* Smallest values, largest values and counts of a design over its states. */
#define EXTREMES(X)                                                                                \
    X(min_flexor_tension)                                                                          \
    X(min_extensor_tension)                                                                        \
    X(max_tension)                                                                                 \
    X(max_strap_tension)                                                                           \
    X(max_spring_extension)                                                                        \
    X(max_slack)                                                                                   \
    X(lowest_elbow_torque)                                                                         \
    X(highest_elbow_torque)                                                                        \
    X(lowest_motor_torque)                                                                         \
    X(highest_motor_torque)                                                                        \
    X(min_elbow_stiffness)                                                                         \
    X(min_room)                                                                                    \
    X(first_slack_angle)                                                                           \
    X(required_pretension)                                                                         \
    X(margin)                                                                                      \
    X(slack)                                                                                       \
    X(unstable)                                                                                    \
    X(no_equilibrium)

/* Bounds on both distal tensions and on the elbow stiffness; infinite if there is no limit. */
#define BOUNDS(X)                                                                                  \
    X(flexor_least)                                                                                \
    X(flexor_most)                                                                                 \
    X(extensor_least)                                                                              \
    X(extensor_most)                                                                               \
    X(stiffness_least)                                                                             \
    X(stiffness_most)

/* A form, flexor x + extensor y + stiffness k, is bounded by [least, most]. */
#define FORM(X)                                                                                    \
    X(flexor)                                                                                      \
    X(extensor)                                                                                    \
    X(stiffness)                                                                                   \
    X(least)                                                                                       \
    X(most)
#define MOST_FORMS 8

/* Window of pretensions in which a design keeps every bound, the states that limit it at both ends,
 * and the first state that keeps them at no pretension. */
#define WINDOW(X)                                                                                  \
    X(low)                                                                                         \
    X(high)                                                                                        \
    X(low_state)                                                                                   \
    X(high_state)                                                                                  \
    X(blocked)

/* Indices of arrays: the inputs, then bounds and forms if a fold has them, then its results. */
#define IN_INDEX(name) IN_##name,
#define RESULT_INDEX(name) RESULT_##name,
#define EXTREME_INDEX(name) EXTREME_##name,
#define END_INDEX(name) END_##name,
#define FORM_INDEX(name) FORM_##name,
enum { FORM(FORM_INDEX) FORM_SIZE };
enum { GIVEN(IN_INDEX) INPUT_COUNT, LAST_INPUT = INPUT_COUNT - 1, BOUNDS(IN_INDEX) FIRST_FORM };
enum { LIMITED_COUNT = FIRST_FORM + FORM_SIZE * MOST_FORMS };
enum { WINDOW(END_INDEX) END_COUNT };
enum { RESULTS(RESULT_INDEX) RESULT_COUNT };
enum { EXTREMES(EXTREME_INDEX) EXTREME_COUNT };

/* An array over all axes: its value at the current place of the walk, and its steps in bytes, zero
 * along axes over which it is broadcast. */
typedef struct {
    char *value;
    long step[MOST_AXES];
} Array;

/* Lengths of all axes, and the current place along each but the last, the angle. */
typedef struct {
    long axes;
    long length[MOST_AXES];
    long index[MOST_AXES];
} Walk;

/* Go to the next line of angles. Of the axes before the angle, the last is the fastest. Returns the
 * axis along which the walk went on, all faster ones being back at their start; -1 after the last
 * line, then all are. */
static inline long next_line(Walk *walk) {
    for (long axis = walk->axes - 2; axis >= 0; axis--) {
        if (walk->length[axis] == 1) {
            continue;
        }
        walk->index[axis]++;
        if (walk->index[axis] < walk->length[axis]) {
            return axis;
        }
        walk->index[axis] = 0;
    }
    return -1;
}

/* Return the bytes by which an array moves when a walk goes on along an axis. */
static inline long move_along(const Array *array, const Walk *walk, long axis) {
    long move = array->step[axis];
    for (long faster = axis + 1; faster <= walk->axes - 2; faster++) {
        move -= (walk->length[faster] - 1) * array->step[faster];
    }
    return move;
}

/* Go from the first line of angles to the line of a number. */
static inline void go_to_line(Walk *walk, Array *arrays, int count, long number) {
    for (long axis = walk->axes - 2; axis >= 0; axis--) {
        walk->index[axis] = number % walk->length[axis];
        number /= walk->length[axis];
        for (int i = 0; i < count; i++) {
            arrays[i].value += walk->index[axis] * arrays[i].step[axis];
        }
    }
}

/* Target of a column that is copied as it is: rows one after the other, `bytes` long each. */
typedef struct {
    char *target;
    long bytes;
} Key;

/* Call that writes rows `first` to `first + count` of the states table.
 *
 * `arrays` are the inputs, then the sources of the keys. `column` has a target for each of RESULTS,
 * or null where the column is not wanted; `has_nan` becomes true for each column with a value that
 * is not a number. */
typedef struct {
    Walk walk;
    Array *arrays;
    double **column;
    int *has_nan;
    signed char *status;
    Key *key;
    long keys;
    long first;
    long count;
} RowsCall;

/* Call that finds the extremes of designs. `arrays` are the inputs, then an accumulator for each of
 * EXTREMES, which has no step along direction and angle. */
typedef struct {
    Walk walk;
    Array *arrays;
    Array *angle;
} ExtremesCall;

/* Call that finds the windows of designs. `arrays` are the inputs, the bounds, the forms, then an
 * accumulator for each of WINDOW. The angles are those from `first` on, out of `total` in each
 * direction. */
typedef struct {
    Walk walk;
    Array *arrays;
    long forms;
    long first;
    long total;
} WindowCall;

#endif
