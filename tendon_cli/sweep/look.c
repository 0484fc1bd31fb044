/* A look at all states of a tile: what `lines.py` does in NumPy, operation by operation and to the same bits.
 *
 * Per angle, direction and design the lines in pretension are worked out, then each pretension takes a difference, a
 * maximum, four multiply-adds and a dozen comparisons per state. Designs lie side by side, WIDTH at a time, so that a
 * compiler makes vectors of them; ANGLES angles of these fit the cache. A state without equilibrium is not a number all
 * through, and comparisons leave it out. To be compiled without contraction of multiply-adds and without fast math.
 */

#include <float.h>
#include <math.h>
#include <stdlib.h>

#if defined(__FAST_MATH__) || FLT_EVAL_METHOD != 0
#error "other bits than NumPy's, to which this is left if it does not compile"
#endif
const int tendon_look_version = 1;

#define WIDTH 32
#define ANGLES 96
#define TOLERANCE 1e-9 /* statics.SLACK_TOLERANCE */

#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && defined(__GLIBC__) /* musl cannot choose */
#define FOR_EACH_PROCESSOR __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define FOR_EACH_PROCESSOR
#endif

/* An array over (angles, directions, designs), or (pretensions, directions, designs): where it is broadcast its step is
 * nought. Steps count numbers; along the designs the step is one or nought. */
typedef struct {
    const double *at;
    long step[3];
} Field;

/* As `tile.Tile` has it, in SI units; `unilateral` is one or nought. */
typedef struct {
    Field arm, per_arm, arm_slope, flexor_travel, extensor_travel, sine, cosine;
    Field flexor_compliance, extensor_compliance, flexor_arm, extensor_arm, ratio, radius, moment, unilateral;
    Field pretension;
    const double *angle;
    long angles, directions, designs, pretensions, any_bilateral;
} Tile;

enum { LOW_X, HIGH_X, LOW_Y, HIGH_Y, LOW_MOTOR, HIGH_MOTOR, STIFFNESS, UNSTABLE, SLACK, FIRST, BY_PRETENSION };
enum { SHORTFALL, FLEXOR_SHORTFALL, FLEXOR_LIMIT, EXTENSOR_SHORTFALL, EXTENSOR_LIMIT, ONE_SIDED, BOTH_LIMIT, NOWHERE,
       LOW_TORQUE, HIGH_TORQUE, ASIDE };

/* Each result is an array over (pretensions, directions, designs), or over (directions, designs). */
typedef struct {
    double *by_pretension[BY_PRETENSION];
    double *aside[ASIDE];
} Seen;

typedef double Row[WIDTH];

/* As `lines.Lines`, at one angle: values at v = 0, and gains; `idle` is one where no load picks a side, or nought. */
typedef struct {
    Row shortfall, lowest, limit, x, x_gain, y, y_gain, motor, motor_gain, k, k_gain, k_slack, idle;
} Lines;

static const double BEGIN[BY_PRETENSION] = {INFINITY, -INFINITY, INFINITY, -INFINITY, INFINITY,
                                            -INFINITY, INFINITY, 0.0, 0.0, INFINITY};
static const double BEGIN_ASIDE[ASIDE] = {-INFINITY, -INFINITY, -INFINITY, -INFINITY, -INFINITY, 0.0, INFINITY, 0.0,
                                          INFINITY, -INFINITY};

/* Of two numbers; where one is none, the first of `most` and `least` gives way, and `clip` keeps it. */
static inline double most(double a, double b) { return a > b ? a : b; }
static inline double least(double a, double b) { return a < b ? a : b; }
static inline double clip(double a, double low) { return a < low ? low : a; }

static inline void take(Row to, const Field *from, long first, long direction, long design, long count) {
    const double *at = from->at + first * from->step[0] + direction * from->step[1] + design * from->step[2];
    if (from->step[2])
        for (long j = 0; j < WIDTH; j++) to[j] = at[j < count ? j : 0];
    else
        for (long j = 0; j < WIDTH; j++) to[j] = *at;
}

