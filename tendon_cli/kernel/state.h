/* A state, once: what `statics.respond`, `statics.solve` and `actuator.State` say in NumPy,
 * operation by operation and to the same bits, for as many states as there are lanes.
 *
 * `drive_at` is what a design has in one direction, `lines_at` some of its states as straight lines in pretension, and
 * `state_at` these states at a pretension. Whatever is wanted of states is a fold over these. Angles lie along the
 * lanes (`rows.h`), or designs do (`beside.h`).
 *
 * A drive is `plain` if it is the same at all angles: then it is worked out once. If a sheath bends with the joint, or
 * the extensor's moment arm changes, it is one per angle, with some terms more. Whoever calls says which, as a constant.
 */

#ifndef TENDON_STATE_H
#define TENDON_STATE_H

#include "arrays.h"
#include "lanes.h"

#define TOLERANCE 1e-9 /* statics.SLACK_TOLERANCE */

/* What in a plain drive does not depend on the angle. `resting` is where the pretension is set, in all else the same. */
typedef struct {
    Lanes c_x, c_y, ratio, radius, moment, turned, all, per_all, per_radius, per_c_x, per_ratio, share_x, share_y;
    Lanes pull_y, motor_x, motor_y, lowest, unknown, slope_y;
    Lanes c_x_resting, c_y_resting, common, share_resting;
    Mask unilateral;
    int any_bilateral;
} Drive;

/* With v = max(F - shortfall, lowest) the tensions are x + x_gain v and y + y_gain v. Below `flexor_limit` and
 * `extensor_limit` the sides are slack. Where the flexor cannot balance anything all but the last two is no number. */
typedef struct {
    Lanes shortfall, limit, x, x_gain, y, y_gain;
    Lanes stiffness, slack_stiffness; /* but for - slope_x x + slope_y y; both sides pulling, or not */
    Lanes slope_x;
    Lanes per_side; /* slack length per loose path; not a number where that is not determined */
    Lanes flexor_limit, extensor_limit, torque;
    Mask able;
} Lines;

/* At a pretension. */
typedef struct {
    Lanes x, y, motor, stiffness, loose; /* `loose` is the path that nothing takes up, where slack */
    Mask slack;
} State;

/* From the inputs in the order of GIVEN. */
INLINE Drive drive_at(const Lanes *in) {
    Drive d;
    d.c_x = in[IN_flexor_tendon] + in[IN_flexor_spring] + in[IN_flexor_anchor];
    d.c_y = in[IN_extensor_tendon] + in[IN_extensor_spring] + in[IN_extensor_anchor];
    d.ratio = in[IN_ratio], d.radius = in[IN_extensor_arm], d.moment = in[IN_gravity_moment];
    d.turned = d.ratio * d.c_x, d.all = d.turned + d.c_y, d.slope_y = in[IN_extensor_slope];
    d.per_all = 1.0 / d.all, d.per_radius = 1.0 / d.radius, d.per_c_x = 1.0 / d.c_x, d.per_ratio = 1.0 / d.ratio;
    d.share_x = d.turned * d.per_all, d.share_y = d.c_y * d.per_all;
    d.c_x_resting = in[IN_flexor_tendon_resting] + in[IN_flexor_spring_resting] + in[IN_flexor_anchor];
    d.c_y_resting = in[IN_extensor_tendon_resting] + in[IN_extensor_spring_resting] + in[IN_extensor_anchor];
    d.common = d.ratio * d.c_x_resting + d.c_y_resting, d.share_resting = d.ratio * d.c_x_resting * (1.0 / d.common);
    d.pull_y = d.radius * d.radius / d.c_y;
    d.motor_x = in[IN_flexor_radius] / in[IN_flexor_capstan];
    d.motor_y = d.ratio * in[IN_flexor_radius] / in[IN_extensor_capstan];
    d.unilateral = in[IN_unilateral] > 0.0, d.any_bilateral = any(~d.unilateral);
    d.lowest = pick(d.unilateral, same(0.0), same(-INFINITY)), d.unknown = pick(d.unilateral, same(0.0), same(NAN));
    return d;
}

