/* The designs table by a fused loop in C: what the kernel of tendon is measured against.
 *
 * Hoisted to where it varies, as anyone would who writes this by hand:
 *   angle                                    travels, moment arm and its slope, sine and cosine (tables from outside)
 *   friction, direction                      capstan ratios, compliance of the tendon (tables from outside)
 *   spring, ratio, friction, load            "lines": each state's tensions, motor torque and stiffness as
 *     (and direction, angle)                 straight lines in pretension, and where they kink. All divisions are here.
 *   pretension, direction, angle             the inner loop, `over_states`: per state a difference, a maximum, five
 *                                            multiply-adds, ten reductions. No division, no branch, vectorised.
 * What an extreme over states does not need the inner loop for is taken from the lines: required pretension, margin,
 * longest slack, elbow torque. Unilateral tendons; only states with a positive moment arm come in. No NaN goes through
 * arithmetic, so the compiler may take it that there is none.
 */

#include <math.h>

#define MOST_ANGLES 1016  /* no power of two: arrays a multiple of 4 kB apart evict each other from the cache */
#define NEVER (-1e300)
#define TOLERANCE 1e-9
#define NOT_A_NUMBER __builtin_nan("")

enum { MIN_X, MIN_Y, MAX_TENSION, MAX_SPRING, PEAK_ELBOW, PEAK_MOTOR, MIN_STIFFNESS, MAX_SLACK, SLACK_SHARE,
       UNSTABLE_SHARE, FIRST_SLACK, REQUIRED, MARGIN, TAUT, RESULTS };

typedef struct {
    long pretensions, springs, ratios, frictions, loads, angles, without;  /* `without`: states with no equilibrium */
    double elbow_radius, flexor_radius;
    const double *pretension, *spring, *ratio, *load_moment;               /* axes */
    const double *angle, *arm, *arm_slope, *flexor_travel, *extensor_travel, *sine, *cosine;   /* by angle */
    const double *capstan, *tendon;         /* by friction; flexor's and extensor's in flexion, swapped in extension */
    double *out;                                                            /* results by column, then design */
} Study;

typedef struct {
    _Alignas(64) double kink[MOST_ANGLES], limit[MOST_ANGLES];              /* shortfall; slack below */
    double x[MOST_ANGLES], x_gain[MOST_ANGLES], y[MOST_ANGLES], y_gain[MOST_ANGLES];
    double motor[MOST_ANGLES], motor_gain[MOST_ANGLES], stiffness[MOST_ANGLES], lost[MOST_ANGLES];
    double capstan_x, capstan_y, common, ratio;
    double low_torque, high_torque;
    double most_kink, kink_x, kink_y, limit_x, limit_y, limit_both;         /* by the side that goes slack */
} Lines;

typedef struct {
    double low_x, high_x, low_y, high_y, low_motor, high_motor, stiffness, first, slack, unstable;
} Found;

static inline double least(double a, double b) { return a < b ? a : b; }
static inline double most(double a, double b) { return a > b ? a : b; }

/* Which side goes slack first below a state's shortfall, and from which pretension on. */
static inline void note_side(Lines *l, long i, double torque, double at_x, double at_y, double kink, int idle) {
    int on_x = torque < 0.0;
    double tolerance = TOLERANCE * most(fabs(on_x ? at_y : at_x), fabs(kink)) / (on_x ? l->x_gain[i] : l->y_gain[i]);
    l->limit[i] = kink - tolerance;
    if (idle) {
        l->limit_both = least(l->limit_both, l->limit[i]);
    } else if (on_x) {
        l->kink_x = most(l->kink_x, kink), l->limit_x = most(l->limit_x, l->limit[i]);
    } else {
        l->kink_y = most(l->kink_y, kink), l->limit_y = most(l->limit_y, l->limit[i]);
    }
}

