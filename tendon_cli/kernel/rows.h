/* Rows of the states table: each state at its pretension, its results written straight into the
 * columns. */

#include "state.h"

/* Load inputs `first` to `stop` at `count` angles from `angle` on, an angle a lane; the remaining
 * lanes repeat the first. */
INLINE void load_angles(Lanes *in, const Array *arrays, int first, int stop, long axis, long angle,
                        long count) {
    for (int i = first; i < stop; i++) {
        long step = arrays[i].step[axis];
        const char *source = arrays[i].value + step * angle;
        in[i] = all_lanes(*(const double *)source);
        if (step) {
            memcpy(in + i, source, count >= LANES ? sizeof *in : 8 * (unsigned long)count);
        }
    }
}

/* Elongation since the pretension was set, m, from the compliances (m/N) and tensions (N) now and
 * then. */
INLINE Lanes stretch(Lanes now, Lanes resting, Lanes tension, Lanes pretension) {
    return now * (tension - pretension) + (now - resting) * pretension;
}

/* Compute all result columns of some states, in the order of RESULTS, and return their status. */
INLINE Mask results_of(Lanes *r, const Lanes *in, const Drive *d, int is_plain) {
    Lines l = lines_at(d, in, is_plain);
    Lanes start_x = in[IN_flexor_pretension];
    Lanes start_y = in[IN_extensor_pretension];
    Lanes pretension = common_pretension(d, start_x, start_y);
    State s = state_at(&l, d, pretension, is_plain);
    Lanes nan = all_lanes(NAN);

    r[RESULT_flexor_tension_proximal] = s.x / in[IN_flexor_capstan];
    r[RESULT_flexor_tension_distal] = s.x;
    r[RESULT_extensor_tension_proximal] = s.y / in[IN_extensor_capstan];
    r[RESULT_extensor_tension_distal] = s.y;

    r[RESULT_flexor_tendon_stretch] =
        stretch(in[IN_flexor_tendon], in[IN_flexor_tendon_resting], s.x, start_x);
    r[RESULT_extensor_tendon_stretch] =
        stretch(in[IN_extensor_tendon], in[IN_extensor_tendon_resting], s.y, start_y);
    r[RESULT_flexor_spring_stretch] =
        stretch(in[IN_flexor_spring], in[IN_flexor_spring_resting], s.x, start_x);
    r[RESULT_extensor_spring_stretch] =
        stretch(in[IN_extensor_spring], in[IN_extensor_spring_resting], s.y, start_y);

    Mask no_flexor = pretension < l.flexor_limit;
    Mask no_extensor = pretension < l.extensor_limit;
    Mask both = no_flexor & no_extensor;
    Lanes taut_slack = pick(both | ~l.able, nan, d->taut_slack);
    Lanes slack_length = s.path * l.per_path;
    r[RESULT_flexor_slack] = pick(no_flexor & ~no_extensor, slack_length, taut_slack);
    r[RESULT_extensor_slack] = pick(no_extensor & ~no_flexor, slack_length, taut_slack);

    r[RESULT_elbow_torque] = pick(l.able, l.torque, nan);
    r[RESULT_motor_torque] = s.motor;
    r[RESULT_elbow_stiffness] = s.stiffness;

    Lanes wound_x = in[IN_flexor_travel] + stretch(d->c_x, d->c_x_resting, s.x, start_x);
    Lanes wound_y = in[IN_extensor_travel] - stretch(d->c_y, d->c_y_resting, s.y, start_y);
    Lanes by_flexor = wound_x / in[IN_flexor_radius];
    Lanes by_extensor = wound_y / (d->ratio * in[IN_flexor_radius]);
    Lanes spool_angle = pick(no_flexor & d->unilateral, by_extensor, by_flexor);
    r[RESULT_spool_angle] = pick(both & d->unilateral, nan, spool_angle);

    r[RESULT_flexor_moment_arm] = in[IN_moment_arm];
    r[RESULT_flexor_travel] = in[IN_flexor_travel];
    r[RESULT_extensor_travel] = in[IN_extensor_travel];
    return (no_flexor & 1) | (no_extensor & 2) | (~l.able & 4);
}