/* Whether what a drive adds to a plain one is nothing. */
INLINE int adds_nothing(const Drive *d) {
    return !any((d->slope_y != 0.0) | (d->c_x_resting != d->c_x) | (d->c_y_resting != d->c_y));
}

/* The pretension of both sides that does what two different ones do. */
INLINE Lanes common_pretension(const Drive *d, Lanes flexor, Lanes extensor) {
    return extensor + d->share_resting * (flexor - extensor);
}

/* Pretensions below which either of the paper's bilateral tendons counts as slack. */
INLINE void side_limits(Lines *l, const Drive *d, Lanes arm, Lanes mismatch) {
    Lanes at_x = l->torque / arm, at_y = -l->torque / d->radius;
    Lanes for_y = (d->turned * at_x - mismatch) / d->common, for_x = (d->c_y * at_y - mismatch) / d->common;
    for_x -= TOLERANCE * at_least(magnitude(at_y), magnitude(for_x)) / l->x_gain;
    for_y -= TOLERANCE * at_least(magnitude(at_x), magnitude(for_y)) / l->y_gain;
    l->flexor_limit = pick(d->unilateral, l->flexor_limit, for_x);
    l->extensor_limit = pick(d->unilateral, l->extensor_limit, for_y);
    l->limit = pick(d->unilateral, l->limit, at_least(for_x, for_y));
    l->slack_stiffness = pick(d->unilateral, l->slack_stiffness, l->stiffness);
    l->per_side = pick(d->unilateral, l->per_side, same(NAN));
}

/* `in` are the inputs at the angle, those that differ from angle to angle in any joint. */
INLINE Lines lines_at(const Drive *d, const Lanes *in, int plain) {
    Lines l;
    Lanes arm = in[IN_pulling_arm], zero = same(0.0), per_arm = 1.0 / arm;
    l.able = is_number(arm), l.slope_x = in[IN_flexor_slope];
    l.torque = d->moment * in[IN_sine] + in[IN_other_torque];
    Lanes torque_slope = d->moment * in[IN_cosine] + in[IN_other_slope];
    Lanes mismatch = in[IN_extensor_travel] - d->ratio * in[IN_flexor_travel];
    l.x = at_least(zero, l.torque * per_arm), l.y = at_least(zero, -l.torque * d->per_radius);
    Lanes load = at_least(l.x, l.y), spread = d->share_x * d->radius + d->share_y * arm;
    l.shortfall = d->share_x * l.x + d->share_y * l.y - mismatch * d->per_all;
    if (!plain) spread /= d->common / d->all, l.shortfall /= d->common / d->all;
    l.x_gain = d->radius / spread, l.y_gain = l.x_gain * (arm * d->per_radius);
    Lanes size = magnitude(l.shortfall), pull_x = arm * arm * d->per_c_x;
    l.stiffness = pull_x + d->pull_y + torque_slope;
    Mask backward = l.torque < 0.0, idle = load <= TOLERANCE * size;
    l.limit = l.shortfall - TOLERANCE * at_least(load, size) * spread * pick(backward, d->per_radius, per_arm);
    l.flexor_limit = pick(idle | backward, l.limit, same(-INFINITY));
    l.extensor_limit = pick(idle | ~backward, l.limit, same(-INFINITY));
    l.slack_stiffness = pick(idle, zero, pick(backward, d->pull_y, pull_x)) + torque_slope;
    l.per_side = pick(idle, same(NAN), pick(backward, d->per_ratio, same(1.0)));
    if (d->any_bilateral) side_limits(&l, d, arm, mismatch);
    return l;
}

INLINE State state_at(const Lines *l, const Drive *d, Lanes pretension, int plain) {
    State s;
    Lanes surplus = pretension - l->shortfall, v = at_least(d->lowest, surplus);
    s.slack = pretension < l->limit;
    s.x = l->x + l->x_gain * v, s.y = l->y + l->y_gain * v;
    s.motor = s.x * d->motor_x - s.y * d->motor_y;
    s.stiffness = pick(s.slack, l->slack_stiffness, l->stiffness) - s.x * l->slope_x;
    if (!plain) s.stiffness += s.y * d->slope_y;
    s.loose = -d->common * surplus;
    return s;
}

#endif
