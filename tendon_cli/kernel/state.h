/* The arithmetic of a state: what `statics.respond`, `statics.solve` and `actuator.State` do in
 * NumPy, operation by operation and to the same bits, for as many states as there are lanes.
 *
 * `drive_at` computes the quantities of a design in one direction, `lines_at` the tensions of its
 * states as straight lines in pretension, and `state_at` these states at a pretension. Every other
 * result is a fold over these. Along the lanes lie angles (`rows.h`) or designs (`batch.h`).
 *
 * A drive is plain if it is the same at all angles: then it is computed once. If a sheath bends
 * with the joint, or the extensor's moment arm changes, there is a drive for each angle, with a few
 * more terms. Callers pass `is_plain` as a constant, so that each case is compiled by itself.
 *
 * Symbols as in `statics.py`: x and y are the distal tensions of flexor and extensor, c_x and c_y
 * their distal compliances, F the pretension of both sides. SI units.
 */

#ifndef TENDON_STATE_H
#define TENDON_STATE_H

#include "arrays.h"
#include "lanes.h"

#define TOLERANCE 1e-9 /* statics.SLACK_TOLERANCE */

/* Part of the states that does not depend on the angle if the drive is plain. */
typedef struct {
    Lanes c_x;            /* distal compliance of the flexor, m/N */
    Lanes c_y;            /* distal compliance of the extensor, m/N */
    Lanes ratio;          /* η, extensor over flexor radius of the spool */
    Lanes extensor_arm;   /* J_e, m */
    Lanes gravity_moment; /* N m */
    Lanes scaled_c_x;     /* η c_x, m/N */
    Lanes compliance;     /* η c_x + c_y, m/N */
    Lanes per_compliance;
    Lanes per_extensor_arm;
    Lanes per_c_x;
    Lanes per_ratio;
    Lanes share_x;           /* η c_x of the compliance */
    Lanes share_y;           /* c_y of the compliance */
    Lanes extensor_pull;     /* J_e²/c_y, stiffness of the elbow by the extensor, N m/rad */
    Lanes motor_x;           /* motor torque per distal newton of the flexor (Eq. 17), m */
    Lanes motor_y;           /* motor torque per distal newton of the extensor, m */
    Lanes lowest;            /* least v: 0 if unilateral, else minus infinity, N */
    Lanes taut_slack;        /* slack length of a taut side: 0 if unilateral, else NaN, m */
    Lanes slope_y;           /* stiffness gained per newton of the extensor, m/rad */
    Lanes spring_x;          /* extension of the flexor's spring per newton, m/N */
    Lanes c_x_resting;       /* c_x in the posture in which the pretension is set, m/N */
    Lanes c_y_resting;       /* c_y in that posture, m/N */
    Lanes common_compliance; /* compliance in that posture, m/N */
    Lanes share_x_resting;   /* η c_x of the common compliance */
    Mask unilateral;
    int any_bilateral;
} Drive;

/* Tensions of states as lines in pretension: with v = max(F - required, lowest) they are x =
 * floor_x + gain_x v and y = floor_y + gain_y v, in newtons. Where there is no equilibrium
 * all but the last two fields are NaN. */
typedef struct {
    Lanes required; /* smallest pretension that keeps the state taut, N */
    Lanes limit;    /* pretension below which either side is slack, N */
    Lanes floor_x;
    Lanes gain_x;
    Lanes floor_y;
    Lanes gain_y;
    Lanes stiffness;       /* of a taut state, without - slope_x x + slope_y y, N m/rad */
    Lanes slack_stiffness; /* the same of a slack state */
    Lanes slope_x;         /* stiffness lost per newton of the flexor, m/rad */
    Lanes per_path;        /* slack length per length of the loose path; NaN if not determined */
    Lanes flexor_limit;    /* pretension below which the flexor is slack, N */
    Lanes extensor_limit;  /* pretension below which the extensor is slack, N */
    Lanes torque;          /* elbow torque, N m */
    Mask able;             /* set where there is an equilibrium */
} Lines;

