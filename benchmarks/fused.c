/* The designs table by a fused loop in C: what the kernel of tendon is measured against.
 *
 * Hoisted to where it varies, as anyone would who writes this by hand:
 *   angle                          travels, moment arm and its slope, sine and cosine
 *                                  (tables from outside)
 *   friction, direction            capstan ratios, compliance of the tendon (tables from outside)
 *   spring, ratio, friction, load  "lines": each state's tensions, motor torque and stiffness as
 *     (and direction, angle)       straight lines in pretension, and where they kink. All
 *                                  divisions are here.
 *   pretension, direction, angle   the inner loop, `over_states`: per state a difference, a
 *                                  maximum, five multiply-adds, ten reductions. No division, no
 *                                  branch, vectorised.
 * An extreme over states that does not need the inner loop is taken from the lines: required
 * pretension, margin, longest slack, elbow torque. Unilateral tendons; only states with a positive
 * moment arm come in. No NaN goes through arithmetic, so the compiler may suppose that there is
 * none.
 *
 * x is the flexor and y the extensor, each by its tension at the elbow.
 */

#include <math.h>

/* No power of two: arrays a multiple of 4 kB apart evict each other from the cache. */
#define MOST_ANGLES 1016
#define NEVER (-1e300)
#define TOLERANCE 1e-9
#define NOT_A_NUMBER __builtin_nan("")

/* Columns of the results. */
enum {
    MIN_X,
    MIN_Y,
    MAX_TENSION,
    MAX_SPRING,
    PEAK_ELBOW,
    PEAK_MOTOR,
    MIN_STIFFNESS,
    MAX_SLACK,
    SLACK_SHARE,
    UNSTABLE_SHARE,
    FIRST_SLACK,
    REQUIRED,
    MARGIN,
    TAUT,
    RESULTS
};

typedef struct {
    /* Lengths of the axes; `without` counts the states of a design with no equilibrium. */
    long pretensions;
    long springs;
    long ratios;
    long frictions;
    long loads;
    long angles;
    long without;
    double elbow_radius;
    double flexor_radius;
    /* Axes. */
    const double *pretension;
    const double *spring;
    const double *ratio;
    const double *load_moment;
    /* By angle. */
    const double *angle;
    const double *arm;
    const double *arm_slope;
    const double *flexor_travel;
    const double *extensor_travel;
    const double *sine;
    const double *cosine;
    /* By friction: the flexor's and the extensor's in flexion, swapped in extension. */
    const double *capstan;
    const double *tendon;
    /* Results by column, then design. */
    double *out;
} Study;

/* The states of one spring, ratio, friction and load in one direction, as lines in pretension. */
typedef struct {
    _Alignas(64) double kink[MOST_ANGLES]; /* required pretension: lines bend here */
    double limit[MOST_ANGLES];             /* slack below */
    double x[MOST_ANGLES];
    double x_gain[MOST_ANGLES];
    double y[MOST_ANGLES];
    double y_gain[MOST_ANGLES];
    double motor[MOST_ANGLES];
    double motor_gain[MOST_ANGLES];
    double stiffness[MOST_ANGLES];
    double lost[MOST_ANGLES]; /* stiffness that a slack side takes away */
    double capstan_x;
    double capstan_y;
    double common;
    double ratio;
    double low_torque;
    double high_torque;
    double most_kink;
    /* Largest kink and limit by the side that goes slack. */
    double kink_x;
    double kink_y;
    double limit_x;
    double limit_y;
    double limit_both;
} Lines;

/* Extremes and counts over the states of one direction. */
typedef struct {
    double low_x;
    double high_x;
    double low_y;
    double high_y;
    double low_motor;
    double high_motor;
    double stiffness;
    double first;
    double slack;
    double unstable;
} Extremes;

/* Smaller of two numbers. */
static inline double least(double a, double b) {
    return a < b ? a : b;
}

/* Larger of two numbers. */
static inline double most(double a, double b) {
    return a > b ? a : b;
}

