/*
 * One axis of a planar switched reluctance motor: current loops, force map, LuGre friction, end
 * stops, a structural resonance and the encoder. Mirror of motionlab's plant: the same equations,
 * the same integration, in the same order of evaluation.
 *
 * All numbers are SI.
 */
#ifndef PSRM_PLANT_H
#define PSRM_PLANT_H

#include "psrm_motor.h"

#define PSRM_PLANT_STEP (0.0005 / 5.0) /* s */

typedef struct {
    double bandwidth; /* of the current loops, Hz; 0: currents follow at once */
    double gain[PSRM_PHASES];
    double offset[PSRM_PHASES]; /* A */
    double limit;               /* A */
} psrm_amplifiers;

typedef struct {
    double resolution;    /* m; 0: exact */
    double sde_amplitude; /* of the sub-divisional error, m */
    double sde_period;    /* m */
} psrm_encoder;

typedef struct {
    double frequency; /* Hz */
    double damping;   /* 1 */
    double coupling;  /* 1; 0: none */
} psrm_resonance;

typedef struct {
    double mass;           /* kg */
    double stroke;         /* m */
    double stop_distance;  /* of the end stops beyond the stroke, m */
    double stop_stiffness; /* N/m */
    double stop_damping;   /* N s/m */
    double position_start; /* m */
    double friction_on;    /* 0: a frictionless axis */
    psrm_friction friction;
    psrm_formula force_map;
    double N_pk;     /* normal force of one phase at I_pk, aligned, by the formula, N */
    double map_gain; /* factor on the forces of a table, 1 */
    psrm_amplifiers amplifiers;
    psrm_encoder encoder;
    psrm_resonance resonance;
} psrm_plant_parameters;

typedef struct {
    double current[PSRM_PHASES]; /* commands, A */
    double load;                 /* N, against positive positions */
    double encoder_noise;        /* added before quantisation, m */
} psrm_plant_input;

typedef struct {
    double p;                    /* position, m */
    double v;                    /* m/s */
    double z;                    /* bristle, m */
    double y;                    /* deflection that the encoder sees, m */
    double y_rate;               /* m/s */
    double current[PSRM_PHASES]; /* A */
} psrm_plant_state;

typedef struct {
    double position;          /* m */
    double position_measured; /* m */
    double velocity;          /* m/s */
    double friction;          /* N */
    double bristle;           /* m */
    double thrust;            /* N */
    double normal_force;      /* N */
    double current[PSRM_PHASES];
} psrm_plant_output;

/* Return why the parameters cannot be stepped, or 0. */
const char *psrm_plant_refusal(const psrm_plant_parameters *par);

/* Set the state of an axis at rest at its start. */
void psrm_plant_reset(const psrm_plant_parameters *par, psrm_plant_state *state);

/*
 * Advance by a duration, s, under constant inputs, in steps of PSRM_PLANT_STEP and a shorter one
 * for the rest. Where table.positions is 0 the formula of the parameters holds.
 */
void psrm_plant_advance(const psrm_plant_parameters *par, const psrm_table *table,
                        const psrm_plant_input *input, double duration, psrm_plant_state *state);

void psrm_plant_measure(const psrm_plant_parameters *par, const psrm_table *table,
                        const psrm_plant_input *input, const psrm_plant_state *state,
                        psrm_plant_output *output);

#endif