/* States at a pretension. */
typedef struct {
    Lanes x;         /* distal tension of the flexor, N */
    Lanes y;         /* distal tension of the extensor, N */
    Lanes motor;     /* motor torque, N m */
    Lanes stiffness; /* elbow stiffness, N m/rad */
    Lanes path;      /* path length that no tendon takes up, if slack, m */
    Mask slack;
} State;

/* Compute drives from inputs in the order of GIVEN. */
INLINE Drive drive_at(const Lanes *in) {
    Drive d;
    d.c_x = in[IN_flexor_tendon] + in[IN_flexor_spring] + in[IN_flexor_anchor];
    d.c_y = in[IN_extensor_tendon] + in[IN_extensor_spring] + in[IN_extensor_anchor];
    d.ratio = in[IN_ratio];
    d.extensor_arm = in[IN_extensor_arm];
    d.gravity_moment = in[IN_gravity_moment];
    d.scaled_c_x = d.ratio * d.c_x;
    d.compliance = d.scaled_c_x + d.c_y;
    d.slope_y = in[IN_extensor_slope];
    d.spring_x = in[IN_flexor_spring];
    d.per_compliance = 1.0 / d.compliance;
    d.per_extensor_arm = 1.0 / d.extensor_arm;
    d.per_c_x = 1.0 / d.c_x;
    d.per_ratio = 1.0 / d.ratio;
    d.share_x = d.scaled_c_x * d.per_compliance;
    d.share_y = d.c_y * d.per_compliance;
    d.c_x_resting = in[IN_flexor_tendon_resting] + in[IN_flexor_spring_resting];
    d.c_x_resting += in[IN_flexor_anchor];
    d.c_y_resting = in[IN_extensor_tendon_resting] + in[IN_extensor_spring_resting];
    d.c_y_resting += in[IN_extensor_anchor];
    d.common_compliance = d.ratio * d.c_x_resting + d.c_y_resting;
    d.share_x_resting = d.ratio * d.c_x_resting * (1.0 / d.common_compliance);
    d.extensor_pull = d.extensor_arm * d.extensor_arm / d.c_y;
    d.motor_x = in[IN_flexor_radius] / in[IN_flexor_capstan];
    d.motor_y = d.ratio * in[IN_flexor_radius] / in[IN_extensor_capstan];
    d.unilateral = in[IN_unilateral] > 0.0;
    d.any_bilateral = any(~d.unilateral);
    d.lowest = pick(d.unilateral, all_lanes(0.0), all_lanes(-INFINITY));
    d.taut_slack = pick(d.unilateral, all_lanes(0.0), all_lanes(NAN));
    return d;
}

/* True if all the terms vanish that only a drive that is not plain has. */
INLINE int has_plain_terms(const Drive *d) {
    Mask differs_x = d->c_x_resting != d->c_x;
    Mask differs_y = d->c_y_resting != d->c_y;
    return !any((d->slope_y != 0.0) | differs_x | differs_y);
}

/* Pretension of both sides that is equivalent to two different ones, N. */
INLINE Lanes common_pretension(const Drive *d, Lanes flexor, Lanes extensor) {
    return extensor + d->share_x_resting * (flexor - extensor);
}

/* Set the pretensions below which either of the paper's bilateral tendons counts as slack. `arm` is
 * J_f, m, and `mismatch` H_e - η H_f, m. */
