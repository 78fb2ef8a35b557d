#ifndef PSRM_FRICTION_H
#define PSRM_FRICTION_H

#include "psrm_controller.h"

/* What the laws for K take, apart from parameters */
typedef struct {
    double v;        /* velocity that drives the observer, m/s */
    double error;    /* following error, m */
    double k_d;      /* N s/m */
    double u;        /* PD force, N */
    double inertia;  /* M a, N */
    double residual; /* filtered residual of the force balance, N */
} psrm_balance;

/*
 * Return the next filtered residual r, N:
 *
 *     r += alpha (M a - (f - f_hat) - sigma_1 K - r)
 *
 * of the command that acted in the last period; the reversed K leaves sigma_1 K out, as eq. (25).
 */
double psrm_residual(const psrm_compensation *law, const psrm_friction *model,
                     const psrm_command *acting, double residual, double inertia);

/* Return K, m/s. */
double psrm_adaptation(const psrm_compensation *law, const psrm_friction *model,
                       const psrm_balance *balance);

/* Step the bristle estimate z, m, over one period and return the friction estimate, N. */
double psrm_estimate_friction(const psrm_compensation *law, const psrm_friction *model, double v,
                              double K, double *z);

#endif
