/*
 * Position controller of a planar switched reluctance motor, axes x and y.
 *
 * Once in each control period T_s: measured positions and references in, currents of six phases
 * out.
 *
 *     psrm_parameters parameters;
 *     psrm_state state;
 *     psrm_output output;
 *
 *     psrm_initial_parameters(&parameters);
 *     psrm_reset(&state);
 *     (every T_s) psrm_step(&parameters, &state, reference, position, &output);
 *
 * All numbers are SI. Nothing is allocated and nothing is kept outside psrm_state: one set of the
 * three structs for each motor. The time of a step is bounded; there are no loops but those over
 * axes and phases.
 *
 * A step of one axis, with e = p_ref - p and differences over T_s for v, a and de/dt:
 *
 *     u    = k_p e + k_d de/dt                                  PD force, within the force limit
 *     f_hat = sigma_0 z_hat + sigma_1 dz_hat/dt + sigma_2 v     friction estimate, psrm_friction.c
 *     d   += alpha (f - f_hat - M a - d)                        disturbance observer
 *     f    = N(u + d) + f_hat + M a_ref                         N: the notch filter
 *     i_k  = psrm_share(f, p)                                   currents, psrm_sharing.c
 *
 * Each term but u can be switched off. Source: Huang et al. 2019, eqs (15) and (20) to (25);
 * disturbance observer, notch, feedforward and the laws that are not eq. (25) are motionlab's.
 */
#ifndef PSRM_CONTROLLER_H
#define PSRM_CONTROLLER_H

#include <stdint.h>

#include "psrm_motor.h"

#ifdef __cplusplus
extern "C" {
#endif

#define PSRM_PERIOD 0.0005 /* control period T_s, s */

/* Law of the friction observer's term K */
typedef enum {
    PSRM_LAW_OFF = 0,
    PSRM_LAW_OBSERVER = 1,       /* K = 0 */
    PSRM_LAW_PUBLISHED_K = 2,    /* eq. (25) as printed */
    PSRM_LAW_RESIDUAL_K = 3,     /* from the residual of the force balance */
    PSRM_LAW_CANUDAS_DE_WIT = 4, /* in proportion to the following error */
    PSRM_LAW_REVERSED_K = 5      /* eq. (25) with the opposite sign, filtered */
} psrm_law;

/* Force-sharing function */
typedef enum {
    PSRM_SHARING_LEAST_NORM = 0,
    PSRM_SHARING_FORCE_PER_AMPERE = 1, /* least copper loss */
    PSRM_SHARING_SINE = 2,
    PSRM_SHARING_CUBIC = 3
} psrm_sharing_function;

/* Friction compensation */
typedef struct {
    psrm_law law;
    uint8_t enabled;        /* 1: add the estimate to the force command; 0: only compute it */
    uint8_t from_reference; /* 1: the observer uses the reference's velocity; 0: the measured one */
    double gain;            /* of K, 1/s */
    double residual_alpha;  /* 1 - exp(-2 pi f T_s) of the residual's filter, 1 */
    double regularisation;  /* c of the residual-k law, 1 */
    double bristle_limit;   /* largest bristle estimate, m */
    double k_d_share;       /* c of the reversed-k law, 1 */
} psrm_compensation;

/* Notch filter, b_0 = 1 and zeros otherwise: none */
typedef struct {
    double b_0;
    double b_1;
    double b_2;
    double a_1;
    double a_2;
} psrm_notch;

/* Sharing of a force among the phases */
typedef struct {
    psrm_sharing_function function;
    double overlap;       /* of two phases (sine, cubic), part of the pole pitch, 1 */
    double current_limit; /* largest current command, A */
    const double *current; /* of table, over position and sqrt(thrust), A, [288][65] */
    const double *share;   /* of table, least copper loss, [2][240][33]; force-per-ampere only */
    psrm_formula formula;
    psrm_table table;
} psrm_sharing;

typedef struct {
    double k_p;                   /* N/m */
    double k_d;                   /* N s/m */
    double M;                     /* moving mass, kg */
    double force_limit;           /* largest force command, N */
    double error_limit;           /* following error beyond which psrm_signals.healthy is 0, m */
    uint8_t feedforward;          /* 1: add M a_ref */
    uint8_t disturbance_observer; /* 1: add the disturbance estimate */
    double disturbance_alpha;     /* 1 - exp(-2 pi f T_s) of its filter, 1 */
    uint8_t delay;                /* 1: a command is given out one period after it was computed */
    uint8_t ideal_force;          /* 1: the drive takes the force command, currents do not matter */
    psrm_notch notch;
    psrm_compensation compensation;
    psrm_friction friction;
    psrm_sharing sharing;
} psrm_axis_parameters;

typedef struct {
    psrm_axis_parameters axis[PSRM_AXES];
} psrm_parameters;

/* What one axis was commanded in one period */
typedef struct {
    double force;                /* that the currents give on the controller's map, N */
    double estimate;             /* friction estimate, N */
    double added;                /* the part of it that was added, N */
    double K;                    /* m/s */
    double current[PSRM_PHASES]; /* A */
} psrm_command;

typedef struct {
    uint8_t started;     /* 0 until the first step: no differences yet */
    double position;     /* last measured position, m */
    double velocity;     /* last velocity, m/s */
    double error;        /* last following error, m */
    double bristle;      /* bristle estimate z_hat, m */
    double residual;     /* filtered residual of the force balance, N */
    double disturbance;  /* disturbance estimate, N */
    double notch_1;      /* state of the notch filter, N */
    double notch_2;
    psrm_command acting;   /* given out last */
    psrm_command computed; /* computed last; the same without delay */
} psrm_axis_state;

typedef struct {
    psrm_axis_state axis[PSRM_AXES];
} psrm_state;

/* Reference of one axis */
typedef struct {
    double position;     /* m */
    double velocity;     /* m/s */
    double acceleration; /* m/s^2 */
} psrm_reference;

/* Signals of one axis, to be recorded */
typedef struct {
    double following_error;           /* m */
    double velocity;                  /* by differences, m/s */
    double pd_force;                  /* u, N */
    double friction_estimate;         /* f_hat, N */
    double bristle_estimate;          /* z_hat at the end of the period, m */
    double K;                         /* m/s */
    double disturbance_estimate;      /* d, N */
    double force_command;             /* f, within the force limit, N */
    double force_realised;            /* what the currents given out are to give, N */
    double current_next[PSRM_PHASES]; /* computed in this step, A; given out now without delay */
    uint8_t force_saturated;          /* 1: the force command is at its limit */
    uint8_t current_saturated;        /* 1: some phase is at its current limit */
    uint8_t healthy;                  /* 0: following error beyond its limit, or NaN */
} psrm_signals;

typedef struct {
    double current[PSRM_AXES][PSRM_PHASES]; /* current commands, A */
    psrm_signals axis[PSRM_AXES];
} psrm_output;

/* Fill in the parameters of the exported controller; psrm_parameters.c. */
void psrm_initial_parameters(psrm_parameters *parameters);

/* Forget everything: before the first step, and whenever the drive was off. */
void psrm_reset(psrm_state *state);

/*
 * Advance by one control period.
 *
 * reference, position: of x and y at the instant of sampling; position in m as measured.
 * output: overwritten. Without delay its currents are to act from now on.
 */
void psrm_step(const psrm_parameters *parameters, psrm_state *state,
               const psrm_reference reference[PSRM_AXES], const double position[PSRM_AXES],
               psrm_output *output);

#ifdef __cplusplus
}
#endif

#endif
