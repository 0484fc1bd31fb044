/* What does not depend on pretension, of as many states as there are lanes: statics.respond and lines.Lines. */

#ifndef TENDON_LINES_H
#define TENDON_LINES_H

#include "lanes.h"

#define TOLERANCE 1e-9 /* statics.SLACK_TOLERANCE */

/* What states know before any pretension, in SI units; over (designs, directions, angles), or with designs and angles
 * exchanged, so that either may lie along the lanes. `unilateral` is one or nought. */
typedef struct {
    Field arm, per_arm, arm_slope, flexor_travel, extensor_travel, sine, cosine;
    Field flexor_compliance, extensor_compliance, flexor_arm, extensor_arm, ratio, radius, moment, unilateral;
} States;

/* What does not depend on the angle. */
typedef struct {
    Lanes c_x, c_y, x_arm, y_arm, ratio, radius, moment;
    Lanes flexor, common, per_common, per_radius, per_c_x, share_x, share_y, pull_y;
    Mask unilateral;
} Designs;

/* And what does. Without a positive moment arm nothing is a number. */
typedef struct {
    Lanes arm, per_arm, arm_slope, flexor_travel, extensor_travel, mismatch, torque, torque_slope;
} Given;

/* As `lines.Lines`: values at v = 0, and gains; `idle` is one where no load picks a side, or nought. */
typedef struct {
    Lanes shortfall, lowest, limit, x, x_gain, y, y_gain, motor, motor_gain, k, k_gain, k_slack, idle;
} Lines;

INLINE Designs designs_at(const States *s, long i, long j, long k, long count) {
    Designs d;
    d.c_x = take(&s->flexor_compliance, i, j, k, count), d.c_y = take(&s->extensor_compliance, i, j, k, count);
    d.x_arm = take(&s->flexor_arm, i, j, k, count), d.y_arm = take(&s->extensor_arm, i, j, k, count);
    d.ratio = take(&s->ratio, i, j, k, count), d.radius = take(&s->radius, i, j, k, count);
    d.moment = take(&s->moment, i, j, k, count), d.unilateral = take(&s->unilateral, i, j, k, count) > 0.0;
    d.flexor = d.ratio * d.c_x;
    d.common = d.flexor + d.c_y;
    d.per_common = 1.0 / d.common, d.per_radius = 1.0 / d.radius, d.per_c_x = 1.0 / d.c_x;
    d.share_x = d.flexor * d.per_common, d.share_y = d.c_y * d.per_common;
    d.pull_y = d.radius * d.radius / d.c_y;
    return d;
}

INLINE Given given_at(const States *s, const Designs *d, long i, long j, long k, long count) {
    Given g;
    g.arm = take(&s->arm, i, j, k, count), g.per_arm = take(&s->per_arm, i, j, k, count);
    g.arm_slope = take(&s->arm_slope, i, j, k, count);
    g.flexor_travel = take(&s->flexor_travel, i, j, k, count);
    g.extensor_travel = take(&s->extensor_travel, i, j, k, count);
    g.mismatch = g.extensor_travel - d->ratio * g.flexor_travel;
    g.torque = d->moment * take(&s->sine, i, j, k, count);
    g.torque_slope = d->moment * take(&s->cosine, i, j, k, count);
    return g;
}

/* Of unilateral tendons. */
INLINE Lines lines_of(const Given *g, const Designs *d) {
    Lines l;
    Lanes R = d->radius, J = g->arm, nought = all(0.0);
    Mask backward = g->torque < 0.0;
    l.x = clip(g->torque * g->per_arm, nought), l.y = clip(-g->torque * d->per_radius, nought);
    Lanes load = clip(l.x, l.y), spread = d->share_x * R + d->share_y * J;
    l.x_gain = R / spread, l.y_gain = l.x_gain * (J * d->per_radius);
    l.shortfall = d->share_x * l.x + d->share_y * l.y - g->mismatch * d->per_common, l.lowest = nought;
    Lanes near = TOLERANCE * clip(load, magnitude(l.shortfall)) * spread;
    l.limit = l.shortfall - near * pick(backward, d->per_radius, g->per_arm);
    l.idle = pick(load <= TOLERANCE * magnitude(l.shortfall), all(1.0), nought);
    l.motor = l.x * d->x_arm - l.y * d->y_arm;
    l.motor_gain = l.x_gain * d->x_arm - l.y_gain * d->y_arm;
    Lanes pull_x = J * J * d->per_c_x, pull_y = d->pull_y;
    l.k = pull_x + pull_y + (g->torque_slope - g->arm_slope * l.x), l.k_gain = -g->arm_slope * l.x_gain;
    l.k_slack = l.k - (pick(backward, pull_x, pull_y) + l.idle * pick(backward, pull_y, pull_x));
    return l;
}

/* Pretensions below which either of the paper's bilateral tendons counts as slack: statics._side_limits. */
INLINE void side_limits(const Lines *l, const Given *g, const Designs *d, Lanes *flexor, Lanes *extensor) {
    Lanes at_x = g->torque / g->arm, at_y = -g->torque / d->radius;
    Lanes for_y = (d->flexor * at_x - g->mismatch) / d->common, for_x = (d->c_y * at_y - g->mismatch) / d->common;
    *flexor = for_x - TOLERANCE * clip(magnitude(at_y), magnitude(for_x)) / l->x_gain;
    *extensor = for_y - TOLERANCE * clip(magnitude(at_x), magnitude(for_y)) / l->y_gain;
}

/* Bilateral tendons go on along the same lines; the others stay as they are. */
INLINE void go_on(Lines *l, const Designs *d, Lanes limit) {
    l->limit = pick(d->unilateral, l->limit, limit);
    l->lowest = pick(d->unilateral, l->lowest, all(-INFINITY));
    l->k_slack = pick(d->unilateral, l->k_slack, all(INFINITY));
}

#endif