/* The lines of one spring, ratio, friction and load in one direction: everything but pretension. */
static void set_lines(Lines *l, const Study *s, double c_x, double c_y, double load_moment) {
    double radius = s->elbow_radius, ratio = l->ratio, common = ratio * c_x + c_y;
    double x_arm = s->flexor_radius / l->capstan_x, y_arm = ratio * s->flexor_radius / l->capstan_y;
    l->common = common, l->limit_both = l->low_torque = -NEVER, l->high_torque = NEVER;
    l->most_kink = l->kink_x = l->kink_y = l->limit_x = l->limit_y = NEVER;
    for (long i = 0; i < s->angles; i++) {
        double arm = s->arm[i], torque = load_moment * s->sine[i];
        double mismatch = s->extensor_travel[i] - ratio * s->flexor_travel[i];
        double at_x = torque / arm, at_y = -torque / radius;
        double gain = common / (ratio * c_x * radius + arm * c_y);
        double kink = (most(ratio * c_x * at_x, c_y * at_y) - mismatch) / common;
        double floor_x = most(at_x, 0.0), floor_y = most(at_y, 0.0);
        int idle = most(floor_x, floor_y) <= TOLERANCE * fabs(kink);
        double pull_x = arm * arm / c_x, pull_y = radius * radius / c_y;
        l->low_torque = least(l->low_torque, torque), l->high_torque = most(l->high_torque, torque);
        l->kink[i] = kink, l->most_kink = most(l->most_kink, kink);
        l->x[i] = floor_x, l->x_gain[i] = radius * gain;
        l->y[i] = floor_y, l->y_gain[i] = arm * gain;
        l->motor[i] = floor_x * x_arm - floor_y * y_arm;
        l->motor_gain[i] = l->x_gain[i] * x_arm - l->y_gain[i] * y_arm;
        l->stiffness[i] = pull_x + pull_y + load_moment * s->cosine[i];
        l->lost[i] = idle ? pull_x + pull_y : torque < 0.0 ? pull_x : pull_y;
        note_side(l, i, torque, at_x, at_y, kink, idle);
    }
}

/* The inner loop: all states of one direction at one pretension. Plain locals, for else it is not vectorised. */
static Found over_states(const Lines *restrict l, const Study *restrict s, double pretension) {
    const double *restrict slope = s->arm_slope, *restrict angle = s->angle;
    double low_x = -NEVER, high_x = NEVER, low_y = -NEVER, high_y = NEVER, low_motor = -NEVER, high_motor = NEVER;
    double least_stiffness = -NEVER, first = -NEVER, slack = 0.0, unstable = 0.0;
    const long angles = s->angles;
    for (long i = 0; i < angles; i++) {
        double taking = most(pretension - l->kink[i], 0.0);
        double x = l->x[i] + l->x_gain[i] * taking, y = l->y[i] + l->y_gain[i] * taking;
        double motor = l->motor[i] + l->motor_gain[i] * taking;
        double is_slack = pretension < l->limit[i] ? 1.0 : 0.0;
        double stiffness = l->stiffness[i] - x * slope[i] - is_slack * l->lost[i];
        double slack_angle = pretension < l->limit[i] ? angle[i] : -NEVER;
        low_x = least(low_x, x), high_x = most(high_x, x);
        low_y = least(low_y, y), high_y = most(high_y, y);
        low_motor = least(low_motor, motor), high_motor = most(high_motor, motor);
        least_stiffness = least(least_stiffness, stiffness), first = least(first, slack_angle);
        slack += is_slack, unstable += stiffness < 0.0 ? 1.0 : 0.0;
    }
    return (Found){low_x, high_x, low_y, high_y, low_motor, high_motor, least_stiffness, first, slack, unstable};
}

/* The longest slack in a direction: below a shortfall there are `common` metres of loose path per newton. */
static double longest_slack(const Lines *l, double pretension) {
    double on_x = pretension < l->limit_x ? l->common / l->ratio * (l->kink_x - pretension) : 0.0;
    double on_y = pretension < l->limit_y ? l->common * (l->kink_y - pretension) : 0.0;
    return most(0.0, most(on_x, on_y));
}

static inline double larger(double low, double high) { return -low > high ? low : high; }

