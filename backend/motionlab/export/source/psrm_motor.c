#include "psrm_motor.h"

#include "psrm_math.h"

#define THRUST_TERMS 12U
#define NORMAL_TERMS 16U

static const double HALF_SQRT_3 = 0.8660254037844386;

double psrm_stribeck(const psrm_friction *friction, double v)
{
    const double w = 1.0 / (friction->v_s * friction->v_s);
    const double fade = psrm_exponential(-(v * v * w));

    return friction->F_c + ((friction->F_s - friction->F_c) * fade);
}

/* -- the formula ------------------------------------------------------------------------------ */

void psrm_electrical_angle(const psrm_formula *formula, double position, double sine[PSRM_PHASES],
                           double cosine[PSRM_PHASES])
{
    double s;
    double c;

    psrm_sine_cosine((position + formula->offset) * (1.0 / formula->tau), &s, &c);
    sine[0] = s;
    sine[1] = (-0.5 * s) - (HALF_SQRT_3 * c);
    sine[2] = (-0.5 * s) + (HALF_SQRT_3 * c);
    cosine[0] = c;
    cosine[1] = (-0.5 * c) + (HALF_SQRT_3 * s);
    cosine[2] = (-0.5 * c) - (HALF_SQRT_3 * s);
}

void psrm_thrust_shape(const psrm_formula *formula, double position, double shape[PSRM_PHASES])
{
    const double scale = 1.0 / (1.0 - formula->h_3);
    const double twice_h_2 = 2.0 * formula->h_2;
    double s;
    double third;
    double sine[PSRM_PHASES];
    double cosine[PSRM_PHASES];
    uint32_t k;

    psrm_electrical_angle(formula, position, sine, cosine);
    s = sine[0];
    third = formula->h_3 * (s * (3.0 - (4.0 * (s * s)))); /* sin 3 theta of every phase */
    for (k = 0U; k < PSRM_PHASES; k++) {
        shape[k] = ((sine[k] * (1.0 + (twice_h_2 * cosine[k]))) + third) * scale;
    }
}

double psrm_saturation(const psrm_formula *formula)
{
    const double knee = formula->I_pk * (1.0 / formula->I_knee);

    return knee * knee;
}

double psrm_force_fraction(const psrm_formula *formula, double i)
{
    const double B = psrm_saturation(formula);
    const double ratio = i * (1.0 / formula->I_pk);
    const double q = ratio * ratio;

    return (1.0 + B) * q / (1.0 + (B * q));
}

/* -- tables ----------------------------------------------------------------------------------- */

void psrm_phase_turns(const psrm_formula *formula, double position, double turns[PSRM_PHASES])
{
    static const double BEHIND[PSRM_PHASES] = {0.0, 1.0 / 3.0, 2.0 / 3.0};
    const double first = (position + formula->offset) * (1.0 / formula->tau);
    double place;
    uint32_t k;

    for (k = 0U; k < PSRM_PHASES; k++) {
        place = first - BEHIND[k];
        turns[k] = place - psrm_floor(place);
    }
}

uint32_t psrm_cell(double place, uint32_t cells, double *in_cell)
{
    const double last = (double)cells - 1.0;
    double index = psrm_floor(place);

    if (!(index > 0.0)) { /* NaN too */
        index = 0.0;
    }
    if (index > last) {
        index = last;
    }
    *in_cell = place - index;
    return (uint32_t)index;
}

static double cubic(const double terms[4], double w)
{
    return terms[0] + (w * (terms[1] + (w * (terms[2] + (w * terms[3])))));
}

/* Return the first number of a cell, and give the place in it along position and current. */
static uint32_t first_term(const psrm_table *table, double turns, double i, double *u, double *w)
{
    const uint32_t column = psrm_cell(turns * (double)table->positions, table->positions, u);
    const uint32_t row = psrm_cell(psrm_abs(i) * table->per_ampere, table->currents, w);

    return (column * table->currents) + row;
}

double psrm_table_thrust(const psrm_table *table, double turns, double i)
{
    double u;
    double w;
    const double *terms = &table->thrust[THRUST_TERMS * first_term(table, turns, i, &u, &w)];
    const double p = cubic(&terms[0], w);
    const double q = cubic(&terms[4], w);
    const double r = cubic(&terms[8], w);

    return table->gain * (p + (u * (q + (u * r))));
}

double psrm_table_normal(const psrm_table *table, double turns, double i)
{
    double u;
    double w;
    const double *terms = &table->normal[NORMAL_TERMS * first_term(table, turns, i, &u, &w)];
    const double p = cubic(&terms[0], w);
    const double q = cubic(&terms[4], w);
    const double r = cubic(&terms[8], w);
    const double s = cubic(&terms[12], w);

    return table->gain * (p + (u * (q + (u * (r + (u * s))))));
}
