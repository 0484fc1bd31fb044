/* Rows of the states table: what `actuator.evaluate` and `evaluate.state_columns` do in NumPy, to the same bits.
 *
 * Angles lie along the lanes. Results go straight to where the rows of a table are gathered.
 */

#include "lines.h"

/* As `rows.BlockRows` has it: all over (designs, directions, angles), in SI units. `moment_arm` may be negative. */
typedef struct {
    States states;
    Field pretension, flexor_pretension, extensor_pretension, flexor_capstan, extensor_capstan, flexor_tendon,
        extensor_tendon, flexor_spring, extensor_spring, flexor_radius, moment_arm;
    long designs, directions, angles, any_bilateral;
} Block;

/* In the order of `columns.STATE_RESULTS`. */
enum { FLEXOR_PROXIMAL, FLEXOR_DISTAL, EXTENSOR_PROXIMAL, EXTENSOR_DISTAL, FLEXOR_TENDON, EXTENSOR_TENDON, FLEXOR_SPRING,
       EXTENSOR_SPRING, FLEXOR_SLACK, EXTENSOR_SLACK, ELBOW_TORQUE, MOTOR_TORQUE, SPOOL_ANGLE, STIFFNESS, MOMENT_ARM,
       FLEXOR_TRAVEL, EXTENSOR_TRAVEL, RESULTS };

/* A column that says which design or state a row is: copied as it is, of so many bytes a row. */
typedef struct {
    Field from;
    void *to;
    long bytes;
} Key;

/* Where rows go: a column for each result, one for the status, an index into statics.STATUS_NAMES, and the keys. */
typedef struct {
    double *column[RESULTS];
    int *status;
    const Key *key;
    long keys;
} Table;

/* What a design in one direction adds to `Designs`. */
typedef struct {
    Lanes pretension, flexor_pretension, extensor_pretension, flexor_capstan, extensor_capstan, flexor_tendon,
        extensor_tendon, flexor_spring, extensor_spring, flexor_radius, extensor_radius;
} Ends;

/* statics.Balance. */
typedef struct {
    Lanes x, y, loose;
    Mask no_flexor, no_extensor, nowhere;
} Balance;

INLINE Ends ends_at(const Block *b, const Designs *d, long design, long direction) {
    Ends e;
    const Field *from[] = {&b->pretension, &b->flexor_pretension, &b->extensor_pretension, &b->flexor_capstan,
                           &b->extensor_capstan, &b->flexor_tendon, &b->extensor_tendon, &b->flexor_spring,
                           &b->extensor_spring, &b->flexor_radius};
    Lanes *to[] = {&e.pretension, &e.flexor_pretension, &e.extensor_pretension, &e.flexor_capstan,
                   &e.extensor_capstan, &e.flexor_tendon, &e.extensor_tendon, &e.flexor_spring,
                   &e.extensor_spring, &e.flexor_radius};
    for (int i = 0; i < 10; i++) *to[i] = take(from[i], design, direction, 0, 1);
    e.extensor_radius = d->ratio * e.flexor_radius;
    return e;
}

/* statics.solve. */
INLINE Balance balance(const Lines *l, const Given *g, const Designs *d, Lanes pretension, long any_bilateral) {
    Balance b;
    Mask slack = pretension < l->limit, idle = l->idle > 0.0, backward = g->torque < 0.0;
    Lanes lowest = l->lowest;
    b.no_flexor = slack & (idle | backward), b.no_extensor = slack & (idle | ~backward);
    if (any_bilateral) {
        Lanes flexor, extensor;
        side_limits(l, g, d, &flexor, &extensor);
        lowest = pick(d->unilateral, lowest, all(-INFINITY));
        b.no_flexor = (d->unilateral & b.no_flexor) | (~d->unilateral & (pretension < flexor));
        b.no_extensor = (d->unilateral & b.no_extensor) | (~d->unilateral & (pretension < extensor));
    }
    Lanes surplus = pretension - l->shortfall, v = clip(surplus, lowest);
    b.nowhere = ~is_number(g->arm);
    b.x = l->x + l->x_gain * v, b.y = l->y + l->y_gain * v;
    b.loose = pick((b.no_flexor | b.no_extensor | b.nowhere) & d->unilateral, -d->common * surplus, 0.0 * surplus);
    return b;
}

/* actuator._spool_angle. */
INLINE Lanes spool_angle(const Balance *b, const Given *g, const Designs *d, const Ends *e) {
    Lanes by_flexor = (g->flexor_travel + d->c_x * (b->x - e->flexor_pretension)) / e->flexor_radius;
    Lanes by_extensor = (g->extensor_travel - d->c_y * (b->y - e->extensor_pretension)) / e->extensor_radius;
    Lanes angle = pick(b->no_flexor & d->unilateral, by_extensor, by_flexor);
    return pick(b->no_flexor & b->no_extensor & d->unilateral, all(NAN), angle);
}