/* Designs in one direction: what does not depend on the angle. */
typedef struct {
    Row c_x, c_y, x_arm, y_arm, ratio, radius, moment, unilateral, flexor, common, per_common, per_radius,
        per_c_x, share_x, share_y, pull_y;
} Designs;

/* And what does. Without a positive moment arm nothing is a number. */
typedef struct {
    Row arm, per_arm, arm_slope, mismatch, torque, torque_slope;
} Given;

static inline void set_given(Given *g, const Tile *t, const Designs *d, long angle, long direction, long design,
                             long count) {
    Row flexor_travel, extensor_travel, sine, cosine;
    take(g->arm, &t->arm, angle, direction, design, count);
    take(g->per_arm, &t->per_arm, angle, direction, design, count);
    take(g->arm_slope, &t->arm_slope, angle, direction, design, count);
    take(flexor_travel, &t->flexor_travel, angle, direction, design, count);
    take(extensor_travel, &t->extensor_travel, angle, direction, design, count);
    take(sine, &t->sine, angle, direction, design, count);
    take(cosine, &t->cosine, angle, direction, design, count);
    for (long j = 0; j < WIDTH; j++) {
        g->mismatch[j] = extensor_travel[j] - d->ratio[j] * flexor_travel[j];
        g->torque[j] = d->moment[j] * sine[j];
        g->torque_slope[j] = d->moment[j] * cosine[j];
    }
}

static void set_designs(Designs *d, const Tile *t, long direction, long design, long count) {
    const Field *from[] = {&t->flexor_compliance, &t->extensor_compliance, &t->flexor_arm, &t->extensor_arm, &t->ratio,
                           &t->radius, &t->moment, &t->unilateral};
    double *to[] = {d->c_x, d->c_y, d->x_arm, d->y_arm, d->ratio, d->radius, d->moment, d->unilateral};
    for (int i = 0; i < 8; i++) take(to[i], from[i], 0, direction, design, count);
    for (long j = 0; j < WIDTH; j++) {
        d->flexor[j] = d->ratio[j] * d->c_x[j];
        d->common[j] = d->flexor[j] + d->c_y[j];
        d->per_common[j] = 1.0 / d->common[j], d->per_radius[j] = 1.0 / d->radius[j], d->per_c_x[j] = 1.0 / d->c_x[j];
        d->share_x[j] = d->flexor[j] * d->per_common[j], d->share_y[j] = d->c_y[j] * d->per_common[j];
        d->pull_y[j] = d->radius[j] * d->radius[j] / d->c_y[j];
    }
}

/* The lines of one angle: statics.respond and lines.Lines, of unilateral tendons. */
static inline void set_lines(Lines *restrict l, const Given *restrict g, const Designs *restrict d) {
    for (long j = 0; j < WIDTH; j++) {
        double R = d->radius[j], J = g->arm[j], torque = g->torque[j], per_arm = g->per_arm[j];
        double x = clip(torque * per_arm, 0.0), y = clip(-torque * d->per_radius[j], 0.0), load = clip(x, y);
        double spread = d->share_x[j] * R + d->share_y[j] * J;
        double x_gain = R / spread, y_gain = x_gain * (J * d->per_radius[j]);
        double shortfall = d->share_x[j] * x + d->share_y[j] * y - g->mismatch[j] * d->per_common[j];
        double near = TOLERANCE * clip(load, fabs(shortfall)) * spread;
        double limit = shortfall - near * (torque < 0.0 ? d->per_radius[j] : per_arm);
        double pull_x = J * J * d->per_c_x[j], pull_y = d->pull_y[j];
        double k = pull_x + pull_y + (g->torque_slope[j] - g->arm_slope[j] * x);
        double first = torque < 0.0 ? pull_x : pull_y, other = torque < 0.0 ? pull_y : pull_x;
        double idle = load <= TOLERANCE * fabs(shortfall) ? 1.0 : 0.0;
        l->shortfall[j] = shortfall, l->lowest[j] = 0.0, l->limit[j] = limit, l->idle[j] = idle;
        l->x[j] = x, l->x_gain[j] = x_gain, l->y[j] = y, l->y_gain[j] = y_gain;
        l->motor[j] = x * d->x_arm[j] - y * d->y_arm[j];
        l->motor_gain[j] = x_gain * d->x_arm[j] - y_gain * d->y_arm[j];
        l->k[j] = k, l->k_gain[j] = -g->arm_slope[j] * x_gain, l->k_slack[j] = k - (first + idle * other);
    }
}

