/* Rows of the states table: each state at its pretension, its results straight to where the rows are gathered. */

#include "state.h"

/* Some inputs at angles, one a lane; what is left of the lanes repeats the first. */
INLINE void along(Lanes *in, const Array *arrays, int first, int stop, long axis, long angle, long count) {
    for (int i = first; i < stop; i++) {
        const char *from = arrays[i].at + arrays[i].step[axis] * angle;
        in[i] = same(*(const double *)from);
        if (arrays[i].step[axis]) memcpy(in + i, from, count >= LANES ? sizeof *in : 8 * (unsigned long)count);
    }
}

/* By how much something is longer than where the pretension was set, of its compliances and tensions now and there. */
INLINE Lanes stretch(Lanes now, Lanes resting, Lanes tension, Lanes pretension) {
    return now * (tension - pretension) + (now - resting) * pretension;
}

/* All result columns of some states, in the order of RESULTS; returns their status. */
INLINE Mask results_of(Lanes *r, const Lanes *in, const Drive *d, int plain) {
    Lines l = lines_at(d, in, plain);
    Lanes pretension = common_pretension(d, in[IN_flexor_pretension], in[IN_extensor_pretension]);
    State s = state_at(&l, d, pretension, plain);
    Mask no_flexor = pretension < l.flexor_limit, no_extensor = pretension < l.extensor_limit;
    Mask both = no_flexor & no_extensor;
    Lanes known = pick(both | ~l.able, same(NAN), d->unknown), length = s.loose * l.per_side;
    r[OF_flexor_tension_proximal] = s.x / in[IN_flexor_capstan], r[OF_flexor_tension_distal] = s.x;
    r[OF_extensor_tension_proximal] = s.y / in[IN_extensor_capstan], r[OF_extensor_tension_distal] = s.y;
    Lanes start_x = in[IN_flexor_pretension], start_y = in[IN_extensor_pretension];
    r[OF_flexor_tendon_stretch] = stretch(in[IN_flexor_tendon], in[IN_flexor_tendon_resting], s.x, start_x);
    r[OF_extensor_tendon_stretch] = stretch(in[IN_extensor_tendon], in[IN_extensor_tendon_resting], s.y, start_y);
    r[OF_flexor_spring_stretch] = stretch(in[IN_flexor_spring], in[IN_flexor_spring_resting], s.x, start_x);
    r[OF_extensor_spring_stretch] = stretch(in[IN_extensor_spring], in[IN_extensor_spring_resting], s.y, start_y);
    r[OF_flexor_slack] = pick(no_flexor & ~no_extensor, length, known);
    r[OF_extensor_slack] = pick(no_extensor & ~no_flexor, length, known);
    r[OF_elbow_torque] = pick(l.able, l.torque, same(NAN));
    r[OF_motor_torque] = s.motor, r[OF_elbow_stiffness] = s.stiffness;
    Lanes by_flexor = (in[IN_flexor_travel] + stretch(d->c_x, d->c_x_resting, s.x, start_x)) / in[IN_flexor_radius];
    Lanes by_extensor = (in[IN_extensor_travel] - stretch(d->c_y, d->c_y_resting, s.y, start_y)) / (d->ratio * in[IN_flexor_radius]);
    Lanes angle = pick(no_flexor & d->unilateral, by_extensor, by_flexor);
    r[OF_spool_angle] = pick(both & d->unilateral, same(NAN), angle);
    r[OF_flexor_moment_arm] = in[IN_moment_arm];
    r[OF_flexor_travel] = in[IN_flexor_travel], r[OF_extensor_travel] = in[IN_extensor_travel];
    return (no_flexor & 1) | (no_extensor & 2) | (~l.able & 4);
}

static void copy(char *to, const char *from, long step, long bytes, long count) {
    long done = step ? count * bytes : bytes, all = count * bytes;
    memcpy(to, from, (unsigned long)done);
    for (; done < all; done *= 2) memcpy(to + done, to, (unsigned long)(done < all - done ? done : all - done));
}

/* States of a design in one direction from an angle on, into the columns from row `row` on. */
static void write_line(Rows *w, long angle, long angles, long row) {
    const Array *a = w->arrays;
    long axis = w->walk.axes - 1;
    Lanes in[INPUTS];
    along(in, a, 0, INPUTS, axis, angle, 1);
    Drive d = drive_at(in);
    int plain = adds_nothing(&d);
    for (int i = IN_gravity_moment; i < INPUTS; i++) plain &= !a[i].step[axis];
    for (int i = 0; i < w->keys; i++) {
        const Array *from = a + INPUTS + i;
        copy(w->key[i].to + row * w->key[i].bytes, from->at + angle * from->step[axis], from->step[axis], w->key[i].bytes,
             angles);
    }
    for (long done = 0; done < angles; done += LANES) {
        long count = angles - done, at = angle + done;
        Lanes results[COLUMNS];
        /* Written out twice: knowing that all lanes are used saves every copy by length. */
        if (count >= LANES) along(in, a, 0, IN_gravity_moment, axis, at, LANES);
        else along(in, a, 0, IN_gravity_moment, axis, at, count);
        if (!plain) {
            along(in, a, IN_gravity_moment, INPUTS, axis, at, count);
            d = drive_at(in);
        }
        Mask status = plain ? results_of(results, in, &d, 1) : results_of(results, in, &d, 0);
        for (int column = 0; column < COLUMNS; column++)
            if (w->column[column]) {
                put(w->column[column] + row + done, results[column], count);
                w->no_number[column] |= any(~is_number(results[column])); /* the lanes left repeat the first */
            }
        if (w->status) put_small(w->status + row + done, status, count);
    }
}

/* Rows `first` to `first + count`, the last axis fastest. */
static void rows(Rows *w) {
    long length = w->walk.length[w->walk.axes - 1], angle = w->first % length;
    int moving[INPUTS + MOST_AXES], moves = 0;
    for (int i = 0; i < INPUTS + w->keys; i++)
        for (long axis = 0, once = 1; axis < w->walk.axes - 1 && once; axis++)
            if (w->arrays[i].step[axis]) moving[moves++] = i, once = 0;
    to_line(&w->walk, w->arrays, INPUTS + w->keys, w->first / length);
    for (long done = 0; done < w->count; angle = 0) {
        long angles = w->count - done < length - angle ? w->count - done : length - angle;
        write_line(w, angle, angles, done);
        done += angles;
        next_line(&w->walk, w->arrays, moving, moves);
    }
}