/* statics.elbow_stiffness. */
INLINE Lanes elbow_stiffness(const Balance *b, const Given *g, const Designs *d) {
    Lanes flexor = g->arm * g->arm / d->c_x, one = all(1.0), none = all(0.0);
    Lanes flexor_pulls = pick(b->no_flexor & d->unilateral, none, one);
    Lanes extensor_pulls = pick(b->no_extensor & d->unilateral, none, one);
    return flexor_pulls * flexor + extensor_pulls * d->pull_y + (g->torque_slope - b->x * g->arm_slope);
}

/* The result columns of as many states as there are lanes. */
INLINE void results_of(Lanes *r, const Balance *b, const Given *g, const Designs *d, const Ends *e, Lanes moment_arm) {
    Lanes flexor_change = b->x - e->flexor_pretension, extensor_change = b->y - e->extensor_pretension;
    Mask both = b->no_flexor & b->no_extensor, on_flexor = b->no_flexor & ~b->no_extensor;
    Lanes known = pick(both | ~d->unilateral, all(NAN), b->loose), nothing = 0.0 * known;
    r[FLEXOR_PROXIMAL] = b->x / e->flexor_capstan, r[FLEXOR_DISTAL] = b->x;
    r[EXTENSOR_PROXIMAL] = b->y / e->extensor_capstan, r[EXTENSOR_DISTAL] = b->y;
    r[FLEXOR_TENDON] = e->flexor_tendon * flexor_change, r[EXTENSOR_TENDON] = e->extensor_tendon * extensor_change;
    r[FLEXOR_SPRING] = e->flexor_spring * flexor_change, r[EXTENSOR_SPRING] = e->extensor_spring * extensor_change;
    r[FLEXOR_SLACK] = pick(on_flexor, known / d->ratio, nothing);
    r[EXTENSOR_SLACK] = pick(on_flexor, nothing, known);
    r[ELBOW_TORQUE] = pick(b->nowhere, all(NAN), g->torque);
    r[MOTOR_TORQUE] = (r[FLEXOR_PROXIMAL] - d->ratio * r[EXTENSOR_PROXIMAL]) * e->flexor_radius;
    r[SPOOL_ANGLE] = spool_angle(b, g, d, e), r[STIFFNESS] = elbow_stiffness(b, g, d);
    r[MOMENT_ARM] = moment_arm, r[FLEXOR_TRAVEL] = g->flexor_travel, r[EXTENSOR_TRAVEL] = g->extensor_travel;
}

INLINE void put_status(int *to, const Balance *b, long count) {
    Mask status = (b->no_flexor & 1) | (b->no_extensor & 2) | (b->nowhere & 4);
    for (long j = 0; j < count; j++) to[j] = (int)status[j];
}

static void copy(const Key *key, long design, long direction, long angle, long angles, long at) {
    const long *step = key->from.step, place = design * step[0] + direction * step[1] + angle * step[2];
    const char *from = (const char *)key->from.at + place * key->bytes;
    char *to = (char *)key->to + at * key->bytes;
    if (step[2]) {
        memcpy(to, from, (unsigned long)(angles * key->bytes));
    } else if (key->bytes == 8) {
        long long value;
        memcpy(&value, from, 8);
        for (long i = 0; i < angles; i++) memcpy(to + 8 * i, &value, 8);
    } else {
        for (long i = 0; i < angles; i++) memcpy(to + key->bytes * i, from, (unsigned long)key->bytes);
    }
}

/* States of a design in one direction from an angle on, into the table from row `at` on; `missing` notes nulls. */
static void line(const Block *b, const Table *t, Mask *missing, long design, long direction, long angle, long angles,
                 long at) {
    Designs d = designs_at(&b->states, design, direction, 0, 1);
    Ends e = ends_at(b, &d, design, direction);
    for (long i = 0; i < t->keys; i++) copy(t->key + i, design, direction, angle, angles, at);
    for (long done = 0; done < angles; done += LANES) {
        long count = angles - done < LANES ? angles - done : LANES, k = angle + done;
        Given g = given_at(&b->states, &d, design, direction, k, count);
        Lines l = lines_of(&g, &d);
        Balance found = balance(&l, &g, &d, e.pretension, b->any_bilateral);
        Lanes result[RESULTS];
        results_of(result, &found, &g, &d, &e, take(&b->moment_arm, design, direction, k, count));
        for (int r = 0; r < RESULTS; r++) {
            put(t->column[r] + at + done, result[r], count);
            missing[r] |= ~is_number(result[r]);
        }
        put_status(t->status + at + done, &found, count);
    }
}

/* Rows `first` to `first + count` of a block, whose last axis is the fastest; notes which results have nulls. */
static void rows(const Block *b, const Table *t, long first, long count, char *nulls) {
    Mask missing[RESULTS];
    memset(missing, 0, sizeof missing);
    for (long done = 0; done < count;) {
        long row = first + done, angle = row % b->angles, of_design = row / b->angles;
        long angles = count - done < b->angles - angle ? count - done : b->angles - angle;
        line(b, t, missing, of_design / b->directions, of_design % b->directions, angle, angles, done);
        done += angles;
    }
    for (int r = 0; r < RESULTS; r++)
        for (int j = 0; j < LANES; j++)
            if (missing[r][j]) nulls[r] = 1;
}