/* The paper's bilateral tendons go on along the same lines: statics._side_limits says where they count as slack. */
static void set_bilateral(Lines *l, const Given *g, const Designs *d) {
    for (long j = 0; j < WIDTH; j++) {
        double at_x = g->torque[j] / g->arm[j], at_y = -g->torque[j] / d->radius[j];
        double for_y = (d->flexor[j] * at_x - g->mismatch[j]) / d->common[j];
        double for_x = (d->c_y[j] * at_y - g->mismatch[j]) / d->common[j];
        double limit_x = for_x - TOLERANCE * clip(fabs(at_y), fabs(for_x)) / l->x_gain[j];
        double limit_y = for_y - TOLERANCE * clip(fabs(at_x), fabs(for_y)) / l->y_gain[j];
        if (d->unilateral[j] == 0.0)
            l->limit[j] = most(limit_x, limit_y), l->lowest[j] = -INFINITY, l->k_slack[j] = INFINITY;
    }
}

/* What no pretension changes: how far states are from slack, and on which side. */
static inline void look_aside(Row *restrict aside, const Lines *restrict l, const Given *restrict g) {
    for (long j = 0; j < WIDTH; j++) {
        double limit = l->limit[j], shortfall = l->shortfall[j], nowhere = limit == limit ? 0.0 : 1.0;
        double alone = l->idle[j] == 0.0 ? 1.0 - nowhere : 0.0, backward = g->torque[j] < 0.0 ? alone : 0.0;
        double forward = alone - backward;
        aside[SHORTFALL][j] = most(shortfall, aside[SHORTFALL][j]);
        aside[FLEXOR_SHORTFALL][j] = most(backward > 0.0 ? shortfall : -INFINITY, aside[FLEXOR_SHORTFALL][j]);
        aside[FLEXOR_LIMIT][j] = most(backward > 0.0 ? limit : -INFINITY, aside[FLEXOR_LIMIT][j]);
        aside[EXTENSOR_SHORTFALL][j] = most(forward > 0.0 ? shortfall : -INFINITY, aside[EXTENSOR_SHORTFALL][j]);
        aside[EXTENSOR_LIMIT][j] = most(forward > 0.0 ? limit : -INFINITY, aside[EXTENSOR_LIMIT][j]);
        aside[ONE_SIDED][j] = most(alone, aside[ONE_SIDED][j]);
        aside[BOTH_LIMIT][j] = least(l->idle[j] > 0.0 ? limit : INFINITY, aside[BOTH_LIMIT][j]);
        aside[NOWHERE][j] += nowhere;
        aside[LOW_TORQUE][j] = least(g->arm[j] > 0.0 ? g->torque[j] : INFINITY, aside[LOW_TORQUE][j]);
        aside[HIGH_TORQUE][j] = most(g->arm[j] > 0.0 ? g->torque[j] : -INFINITY, aside[HIGH_TORQUE][j]);
    }
}

/* All angles of a stretch before any pretension. */
FOR_EACH_PROCESSOR
static void prepare(Lines *lines, Row aside[ASIDE], const Tile *t, const Designs *d, long from, long angles,
                    long direction, long design, long count) {
    for (long i = 0; i < angles; i++) {
        Given g;
        set_given(&g, t, d, from + i, direction, design, count);
        set_lines(lines + i, &g, d);
        if (t->any_bilateral) set_bilateral(lines + i, &g, d);
        look_aside(aside, lines + i, &g);
    }
}

