/* Windows of pretension in which designs keep every bound in all their states: a fold over
 * `lines_at`, as `model/window.py` has it.
 *
 * This code knows no limit by name. Bounds are on both tensions, the elbow stiffness, and forms of
 * all three; over v = F - F* each of these is a line, base + gain v. So a bound sets an end of the
 * window, the lower or the upper one by the sign of the gain; if the gain is zero, pretension
 * changes nothing.
 */

#include "batch.h"

#define NEVER 1e300 /* beyond any number of a state */

/* Tightest ends over some states of each design, the states that set them, and the first state that
 * keeps its bounds at no pretension. */
typedef struct {
    Lanes low;
    Lanes high;
    Lanes low_state;
    Lanes high_state;
    Lanes blocked;
} Ends;

/* Ends of one state of each design, in v; blocked where no pretension keeps its bounds. */
typedef struct {
    Lanes low;
    Lanes high;
    Mask blocked;
} StateEnds;

/* Inputs after INPUT_COUNT, bounds and shares of forms, that matter for any of some designs, and
 * those that change from angle to angle. */
typedef struct {
    int is_active[LIMITED_COUNT];
    int moving[LIMITED_COUNT];
    int moving_count;
} ActiveBounds;

/* Apply a bound to a line: a lower one if `is_lower`, which is a constant, else an upper one. */
INLINE void apply_bound(StateEnds *ends, Lanes base, Lanes gain, Lanes bound, int is_lower) {
    Lanes end = (bound - base) / gain;
    Lanes none = all_lanes(INFINITY);
    Lanes missing = is_lower ? bound - base : base - bound;
    Mask rises = gain > 0.0;
    Mask falls = gain < 0.0;
    ends->low = larger(pick(is_lower ? rises : falls, end, -none), ends->low);
    ends->high = smaller(pick(is_lower ? falls : rises, end, none), ends->high);
    ends->blocked |= (gain == 0.0) & (missing > TOLERANCE * magnitude(bound));
}

/* Apply the bounds on both tensions, which rise with pretension. */
INLINE void bound_tensions(StateEnds *ends, const Lines *l, const Lanes *in, const int *is_active) {
    if (is_active[IN_flexor_least]) {
        ends->low = larger((in[IN_flexor_least] - l->floor_x) / l->gain_x, ends->low);
    }
    if (is_active[IN_extensor_least]) {
        ends->low = larger((in[IN_extensor_least] - l->floor_y) / l->gain_y, ends->low);
    }
    if (is_active[IN_flexor_most]) {
        ends->high = smaller((in[IN_flexor_most] - l->floor_x) / l->gain_x, ends->high);
    }
    if (is_active[IN_extensor_most]) {
        ends->high = smaller((in[IN_extensor_most] - l->floor_y) / l->gain_y, ends->high);
    }
}

/* Add a state of each design, the one of number `state`, with its bounds. */
INLINE void add_lines(Ends *ends, const Lines *l, const Lanes *in, const ActiveBounds *active,
                      int forms, const Drive *d, Lanes state, int is_plain) {
    const int *is_active = active->is_active;
    StateEnds own = {all_lanes(0.0), all_lanes(INFINITY), ~l->able};
    bound_tensions(&own, l, in, is_active);

    Lanes stiffness = l->stiffness - l->floor_x * l->slope_x;
    Lanes stiffness_gain = -(l->gain_x * l->slope_x);
    if (!is_plain) {
        stiffness += l->floor_y * d->slope_y;
        stiffness_gain += l->gain_y * d->slope_y;
    }
    if (is_active[IN_stiffness_least]) {
        apply_bound(&own, stiffness, stiffness_gain, in[IN_stiffness_least], 1);
    }
    if (is_active[IN_stiffness_most]) {
        apply_bound(&own, stiffness, stiffness_gain, in[IN_stiffness_most], 0);
    }

    for (int i = 0; i < forms; i++) {
        const Lanes *form = in + FIRST_FORM + FORM_SIZE * i;
        const int *is_form_active = is_active + FIRST_FORM + FORM_SIZE * i;
        Lanes base = form[FORM_flexor] * l->floor_x + form[FORM_extensor] * l->floor_y;
        Lanes gain = form[FORM_flexor] * l->gain_x + form[FORM_extensor] * l->gain_y;
        if (is_form_active[FORM_stiffness]) {
            base += form[FORM_stiffness] * stiffness;
            gain += form[FORM_stiffness] * stiffness_gain;
        }
        if (is_form_active[FORM_least]) {
            apply_bound(&own, base, gain, form[FORM_least], 1);
        }
        if (is_form_active[FORM_most]) {
            apply_bound(&own, base, gain, form[FORM_most], 0);
        }
    }

    Lanes low = l->required + own.low;
    Lanes high = l->required + own.high;
    ends->low_state = pick(low > ends->low, state, ends->low_state);
    ends->low = larger(low, ends->low);
    ends->high_state = pick(high < ends->high, state, ends->high_state);
    ends->high = smaller(high, ends->high);
    ends->blocked = pick(own.blocked, smaller(state, ends->blocked), ends->blocked);
}

/* Keep the tighter of new and accumulated ends, and its state; of equal finite ends the first
 * state. `sign` is 1 for low ends and -1 for high ones. */
