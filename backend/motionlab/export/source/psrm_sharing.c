/*
 * Force sharing: from a force command to the currents of three phases.
 *
 * A sharing function sets the part of the command for each phase; the inverse of the map gives
 * the current for it; psrm_motor.c has the map. With c_k the most that phase k can give in the
 * commanded direction:
 *
 *     least-norm       F_k = |f| c_k^2/sum c_j^2
 *     force-per-ampere least copper loss, sum i_k^2; what one phase cannot give, another does
 *     sine, cubic      a phase takes over from the one before along (1 - cos pi z)/2 or
 *                      3 z^2 - 2 z^3, in the middle of the half pitch in which it pulls
 *
 * The principle of least norm and of the sine and cubic functions is that of the literature on
 * torque sharing of switched reluctance drives; formula and tables are motionlab's.
 */
#include "psrm_sharing.h"

#include "psrm_math.h"

#define INVERSE_POSITIONS 288U
#define INVERSE_LEVELS 64U
#define SHARE_POSITIONS 240U
#define SHARE_LEVELS 32U

static const double TINY = 1e-30; /* in place of a denominator that vanishes */
static const double COMPLETE = 1e-9; /* relative force that counts as given */
static const double UNBOUNDED = 1e300;

/* One phase in the commanded direction */
typedef struct {
    double turns; /* where it stands in its pole pitch, 0 to 1 */
    double x;     /* S(theta) of the formula, 0 where it pulls the other way */
    double most;  /* thrust at the current limit, N */
    double whole; /* thrust at the largest current of the map, N */
} phase_reach;

static double not_tiny(double x)
{
    return (x > TINY) ? x : TINY;
}

static uint8_t has_table(const psrm_sharing *sharing)
{
    return (sharing->table.positions > 0U) ? 1U : 0U;
}

/* -- the formula ------------------------------------------------------------------------------ */

/* Return the current, A, at which F(i) = y F_pk: i = I_pk sqrt(y/(1 + B (1 - y))). */
static double current_for(const psrm_formula *formula, double y)
{
    return formula->I_pk * psrm_square_root(y / (1.0 + (psrm_saturation(formula) * (1.0 - y))));
}

/* -- tables ----------------------------------------------------------------------------------- */

/*
 * Interpolate nodes, [positions][levels + 1], that repeat after the last position; turns runs from
 * 0 to 1, level from 0 to levels.
 */
static double between_nodes(const double *nodes, uint32_t positions, uint32_t levels, double turns,
                            double level)
{
    double u;
    double w;
    const uint32_t column = psrm_cell(turns * (double)positions, positions, &u);
    const uint32_t row = psrm_cell(level, levels, &w);
    const uint32_t next = (column + 1U) % positions;
    const double *low = &nodes[(column * (levels + 1U)) + row];
    const double *high = &nodes[(next * (levels + 1U)) + row];
    const double near = low[0] + (w * (low[1] - low[0]));

    return near + (u * (high[0] + (w * (high[1] - high[0])) - near));
}

/* -- sharing functions ------------------------------------------------------------------------ */

static void least_norm_shares(const phase_reach phase[PSRM_PHASES], double share[PSRM_PHASES])
{
    double squares = 0.0;
    double scale;
    uint32_t k;

    for (k = 0U; k < PSRM_PHASES; k++) {
        squares = squares + (phase[k].most * phase[k].most);
    }
    scale = 1.0 / not_tiny(squares);
    for (k = 0U; k < PSRM_PHASES; k++) {
        share[k] = phase[k].most * phase[k].most * scale;
    }
}

/*
 * Least copper loss on the formula. With F = G (1 - 1/(1 + B q)) x, G = F_pk (1 + B)/B, the loss
 * sum q is least where sqrt(x_k)/(1 + B q_k) = 1/w for every phase that carries current. At most
 * two phases pull the same way: the stronger one alone, or both.
 */
static void least_loss_shares(const psrm_formula *formula, const phase_reach phase[PSRM_PHASES],
                              double wanted, double share[PSRM_PHASES])
{
    const double B = psrm_saturation(formula);
    const double a = phase[0].x;
    const double b = phase[1].x;
    const double c = phase[2].x;
    const double root[PSRM_PHASES] = {psrm_square_root(a), psrm_square_root(b),
                                      psrm_square_root(c)};
    const double y = wanted / (formula->F_pk * ((1.0 + B) / B));
    const double rest = psrm_clip(a + b + c - y, TINY, UNBOUNDED);
    const double inverse_w = rest / (root[0] + root[1] + root[2]);
    const double pairs = (root[0] * root[1]) + (root[1] * root[2]) + (root[2] * root[0]);
    double strongest = (a > b) ? a : b;
    double sum;
    uint32_t k;

    strongest = (c > strongest) ? c : strongest;
    for (k = 0U; k < PSRM_PHASES; k++) {
        if (pairs > (strongest - y)) {
            share[k] = psrm_positive(phase[k].x - (root[k] * inverse_w));
        } else {
            share[k] = (phase[k].x >= strongest) ? 1.0 : 0.0;
        }
    }
    sum = not_tiny(share[0] + share[1] + share[2]);
    for (k = 0U; k < PSRM_PHASES; k++) {
        share[k] = share[k] * (1.0 / sum);
    }
}