/* One angle at one pretension. */
static inline void over_designs(Row *restrict found, const Lines *restrict l, double angle, const double *restrict p) {
    for (long j = 0; j < WIDTH; j++) {
        double v = clip(p[j] - l->shortfall[j], l->lowest[j]);
        double x = l->x_gain[j] * v + l->x[j], y = l->y_gain[j] * v + l->y[j];
        double motor = l->motor_gain[j] * v + l->motor[j], taut = l->k_gain[j] * v + l->k[j];
        double k = p[j] < l->limit[j] ? least(l->k_slack[j], taut) : taut;
        found[LOW_X][j] = least(x, found[LOW_X][j]), found[HIGH_X][j] = most(x, found[HIGH_X][j]);
        found[LOW_Y][j] = least(y, found[LOW_Y][j]), found[HIGH_Y][j] = most(y, found[HIGH_Y][j]);
        found[LOW_MOTOR][j] = least(motor, found[LOW_MOTOR][j]);
        found[HIGH_MOTOR][j] = most(motor, found[HIGH_MOTOR][j]);
        found[STIFFNESS][j] = least(k, found[STIFFNESS][j]);
        found[UNSTABLE][j] += k < 0.0 ? 1.0 : 0.0;
        found[SLACK][j] += p[j] < l->limit[j] ? 1.0 : 0.0;
        found[FIRST][j] = least(p[j] < l->limit[j] ? angle : INFINITY, found[FIRST][j]);
    }
}

/* All angles at one pretension. */
FOR_EACH_PROCESSOR
static void over_angles(Row found[BY_PRETENSION], const Lines *lines, const double *angle, long angles,
                        const Row pretension) {
    for (long i = 0; i < angles; i++) over_designs(found, lines + i, angle[i], pretension);
}

/* Some designs in one direction at a stretch of angles, into what was found at the angles before. */
static void over_pretensions(const Tile *t, Seen *s, const Lines *lines, long from, long angles, long direction,
                             long design, long count) {
    for (long p = 0; p < t->pretensions; p++) {
        long at = (p * t->directions + direction) * t->designs + design;
        Row found[BY_PRETENSION], pretension;
        take(pretension, &t->pretension, p, direction, design, count);
        for (int r = 0; r < BY_PRETENSION; r++)
            for (long j = 0; j < WIDTH; j++) found[r][j] = from && j < count ? s->by_pretension[r][at + j] : BEGIN[r];
        over_angles(found, lines, t->angle + from, angles, pretension);
        for (int r = 0; r < BY_PRETENSION; r++)
            for (long j = 0; j < count; j++) s->by_pretension[r][at + j] = found[r][j];
    }
}

/* Returns nought, or one where there is no memory. */
int tendon_look(const Tile *t, Seen *s) {
    Lines *lines = aligned_alloc(64, ANGLES * sizeof(Lines));
    if (!lines) return 1;
    for (long direction = 0; direction < t->directions; direction++)
        for (long design = 0; design < t->designs; design += WIDTH) {
            long count = t->designs - design < WIDTH ? t->designs - design : WIDTH;
            Row aside[ASIDE];
            Designs d;
            set_designs(&d, t, direction, design, count);
            for (int r = 0; r < ASIDE; r++)
                for (long j = 0; j < WIDTH; j++) aside[r][j] = BEGIN_ASIDE[r];
            for (long from = 0; from < t->angles; from += ANGLES) {
                long angles = t->angles - from < ANGLES ? t->angles - from : ANGLES;
                prepare(lines, aside, t, &d, from, angles, direction, design, count);
                over_pretensions(t, s, lines, from, angles, direction, design, count);
            }
            for (int r = 0; r < ASIDE; r++)
                for (long j = 0; j < count; j++) s->aside[r][direction * t->designs + design + j] = aside[r][j];
        }
    free(lines);
    return 0;
}