INLINE void store_ends(char *const *end_values, char *const *state_values, long count, Lanes ends,
                       Lanes states, double sign) {
    for (long lane = 0; lane < count; lane++) {
        double *end = (double *)end_values[lane];
        double *state = (double *)state_values[lane];
        double new_end = sign * ends[lane];
        double old_end = sign * *end;
        int is_tighter = new_end > old_end;
        int is_finite = new_end < NEVER && new_end > -NEVER;
        int is_earlier = states[lane] < *state;
        if (is_tighter || (new_end == old_end && is_finite && is_earlier)) {
            *end = ends[lane];
            *state = states[lane];
        }
    }
}

/* Find out which bounds and shares matter for a batch. */
INLINE ActiveBounds active_bounds(const WindowCall *call, const Lanes *in, int inputs) {
    ActiveBounds active;
    active.moving_count = 0;
    for (int i = INPUT_COUNT; i < inputs; i++) {
        int is_share = i >= FIRST_FORM && (i - FIRST_FORM) % FORM_SIZE == FORM_stiffness;
        Mask matters = is_share ? in[i] != 0.0 : magnitude(in[i]) < INFINITY;
        active.is_active[i] = any(matters);
        if (call->arrays[i].step[call->walk.axes - 1]) {
            active.is_active[i] = 1;
            active.moving[active.moving_count] = i;
            active.moving_count++;
        }
    }
    return active;
}

/* Fold all angles of a batch in one direction; `first` is the number of its first state.
 * `has_moving`, `is_plain` and `is_shared` (`load_angle`) are constants, and so is `forms` if it is
 * zero. */
INLINE void fold_angles(Ends *ends, const WindowCall *call, const Batch *b, const Lanes *in,
                        const Drive *d, const ActiveBounds *active, double first, int forms,
                        int has_moving, int is_plain, int is_shared) {
    long axis = call->walk.axes - 1;
    Lanes bounds[LIMITED_COUNT];
    Lanes angle_inputs[IN_gravity_moment];
    Lanes all_inputs[INPUT_COUNT];
    if (has_moving) {
        for (int i = INPUT_COUNT; i < FIRST_FORM + FORM_SIZE * forms; i++) {
            bounds[i] = in[i];
        }
    }
    for (long angle = 0; angle < call->walk.length[axis]; angle++) {
        Lanes state = all_lanes(first + (double)angle);
        if (has_moving) {
            for (int k = 0; k < active->moving_count; k++) {
                int i = active->moving[k];
                bounds[i] = load_input(b, i, angle * call->arrays[i].step[axis]);
            }
        }
        const Lanes *current = has_moving ? bounds : in;
        if (is_plain) {
            load_angle(b, angle_inputs, angle, is_shared);
            Lines l = lines_at(d, angle_inputs, 1);
            add_lines(ends, &l, current, active, forms, d, state, 1);
        } else {
            Drive own = load_drive(b, all_inputs, angle);
            Lines l = lines_at(&own, all_inputs, 0);
            add_lines(ends, &l, current, active, forms, &own, state, 0);
        }
    }
}

/* Fold a batch in one direction into its windows. */
INLINE void fold_windows(void *context, const Batch *b, const Lanes *in, const Drive *d,
                         long direction) {
    const WindowCall *call = context;
    int forms = (int)call->forms;
    int inputs = FIRST_FORM + FORM_SIZE * forms;
    double first = (double)(direction * call->total + call->first);
    ActiveBounds active = active_bounds(call, in, inputs);
    Ends ends = {
        .low = all_lanes(-INFINITY),
        .high = all_lanes(INFINITY),
        .low_state = all_lanes(-1.0),
        .high_state = all_lanes(-1.0),
        .blocked = all_lanes(INFINITY),
    };
    if (!b->is_plain) {
        fold_angles(&ends, call, b, in, d, &active, first, forms, 1, 0, 0);
    } else if (active.moving_count) {
        fold_angles(&ends, call, b, in, d, &active, first, forms, 1, 1, 0);
    } else if (!b->shares_angles) {
        fold_angles(&ends, call, b, in, d, &active, first, forms, 0, 1, 0);
    } else if (forms) {
        fold_angles(&ends, call, b, in, d, &active, first, forms, 0, 1, 1);
    } else {
        fold_angles(&ends, call, b, in, d, &active, first, 0, 0, 1, 1);
    }
    char *const(*window)[LANES] = b->value + inputs;
    store_ends(window[END_low], window[END_low_state], b->count, ends.low, ends.low_state, 1.0);
    store_ends(window[END_high], window[END_high_state], b->count, ends.high, ends.high_state,
               -1.0);
    for (long lane = 0; lane < b->count; lane++) {
        double *blocked = (double *)window[END_blocked][lane];
        if (ends.blocked[lane] < *blocked) {
            *blocked = ends.blocked[lane];
        }
    }
}

/* Find the windows of all designs. */
static void find_windows(WindowCall *call) {
    int inputs = FIRST_FORM + FORM_SIZE * (int)call->forms;
    for_each_batch(&call->walk, call->arrays, inputs, END_COUNT, fold_windows, call);
}
