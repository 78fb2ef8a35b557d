/*
 * Friction and force map of one axis: of a motor, and of the model that a controller has of it.
 *
 * Phase k = 0, 1, 2 stands at turns_k = (p + offset)/tau - k/3 of its pole pitch, 1/2 is aligned.
 * The thrust of a phase comes from a formula or from a table:
 *
 *     formula  F(i) S(theta), theta = 2 pi turns
 *              S = (sin theta + h_2 sin 2 theta + h_3 sin 3 theta)/(1 - h_3)
 *              F(i) = F_pk (1 + B) q/(1 + B q), q = (i/I_pk)^2, B = (I_pk/I_knee)^2
 *     table    dW'/dx of a bicubic co-energy, one polynomial of 12 terms for each cell
 */
#ifndef PSRM_MOTOR_H
#define PSRM_MOTOR_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define PSRM_AXES 2U   /* x, y */
#define PSRM_PHASES 3U /* a, b, c of each axis */

/* LuGre friction */
typedef struct {
    double sigma_0; /* bristle stiffness, N/m */
    double sigma_1; /* bristle damping, N s/m */
    double sigma_2; /* viscous friction, N s/m */
    double F_c;     /* Coulomb friction, N */
    double F_s;     /* stiction, N */
    double v_s;     /* Stribeck velocity, m/s */
} psrm_friction;

/* Thrust of a phase over position and current: a formula, or the table in its place */
typedef struct {
    double tau;    /* pole pitch, m */
    double offset; /* commutation offset, m */
    double F_pk;   /* thrust of one phase at I_pk, N */
    double I_pk;   /* peak current, A */
    double I_knee; /* current at which saturation sets in, A */
    double h_2;    /* second harmonic of the thrust over position, 1 */
    double h_3;    /* third harmonic, 1 */
} psrm_formula;

typedef struct {
    const double *thrust; /* cells of thrust, [positions][currents][12] */
    const double *normal; /* cells of normal force, [positions][currents][16]; of a motor only */
    uint32_t positions;   /* cells in a pole pitch; 0: the formula holds */
    uint32_t currents;    /* cells from 0 A to the largest current */
    double per_ampere;    /* cells in an ampere, 1/A */
    double gain;          /* factor on the forces, 1 */
} psrm_table;

/* Return the steady sliding force sigma_0 g(v), N, without viscous friction: eq. (22). */
double psrm_stribeck(const psrm_friction *friction, double v);

/* Give sin and cos of theta of each phase at a position, m. */
void psrm_electrical_angle(const psrm_formula *formula, double position, double sine[PSRM_PHASES],
                           double cosine[PSRM_PHASES]);

/* Give S(theta) of each phase. */
void psrm_thrust_shape(const psrm_formula *formula, double position, double shape[PSRM_PHASES]);

/* Return B = (I_pk/I_knee)^2. */
double psrm_saturation(const psrm_formula *formula);

/* Return F(i)/F_pk. */
double psrm_force_fraction(const psrm_formula *formula, double i);

/* Give where each phase stands in its pole pitch, 0 to 1. */
void psrm_phase_turns(const psrm_formula *formula, double position, double turns[PSRM_PHASES]);

/* Return the cell of a place counted in cells, and give the place in it, 0 to 1. */
uint32_t psrm_cell(double place, uint32_t cells, double *in_cell);

/* Return the thrust of one phase, N, at turns of its pole pitch and current i, A. */
double psrm_table_thrust(const psrm_table *table, double turns, double i);

/* Return its normal force, N. */
double psrm_table_normal(const psrm_table *table, double turns, double i);

#ifdef __cplusplus
}
#endif

#endif