/* Copy `count` values of `bytes` each, or repeat a single one if its step is zero. */
static void copy_values(char *target, const char *source, long step, long bytes, long count) {
    long total = count * bytes;
    long copied = step ? total : bytes;
    memcpy(target, source, (unsigned long)copied);
    while (copied < total) {
        long rest = total - copied;
        memcpy(target + copied, target, (unsigned long)(rest < copied ? rest : copied));
        copied *= 2;
    }
}

/* Copy the keys of `count` states from an angle on, from row `row` on. */
static void write_keys(const RowsCall *call, long angle, long count, long row) {
    long axis = call->walk.axes - 1;
    for (int i = 0; i < call->keys; i++) {
        const Array *source = &call->arrays[INPUT_COUNT + i];
        const Key *key = &call->key[i];
        long step = source->step[axis];
        copy_values(key->target + row * key->bytes, source->value + angle * step, step, key->bytes,
                    count);
    }
}

/* Write `angles` states of a design in one direction, from an angle on, from row `row` on. */
static void write_line(RowsCall *call, long angle, long angles, long row) {
    const Array *arrays = call->arrays;
    long axis = call->walk.axes - 1;
    Lanes in[INPUT_COUNT];
    load_angles(in, arrays, 0, INPUT_COUNT, axis, angle, 1);
    Drive d = drive_at(in);
    int is_plain = has_plain_terms(&d);
    for (int i = IN_gravity_moment; i < INPUT_COUNT; i++) {
        is_plain &= !arrays[i].step[axis];
    }
    write_keys(call, angle, angles, row);

    for (long done = 0; done < angles; done += LANES) {
        long count = angles - done;
        long start = angle + done;
        Lanes results[RESULT_COUNT];
        /* Written out twice: knowing that all lanes are used saves every copy by length. */
        if (count >= LANES) {
            load_angles(in, arrays, 0, IN_gravity_moment, axis, start, LANES);
        } else {
            load_angles(in, arrays, 0, IN_gravity_moment, axis, start, count);
        }
        if (!is_plain) {
            load_angles(in, arrays, IN_gravity_moment, INPUT_COUNT, axis, start, count);
            d = drive_at(in);
        }
        Mask status = is_plain ? results_of(results, in, &d, 1) : results_of(results, in, &d, 0);
        for (int column = 0; column < RESULT_COUNT; column++) {
            double *target = call->column[column];
            if (target) {
                store(target + row + done, results[column], count);
                /* Remaining lanes repeat the first, so they add nothing here. */
                call->has_nan[column] |= any(~is_number(results[column]));
            }
        }
        if (call->status) {
            store_bytes(call->status + row + done, status, count);
        }
    }
}

/* True if an array changes along any axis before the angle. */
static int changes_between_lines(const Array *array, const Walk *walk) {
    for (long axis = 0; axis < walk->axes - 1; axis++) {
        if (array->step[axis]) {
            return 1;
        }
    }
    return 0;
}

/* Write rows `first` to `first + count`, the last axis fastest. */
static void write_rows(RowsCall *call) {
    long length = call->walk.length[call->walk.axes - 1];
    long angle = call->first % length;
    int sources = INPUT_COUNT + (int)call->keys;
    int moving[INPUT_COUNT + MOST_AXES];
    int moving_count = 0;
    for (int i = 0; i < sources; i++) {
        if (changes_between_lines(&call->arrays[i], &call->walk)) {
            moving[moving_count++] = i;
        }
    }
    go_to_line(&call->walk, call->arrays, sources, call->first / length);
    long done = 0;
    while (done < call->count) {
        long rest = call->count - done;
        long angles = rest < length - angle ? rest : length - angle;
        write_line(call, angle, angles, done);
        long axis = next_line(&call->walk);
        for (int k = 0; k < moving_count && axis >= 0; k++) {
            Array *array = &call->arrays[moving[k]];
            array->value += move_along(array, &call->walk, axis);
        }
        done += angles;
        angle = 0;
    }
}