/* Note which side goes slack first below a state's required pretension, and from where on. */
static inline void note_side(Lines *l, long i, double torque, double at_x, double at_y, double kink,
                             int idle) {
    int on_x = torque < 0.0;
    double held = fabs(on_x ? at_y : at_x);
    double gain = on_x ? l->x_gain[i] : l->y_gain[i];
    double tolerance = TOLERANCE * most(held, fabs(kink)) / gain;
    l->limit[i] = kink - tolerance;
    if (idle) {
        l->limit_both = least(l->limit_both, l->limit[i]);
    } else if (on_x) {
        l->kink_x = most(l->kink_x, kink);
        l->limit_x = most(l->limit_x, l->limit[i]);
    } else {
        l->kink_y = most(l->kink_y, kink);
        l->limit_y = most(l->limit_y, l->limit[i]);
    }
}

/* Set the lines of one spring, ratio, friction and load in one direction. */
static void set_lines(Lines *l, const Study *s, double c_x, double c_y, double load_moment) {
    double radius = s->elbow_radius;
    double ratio = l->ratio;
    double common = ratio * c_x + c_y;
    double x_arm = s->flexor_radius / l->capstan_x;
    double y_arm = ratio * s->flexor_radius / l->capstan_y;
    l->common = common;
    l->limit_both = -NEVER;
    l->low_torque = -NEVER;
    l->high_torque = NEVER;
    l->most_kink = NEVER;
    l->kink_x = NEVER;
    l->kink_y = NEVER;
    l->limit_x = NEVER;
    l->limit_y = NEVER;
    for (long i = 0; i < s->angles; i++) {
        double arm = s->arm[i];
        double torque = load_moment * s->sine[i];
        double mismatch = s->extensor_travel[i] - ratio * s->flexor_travel[i];
        double at_x = torque / arm;
        double at_y = -torque / radius;
        double gain = common / (ratio * c_x * radius + arm * c_y);
        double kink = (most(ratio * c_x * at_x, c_y * at_y) - mismatch) / common;
        double floor_x = most(at_x, 0.0);
        double floor_y = most(at_y, 0.0);
        int idle = most(floor_x, floor_y) <= TOLERANCE * fabs(kink);
        double pull_x = arm * arm / c_x;
        double pull_y = radius * radius / c_y;
        l->low_torque = least(l->low_torque, torque);
        l->high_torque = most(l->high_torque, torque);
        l->kink[i] = kink;
        l->most_kink = most(l->most_kink, kink);
        l->x[i] = floor_x;
        l->x_gain[i] = radius * gain;
        l->y[i] = floor_y;
        l->y_gain[i] = arm * gain;
        l->motor[i] = floor_x * x_arm - floor_y * y_arm;
        l->motor_gain[i] = l->x_gain[i] * x_arm - l->y_gain[i] * y_arm;
        l->stiffness[i] = pull_x + pull_y + load_moment * s->cosine[i];
        if (idle) {
            l->lost[i] = pull_x + pull_y;
        } else {
            l->lost[i] = torque < 0.0 ? pull_x : pull_y;
        }
        note_side(l, i, torque, at_x, at_y, kink, idle);
    }
}

/* The inner loop: all states of one direction at one pretension. Plain locals, for else it is not
 * vectorised. */
static Extremes over_states(const Lines *restrict l, const Study *restrict s, double pretension) {
    const double *restrict slope = s->arm_slope;
    const double *restrict angle = s->angle;
    double low_x = -NEVER;
    double high_x = NEVER;
    double low_y = -NEVER;
    double high_y = NEVER;
    double low_motor = -NEVER;
    double high_motor = NEVER;
    double least_stiffness = -NEVER;
    double first = -NEVER;
    double slack = 0.0;
    double unstable = 0.0;
    const long angles = s->angles;
    for (long i = 0; i < angles; i++) {
        double taking = most(pretension - l->kink[i], 0.0);
        double x = l->x[i] + l->x_gain[i] * taking;
        double y = l->y[i] + l->y_gain[i] * taking;
        double motor = l->motor[i] + l->motor_gain[i] * taking;
        double is_slack = pretension < l->limit[i] ? 1.0 : 0.0;
        double stiffness = l->stiffness[i] - x * slope[i] - is_slack * l->lost[i];
        double slack_angle = pretension < l->limit[i] ? angle[i] : -NEVER;
        low_x = least(low_x, x);
        high_x = most(high_x, x);
        low_y = least(low_y, y);
        high_y = most(high_y, y);
        low_motor = least(low_motor, motor);
        high_motor = most(high_motor, motor);
        least_stiffness = least(least_stiffness, stiffness);
        first = least(first, slack_angle);
        slack += is_slack;
        unstable += stiffness < 0.0 ? 1.0 : 0.0;
    }
    return (Extremes){
        .low_x = low_x,
        .high_x = high_x,
        .low_y = low_y,
        .high_y = high_y,
        .low_motor = low_motor,
        .high_motor = high_motor,
        .stiffness = least_stiffness,
        .first = first,
        .slack = slack,
        .unstable = unstable,
    };
}

