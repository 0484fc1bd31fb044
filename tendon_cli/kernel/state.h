/* A state, once: what `statics.respond`, `statics.solve`, `statics.elbow_stiffness` and `actuator.State` say in NumPy,
 * operation by operation and to the same bits. Angles lie along the lanes.
 *
 * `drive_at` is what a design has in one direction, `lines_at` some of its states as straight lines in pretension, and
 * `state_at` these states at a pretension. Whatever is wanted of states is a fold over these.
 */

#ifndef TENDON_STATE_H
#define TENDON_STATE_H

#include "arrays.h"
#include "lanes.h"

#define TOLERANCE 1e-9 /* statics.SLACK_TOLERANCE */

/* What does not depend on the angle. */
typedef struct {
    double c_x, c_y, ratio, radius, moment, turned, common, per_common, per_radius, per_c_x, per_ratio, share_x, share_y;
    double pull_y, motor_x, motor_y, lowest, unknown;
    int unilateral;
} Drive;

/* With v = max(F - shortfall, lowest) the tensions are x + x_gain v and y + y_gain v. Below `flexor_limit` and
 * `extensor_limit` the sides are slack. Where the flexor cannot balance anything all but the last five is no number. */
typedef struct {
    Lanes shortfall, limit, flexor_limit, extensor_limit, x, x_gain, y, y_gain;
    Lanes stiffness, slack_stiffness; /* but for what the flexor's tension takes of it; both sides pulling, or not */
    Lanes per_side;                   /* slack length per loose path; not a number where that is not determined */
    Lanes arm_slope, torque, flexor_travel, extensor_travel;
    Mask able;
} Lines;

/* At a pretension. */
typedef struct {
    Lanes x, y, motor, stiffness, loose; /* `loose` is the path that nothing takes up, where slack */
    Mask slack;
} State;

INLINE double one(const Array *arrays, int input) { return *(const double *)arrays[input].at; }

INLINE Lanes along(const Array *arrays, int input, long axis, long angle, long count) {
    const Array *array = arrays + input;
    Lanes to = same(NAN);
    if (!array->step[axis]) return same(*(const double *)array->at);
    memcpy(&to, array->at + 8 * angle, count >= LANES ? sizeof to : 8 * (unsigned long)count);
    return to;
}

INLINE Drive drive_at(const Array *a) {
    Drive d;
    d.c_x = one(a, IN_flexor_tendon) + one(a, IN_flexor_spring);
    d.c_y = one(a, IN_extensor_tendon) + one(a, IN_extensor_spring);
    d.ratio = one(a, IN_ratio), d.radius = one(a, IN_elbow_radius), d.moment = one(a, IN_gravity_moment);
    d.turned = d.ratio * d.c_x, d.common = d.turned + d.c_y;
    d.per_common = 1.0 / d.common, d.per_radius = 1.0 / d.radius, d.per_c_x = 1.0 / d.c_x, d.per_ratio = 1.0 / d.ratio;
    d.share_x = d.turned * d.per_common, d.share_y = d.c_y * d.per_common;
    d.pull_y = d.radius * d.radius / d.c_y;
    d.motor_x = one(a, IN_flexor_radius) / one(a, IN_flexor_capstan);
    d.motor_y = d.ratio * one(a, IN_flexor_radius) / one(a, IN_extensor_capstan);
    d.unilateral = one(a, IN_unilateral) > 0.0;
    d.lowest = d.unilateral ? 0.0 : -INFINITY, d.unknown = d.unilateral ? 0.0 : NAN;
    return d;
}

/* The pretension of both sides that does what two different ones do. */
INLINE double common_pretension(const Drive *d, double flexor, double extensor) {
    return extensor + d->share_x * (flexor - extensor);
}

/* Pretensions below which either of the paper's bilateral tendons counts as slack. */
INLINE void side_limits(Lines *l, const Drive *d, Lanes arm, Lanes mismatch) {
    Lanes at_x = l->torque / arm, at_y = -l->torque / d->radius;
    Lanes for_y = (d->turned * at_x - mismatch) / d->common, for_x = (d->c_y * at_y - mismatch) / d->common;
    l->flexor_limit = for_x - TOLERANCE * at_least(magnitude(at_y), magnitude(for_x)) / l->x_gain;
    l->extensor_limit = for_y - TOLERANCE * at_least(magnitude(at_x), magnitude(for_y)) / l->y_gain;
    l->limit = at_least(l->flexor_limit, l->extensor_limit);
    l->slack_stiffness = l->stiffness, l->per_side = same(NAN);
}

/* As `lines_at`, for which it is written out twice: knowing that all lanes are used saves every copy by length. */
INLINE Lines some_lines(const Array *a, const Drive *d, long axis, long angle, long count) {
    Lines l;
    Lanes arm = pick(is_used(count), along(a, IN_pulling_arm, axis, angle, count), same(NAN)), zero = same(0.0);
    Lanes per_arm = 1.0 / arm;
    l.able = is_number(arm);
    l.arm_slope = along(a, IN_moment_arm_slope, axis, angle, count);
    l.flexor_travel = along(a, IN_flexor_travel, axis, angle, count);
    l.extensor_travel = along(a, IN_extensor_travel, axis, angle, count);
    l.torque = d->moment * along(a, IN_sine, axis, angle, count);
    Lanes torque_slope = d->moment * along(a, IN_cosine, axis, angle, count);
    Lanes mismatch = l.extensor_travel - d->ratio * l.flexor_travel;
    l.x = at_least(zero, l.torque * per_arm), l.y = at_least(zero, -l.torque * d->per_radius);
    Lanes load = at_least(l.x, l.y), spread = d->share_x * d->radius + d->share_y * arm;
    l.x_gain = d->radius / spread, l.y_gain = l.x_gain * (arm * d->per_radius);
    l.shortfall = d->share_x * l.x + d->share_y * l.y - mismatch * d->per_common;
    Lanes size = magnitude(l.shortfall), pull_x = arm * arm * d->per_c_x;
    l.stiffness = pull_x + d->pull_y + torque_slope;
    if (!d->unilateral) {
        side_limits(&l, d, arm, mismatch);
        return l;
    }
    Mask backward = l.torque < 0.0, idle = load <= TOLERANCE * size;
    l.limit = l.shortfall - TOLERANCE * at_least(load, size) * spread * pick(backward, same(d->per_radius), per_arm);
    l.flexor_limit = pick(idle | backward, l.limit, same(-INFINITY));
    l.extensor_limit = pick(idle | ~backward, l.limit, same(-INFINITY));
    l.slack_stiffness = pick(idle, zero, pick(backward, same(d->pull_y), pull_x)) + torque_slope;
    l.per_side = pick(idle, same(NAN), pick(backward, same(d->per_ratio), same(1.0)));
    return l;
}

/* `count` states from an angle on; what is left of the lanes is no state. */
INLINE Lines lines_at(const Array *a, const Drive *d, long axis, long angle, long count) {
    return count >= LANES ? some_lines(a, d, axis, angle, LANES) : some_lines(a, d, axis, angle, count);
}

INLINE State state_at(const Lines *l, const Drive *d, Lanes pretension) {
    State s;
    Lanes surplus = pretension - l->shortfall, v = at_least(same(d->lowest), surplus);
    s.slack = pretension < l->limit;
    s.x = l->x + l->x_gain * v, s.y = l->y + l->y_gain * v;
    s.motor = s.x * d->motor_x - s.y * d->motor_y;
    s.stiffness = pick(s.slack, l->slack_stiffness, l->stiffness) - s.x * l->arm_slope;
    s.loose = -d->common * surplus;
    return s;
}

#endif