/* The results of a design from both directions, into row `at` of the columns. */
static void put(const Study *s, const Lines l[2], const Found f[2], double pretension, double spring, long at) {
    long designs = s->pretensions * s->springs * s->ratios * s->frictions * s->loads;
    double r[RESULTS] = {-NEVER, -NEVER, NEVER, NEVER}, low_motor = -NEVER, high_motor = NEVER, need = NEVER;
    double states = 2.0 * (double)s->angles + (double)s->without;
    int told = 0;
    r[MIN_STIFFNESS] = r[FIRST_SLACK] = -NEVER, r[MAX_SLACK] = 0.0;
    for (int d = 0; d < 2; d++) {
        r[MIN_X] = least(r[MIN_X], least(f[d].low_x, f[d].low_x / l[d].capstan_x));
        r[MIN_Y] = least(r[MIN_Y], least(f[d].low_y, f[d].low_y / l[d].capstan_y));
        r[MAX_TENSION] = most(r[MAX_TENSION], most(most(f[d].high_x, f[d].high_x / l[d].capstan_x),
                                                   most(f[d].high_y, f[d].high_y / l[d].capstan_y)));
        r[MAX_SPRING] = most(r[MAX_SPRING], most(f[d].high_x, f[d].high_y) / spring);
        low_motor = least(low_motor, f[d].low_motor), high_motor = most(high_motor, f[d].high_motor);
        r[MIN_STIFFNESS] = least(r[MIN_STIFFNESS], f[d].stiffness), r[FIRST_SLACK] = least(r[FIRST_SLACK], f[d].first);
        r[MAX_SLACK] = most(r[MAX_SLACK], longest_slack(&l[d], pretension));
        need = most(need, l[d].most_kink);
        told |= l[d].limit_x > NEVER || l[d].limit_y > NEVER || pretension >= l[d].limit_both;
    }
    r[PEAK_ELBOW] = larger(l[0].low_torque, l[0].high_torque), r[PEAK_MOTOR] = larger(low_motor, high_motor);
    r[SLACK_SHARE] = (f[0].slack + f[1].slack + (double)s->without) / states;
    r[UNSTABLE_SHARE] = (f[0].unstable + f[1].unstable) / states;
    r[REQUIRED] = most(0.0, need), r[MARGIN] = least(pretension - need, pretension);
    r[TAUT] = r[SLACK_SHARE] == 0.0;
    if (r[FIRST_SLACK] == -NEVER) r[FIRST_SLACK] = NOT_A_NUMBER;
    if (s->without) r[REQUIRED] = r[MARGIN] = NOT_A_NUMBER;
    if (!told) r[MAX_SLACK] = NOT_A_NUMBER;
    for (int column = 0; column < RESULTS; column++) s->out[column * designs + at] = r[column];
}

/* All pretensions of the combinations `from` to `to` of spring, ratio, friction and load (the last one fastest). */
void sweep(const Study *s, long from, long to) {
    long combinations = s->springs * s->ratios * s->frictions * s->loads;
    Lines l[2];
    Found f[2];
    for (long c = from; c < to; c++) {
        long by_friction = c / s->loads, by_ratio = by_friction / s->frictions;
        double load = s->load_moment[c % s->loads], spring = s->spring[by_ratio / s->ratios];
        const double *capstan = s->capstan + 2 * (by_friction % s->frictions);
        const double *tendon = s->tendon + 2 * (by_friction % s->frictions);
        for (int d = 0; d < 2; d++) {
            l[d].ratio = s->ratio[by_ratio % s->ratios];
            l[d].capstan_x = capstan[d], l[d].capstan_y = capstan[1 - d];
            set_lines(&l[d], s, tendon[d] + 1.0 / spring, tendon[1 - d] + 1.0 / spring, load);
        }
        for (long p = 0; p < s->pretensions; p++) {
            for (int d = 0; d < 2; d++) f[d] = over_states(&l[d], s, s->pretension[p]);
            put(s, l, f, s->pretension[p], spring, p * combinations + c);
        }
    }
}

/* The windows of the combinations `from` to `to`: between which pretensions each state is taut and stable. Over a state's
 * shortfall, the kink, stiffness is a straight line, so it bounds pretension from above where it falls, else from below. */
void windows(const Study *s, long from, long to) {
    long combinations = s->springs * s->ratios * s->frictions * s->loads;
    double radius = s->elbow_radius;
    const double *arm = s->arm, *slope = s->arm_slope;
    for (long c = from; c < to; c++) {
        long by_friction = c / s->loads, by_ratio = by_friction / s->frictions;
        double load = s->load_moment[c % s->loads], spring = s->spring[by_ratio / s->ratios];
        double ratio = s->ratio[by_ratio % s->ratios], low = 0.0, high = -NEVER;
        const double *tendon = s->tendon + 2 * (by_friction % s->frictions);
        for (int d = 0; d < 2; d++) {
            double c_x = tendon[d] + 1.0 / spring, c_y = tendon[1 - d] + 1.0 / spring, common = ratio * c_x + c_y;
            double pull_y = radius * radius / c_y;
            for (long i = 0; i < s->angles; i++) {
                double torque = load * s->sine[i], at_x = torque / arm[i], at_y = -torque / radius;
                double mismatch = s->extensor_travel[i] - ratio * s->flexor_travel[i];
                double kink = (most(ratio * c_x * at_x, c_y * at_y) - mismatch) / common;
                double stiffness = arm[i] * arm[i] / c_x + pull_y + load * s->cosine[i] - most(at_x, 0.0) * slope[i];
                double end = kink + stiffness * (ratio * c_x * radius + arm[i] * c_y) / (common * radius * slope[i]);
                low = most(low, most(kink, slope[i] < 0.0 ? end : NEVER));
                high = least(high, slope[i] > 0.0 ? end : -NEVER);
            }
        }
        s->out[c] = s->without ? NOT_A_NUMBER : low;
        s->out[combinations + c] = s->without || high == -NEVER ? NOT_A_NUMBER : high;
    }
}