/* Longest slack in a direction: below the required pretension there are `common` metres of loose
 * path per newton. */
static double longest_slack(const Lines *l, double pretension) {
    double on_x = 0.0;
    double on_y = 0.0;
    if (pretension < l->limit_x) {
        on_x = l->common / l->ratio * (l->kink_x - pretension);
    }
    if (pretension < l->limit_y) {
        on_y = l->common * (l->kink_y - pretension);
    }
    return most(0.0, most(on_x, on_y));
}

/* The one of two ends that is larger in magnitude. */
static inline double larger(double low, double high) {
    return -low > high ? low : high;
}

/* Put the results of a design from both directions into row `row` of the columns. */
static void put(const Study *s, const Lines lines[2], const Extremes extremes[2], double pretension,
                double spring, long row) {
    long designs = s->pretensions * s->springs * s->ratios * s->frictions * s->loads;
    double states = 2.0 * (double)s->angles + (double)s->without;
    double r[RESULTS] = {0.0};
    double low_motor = -NEVER;
    double high_motor = NEVER;
    double required = NEVER;
    double slack = 0.0;
    double unstable = 0.0;
    int has_slack_length = 0;
    r[MIN_X] = -NEVER;
    r[MIN_Y] = -NEVER;
    r[MAX_TENSION] = NEVER;
    r[MAX_SPRING] = NEVER;
    r[MIN_STIFFNESS] = -NEVER;
    r[FIRST_SLACK] = -NEVER;
    for (int d = 0; d < 2; d++) {
        const Lines *l = &lines[d];
        const Extremes *e = &extremes[d];
        double high_x = most(e->high_x, e->high_x / l->capstan_x);
        double high_y = most(e->high_y, e->high_y / l->capstan_y);
        r[MIN_X] = least(r[MIN_X], least(e->low_x, e->low_x / l->capstan_x));
        r[MIN_Y] = least(r[MIN_Y], least(e->low_y, e->low_y / l->capstan_y));
        r[MAX_TENSION] = most(r[MAX_TENSION], most(high_x, high_y));
        r[MAX_SPRING] = most(r[MAX_SPRING], most(e->high_x, e->high_y) / spring);
        low_motor = least(low_motor, e->low_motor);
        high_motor = most(high_motor, e->high_motor);
        r[MIN_STIFFNESS] = least(r[MIN_STIFFNESS], e->stiffness);
        r[FIRST_SLACK] = least(r[FIRST_SLACK], e->first);
        r[MAX_SLACK] = most(r[MAX_SLACK], longest_slack(l, pretension));
        required = most(required, l->most_kink);
        slack += e->slack;
        unstable += e->unstable;
        if (l->limit_x > NEVER || l->limit_y > NEVER || pretension >= l->limit_both) {
            has_slack_length = 1;
        }
    }
    r[PEAK_ELBOW] = larger(lines[0].low_torque, lines[0].high_torque);
    r[PEAK_MOTOR] = larger(low_motor, high_motor);
    r[SLACK_SHARE] = (slack + (double)s->without) / states;
    r[UNSTABLE_SHARE] = unstable / states;
    r[REQUIRED] = most(0.0, required);
    r[MARGIN] = least(pretension - required, pretension);
    r[TAUT] = r[SLACK_SHARE] == 0.0;
    if (r[FIRST_SLACK] == -NEVER) {
        r[FIRST_SLACK] = NOT_A_NUMBER;
    }
    if (s->without) {
        r[REQUIRED] = NOT_A_NUMBER;
        r[MARGIN] = NOT_A_NUMBER;
    }
    if (!has_slack_length) {
        r[MAX_SLACK] = NOT_A_NUMBER;
    }
    for (int column = 0; column < RESULTS; column++) {
        s->out[column * designs + row] = r[column];
    }
}