/* Least copper loss from a table of shares over turns and |f|/(what all phases can give). */
static void tabled_shares(const double *table, const phase_reach phase[PSRM_PHASES],
                          double wanted, uint8_t forward, double share[PSRM_PHASES])
{
    const double whole = not_tiny(phase[0].whole + phase[1].whole + phase[2].whole);
    const double level = psrm_clip(wanted / whole, 0.0, 1.0) * (double)SHARE_LEVELS;
    const uint32_t sheet = (forward != 0U) ? 0U : (SHARE_POSITIONS * (SHARE_LEVELS + 1U));
    uint32_t k;

    for (k = 0U; k < PSRM_PHASES; k++) {
        share[k] = between_nodes(&table[sheet], SHARE_POSITIONS, SHARE_LEVELS,
                                 phase[k].turns, level);
    }
}

/* Return the part of a phase by a classical sharing function; the three add up to 1. */
static double classical_share(const psrm_sharing *sharing, double turns, uint8_t forward)
{
    const double place = (forward != 0U) ? turns : (1.0 - turns);
    const double start = (1.0 / 12.0) - (0.5 * sharing->overlap);
    const double per = 1.0 / sharing->overlap;
    const double rise = psrm_clip((place - start) * per, 0.0, 1.0);
    const double fall = psrm_clip((place - start - (1.0 / 3.0)) * per, 0.0, 1.0);
    double unused;
    double cos_rise;
    double cos_fall;
    double share;

    if (sharing->function == PSRM_SHARING_SINE) {
        psrm_sine_cosine(0.5 * rise, &unused, &cos_rise);
        psrm_sine_cosine(0.5 * fall, &unused, &cos_fall);
        share = 0.5 * (cos_fall - cos_rise);
    } else {
        share = (rise * rise * (3.0 - (2.0 * rise))) - (fall * fall * (3.0 - (2.0 * fall)));
    }
    return share;
}

/* Give the part of the command for each phase. */
static void shares(const psrm_sharing *sharing, const phase_reach phase[PSRM_PHASES],
                   double wanted, uint8_t forward, double share[PSRM_PHASES])
{
    uint32_t k;

    switch (sharing->function) {
    case PSRM_SHARING_FORCE_PER_AMPERE:
        if (has_table(sharing) != 0U) {
            tabled_shares(sharing->share, phase, wanted, forward, share);
        } else {
            least_loss_shares(&sharing->formula, phase, wanted, share);
        }
        break;
    case PSRM_SHARING_SINE:
    case PSRM_SHARING_CUBIC:
        for (k = 0U; k < PSRM_PHASES; k++) {
            share[k] = classical_share(sharing, phase[k].turns, forward);
        }
        break;
    case PSRM_SHARING_LEAST_NORM:
    default:
        least_norm_shares(phase, share);
        break;
    }
}

/* -- from a force to currents ----------------------------------------------------------------- */

/* Give where each phase stands and what it can do in the direction of sense, 1 or -1. */
static void reaches(const psrm_sharing *sharing, double position, double sense,
                    phase_reach phase[PSRM_PHASES])
{
    const psrm_formula *formula = &sharing->formula;
    const psrm_table *table = &sharing->table;
    double shape[PSRM_PHASES];
    double turns[PSRM_PHASES];
    double i_max;
    uint32_t k;

    psrm_thrust_shape(formula, position, shape);
    psrm_phase_turns(formula, position, turns);
    for (k = 0U; k < PSRM_PHASES; k++) {
        phase[k].turns = turns[k];
        phase[k].x = psrm_positive(sense * shape[k]);
        if (has_table(sharing) != 0U) {
            i_max = (double)table->currents / table->per_ampere;
            phase[k].most = psrm_positive(
                sense * psrm_table_thrust(table, phase[k].turns, sharing->current_limit));
            phase[k].whole = psrm_positive(sense * psrm_table_thrust(table, phase[k].turns, i_max));
        } else {
            phase[k].whole = formula->F_pk * phase[k].x;
            phase[k].most = phase[k].whole * psrm_force_fraction(formula, sharing->current_limit);
        }
    }
}