INLINE void set_bilateral_limits(Lines *l, const Drive *d, Lanes arm, Lanes mismatch) {
    Lanes at_x = l->torque / arm;
    Lanes at_y = -l->torque / d->extensor_arm;
    Lanes for_y = (d->scaled_c_x * at_x - mismatch) / d->common_compliance;
    Lanes for_x = (d->c_y * at_y - mismatch) / d->common_compliance;
    for_x -= TOLERANCE * at_least(magnitude(at_y), magnitude(for_x)) / l->gain_x;
    for_y -= TOLERANCE * at_least(magnitude(at_x), magnitude(for_y)) / l->gain_y;
    l->flexor_limit = pick(d->unilateral, l->flexor_limit, for_x);
    l->extensor_limit = pick(d->unilateral, l->extensor_limit, for_y);
    l->limit = pick(d->unilateral, l->limit, at_least(for_x, for_y));
    l->slack_stiffness = pick(d->unilateral, l->slack_stiffness, l->stiffness);
    l->per_path = pick(d->unilateral, l->per_path, all_lanes(NAN));
}

/* Compute the lines of states from their drives and the inputs before IN_pressed. */
INLINE Lines lines_at(const Drive *d, const Lanes *in, int is_plain) {
    Lines l;
    Lanes arm = in[IN_pulling_arm];
    Lanes zero = all_lanes(0.0);
    Lanes per_arm = 1.0 / arm;
    l.able = is_number(arm);
    l.slope_x = in[IN_flexor_slope];
    l.torque = d->gravity_moment * in[IN_sine] + in[IN_other_torque];
    Lanes torque_slope = d->gravity_moment * in[IN_cosine] + in[IN_other_slope];
    Lanes mismatch = in[IN_extensor_travel] - d->ratio * in[IN_flexor_travel];

    l.floor_x = at_least(zero, l.torque * per_arm);
    l.floor_y = at_least(zero, -l.torque * d->per_extensor_arm);
    Lanes load = at_least(l.floor_x, l.floor_y);
    Lanes spread = d->share_x * d->extensor_arm + d->share_y * arm;
    l.required = d->share_x * l.floor_x + d->share_y * l.floor_y - mismatch * d->per_compliance;
    if (!is_plain) {
        Lanes grown = d->common_compliance / d->compliance;
        spread /= grown;
        l.required /= grown;
    }
    l.gain_x = d->extensor_arm / spread;
    l.gain_y = l.gain_x * (arm * d->per_extensor_arm);

    Lanes size = magnitude(l.required);
    Lanes flexor_pull = arm * arm * d->per_c_x;
    l.stiffness = flexor_pull + d->extensor_pull + torque_slope;
    Mask backward = l.torque < 0.0;
    Mask idle = load <= TOLERANCE * size;
    Lanes per_loaded_arm = pick(backward, d->per_extensor_arm, per_arm);
    l.limit = l.required - TOLERANCE * at_least(load, size) * spread * per_loaded_arm;
    l.flexor_limit = pick(idle | backward, l.limit, all_lanes(-INFINITY));
    l.extensor_limit = pick(idle | ~backward, l.limit, all_lanes(-INFINITY));
    Lanes slack_pull = pick(idle, zero, pick(backward, d->extensor_pull, flexor_pull));
    l.slack_stiffness = slack_pull + torque_slope;
    l.per_path = pick(idle, all_lanes(NAN), pick(backward, d->per_ratio, all_lanes(1.0)));
    if (d->any_bilateral) {
        set_bilateral_limits(&l, d, arm, mismatch);
    }
    return l;
}

/* Compute states at a pretension from their lines. */
INLINE State state_at(const Lines *l, const Drive *d, Lanes pretension, int is_plain) {
    State s;
    Lanes margin = pretension - l->required;
    Lanes v = at_least(d->lowest, margin);
    s.slack = pretension < l->limit;
    s.x = l->floor_x + l->gain_x * v;
    s.y = l->floor_y + l->gain_y * v;
    s.motor = s.x * d->motor_x - s.y * d->motor_y;
    s.stiffness = pick(s.slack, l->slack_stiffness, l->stiffness) - s.x * l->slope_x;
    if (!is_plain) {
        s.stiffness += s.y * d->slope_y;
    }
    s.path = -d->common_compliance * margin;
    return s;
}

#endif