/* Compute all pretensions of the combinations `from` to `to` of spring, ratio, friction and load
 * (the last one fastest). */
void sweep(const Study *s, long from, long to) {
    long combinations = s->springs * s->ratios * s->frictions * s->loads;
    Lines lines[2];
    Extremes extremes[2];
    for (long c = from; c < to; c++) {
        long by_friction = c / s->loads;
        long by_ratio = by_friction / s->frictions;
        double load = s->load_moment[c % s->loads];
        double spring = s->spring[by_ratio / s->ratios];
        const double *capstan = s->capstan + 2 * (by_friction % s->frictions);
        const double *tendon = s->tendon + 2 * (by_friction % s->frictions);
        for (int d = 0; d < 2; d++) {
            double c_x = tendon[d] + 1.0 / spring;
            double c_y = tendon[1 - d] + 1.0 / spring;
            lines[d].ratio = s->ratio[by_ratio % s->ratios];
            lines[d].capstan_x = capstan[d];
            lines[d].capstan_y = capstan[1 - d];
            set_lines(&lines[d], s, c_x, c_y, load);
        }
        for (long p = 0; p < s->pretensions; p++) {
            for (int d = 0; d < 2; d++) {
                extremes[d] = over_states(&lines[d], s, s->pretension[p]);
            }
            put(s, lines, extremes, s->pretension[p], spring, p * combinations + c);
        }
    }
}

/* Compute the windows of the combinations `from` to `to`: the pretensions at which all states are
 * taut and stable. Above a state's required pretension, the kink, stiffness is a straight line, so
 * it bounds pretension from above where it falls, else from below. */
void windows(const Study *s, long from, long to) {
    long combinations = s->springs * s->ratios * s->frictions * s->loads;
    double radius = s->elbow_radius;
    const double *arm = s->arm;
    const double *slope = s->arm_slope;
    for (long c = from; c < to; c++) {
        long by_friction = c / s->loads;
        long by_ratio = by_friction / s->frictions;
        double load = s->load_moment[c % s->loads];
        double spring = s->spring[by_ratio / s->ratios];
        double ratio = s->ratio[by_ratio % s->ratios];
        double low = 0.0;
        double high = -NEVER;
        const double *tendon = s->tendon + 2 * (by_friction % s->frictions);
        for (int d = 0; d < 2; d++) {
            double c_x = tendon[d] + 1.0 / spring;
            double c_y = tendon[1 - d] + 1.0 / spring;
            double common = ratio * c_x + c_y;
            double pull_y = radius * radius / c_y;
            for (long i = 0; i < s->angles; i++) {
                double torque = load * s->sine[i];
                double at_x = torque / arm[i];
                double at_y = -torque / radius;
                double mismatch = s->extensor_travel[i] - ratio * s->flexor_travel[i];
                double kink = (most(ratio * c_x * at_x, c_y * at_y) - mismatch) / common;
                double pull = arm[i] * arm[i] / c_x + pull_y;
                double stiffness = pull + load * s->cosine[i] - most(at_x, 0.0) * slope[i];
                double both = ratio * c_x * radius + arm[i] * c_y;
                double end = kink + stiffness * both / (common * radius * slope[i]);
                low = most(low, most(kink, slope[i] < 0.0 ? end : NEVER));
                high = least(high, slope[i] > 0.0 ? end : -NEVER);
            }
        }
        int has_high = !s->without && high != -NEVER;
        s->out[c] = s->without ? NOT_A_NUMBER : low;
        s->out[combinations + c] = has_high ? high : NOT_A_NUMBER;
    }
}