/* Return the current, A, at which a phase gives a force, N, in the commanded direction. */
static double phase_current(const psrm_sharing *sharing, const phase_reach *phase, double force)
{
    const psrm_formula *formula = &sharing->formula;
    const double part = force / not_tiny(phase->whole);
    double current;
    double level;

    if (has_table(sharing) != 0U) {
        level = psrm_square_root(psrm_clip(part, 0.0, 1.0)) * (double)INVERSE_LEVELS;
        current = between_nodes(sharing->current, INVERSE_POSITIONS, INVERSE_LEVELS,
                                phase->turns, level);
        current = psrm_clip(current, 0.0, sharing->current_limit);
    } else {
        current = current_for(
            formula, psrm_clip(part, 0.0, psrm_force_fraction(formula, sharing->current_limit)));
    }
    return current;
}

/* Return the force, N, that a current, A, gives in the direction of sense, 1 or -1. */
static double phase_force(const psrm_sharing *sharing, const phase_reach *phase, double sense,
                          double current)
{
    double force;

    if (has_table(sharing) != 0U) {
        force = sense * psrm_table_thrust(&sharing->table, phase->turns, current);
    } else {
        force = phase->whole * psrm_force_fraction(&sharing->formula, current);
    }
    return force;
}

/* The closed form of least-norm on the formula: i_k from y_k = |f| x_k/(F_pk sum x_j^2). */
static uint8_t share_closed(const psrm_sharing *sharing, double position, double command,
                            double current[PSRM_PHASES], double *force)
{
    const psrm_formula *formula = &sharing->formula;
    const double sense = (command > 0.0) ? 1.0 : -1.0;
    const double most = psrm_force_fraction(formula, sharing->current_limit);
    double shape[PSRM_PHASES];
    double squares = 0.0;
    double sum = 0.0;
    double scale;
    double y;
    uint8_t limited = 0U;
    uint32_t k;

    psrm_thrust_shape(formula, position, shape);
    for (k = 0U; k < PSRM_PHASES; k++) {
        shape[k] = psrm_positive(sense * shape[k]);
        squares = squares + (shape[k] * shape[k]);
    }
    scale = psrm_abs(command) / (formula->F_pk * squares);
    for (k = 0U; k < PSRM_PHASES; k++) {
        y = scale * shape[k];
        if (y > most) {
            limited = 1U;
        }
        y = psrm_clip(y, 0.0, most);
        current[k] = current_for(formula, y);
        sum = sum + (y * shape[k]);
    }
    *force = sense * (formula->F_pk * sum);
    return limited;
}

static uint8_t share_by_function(const psrm_sharing *sharing, double position, double command,
                                 double current[PSRM_PHASES], double *force)
{
    const uint8_t forward = (command > 0.0) ? 1U : 0U;
    const double sense = (forward != 0U) ? 1.0 : -1.0;
    const double wanted = psrm_abs(command);
    phase_reach phase[PSRM_PHASES];
    double share[PSRM_PHASES];
    double part[PSRM_PHASES];
    double given = 0.0;
    double left;
    double room;
    double passed;
    uint32_t k;

    reaches(sharing, position, sense, phase);
    shares(sharing, phase, wanted, forward, share);
    for (k = 0U; k < PSRM_PHASES; k++) {
        part[k] = psrm_clip(wanted * share[k], 0.0, phase[k].most);
    }
    if (sharing->function == PSRM_SHARING_FORCE_PER_AMPERE) {
        /* The others make up for a phase at its limit, as far as they can. */
        left = wanted - (part[0] + part[1] + part[2]);
        room = (phase[0].most - part[0]) + (phase[1].most - part[1]) + (phase[2].most - part[2]);
        passed = psrm_clip(left / not_tiny(room), 0.0, 1.0);
        for (k = 0U; k < PSRM_PHASES; k++) {
            part[k] = part[k] + (passed * (phase[k].most - part[k]));
        }
    }
    for (k = 0U; k < PSRM_PHASES; k++) {
        current[k] = phase_current(sharing, &phase[k], part[k]);
        given = given + phase_force(sharing, &phase[k], sense, current[k]);
    }
    *force = sense * given;
    return ((wanted - (part[0] + part[1] + part[2])) > (COMPLETE * wanted)) ? 1U : 0U;
}

uint8_t psrm_share(const psrm_sharing *sharing, double position, double command,
                   double current[PSRM_PHASES], double *force)
{
    uint8_t limited;

    if ((sharing->function == PSRM_SHARING_LEAST_NORM) && (has_table(sharing) == 0U)) {
        limited = share_closed(sharing, position, command, current, force);
    } else {
        limited = share_by_function(sharing, position, command, current, force);
    }
    return limited;
}
