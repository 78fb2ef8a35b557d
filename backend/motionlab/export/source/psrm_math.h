/*
 * Elementary functions with the same results on every target. psrm_math.c alone includes <math.h>,
 * for five functions that are exact or correctly rounded everywhere; sin, cos and exp are not
 * among them.
 */
#ifndef PSRM_MATH_H
#define PSRM_MATH_H

#include <stdint.h>

/* The five: fabs, sqrt, floor, rint (halves either way will do) and ldexp, x 2^n. */
double psrm_abs(double x);
double psrm_square_root(double x);
double psrm_floor(double x);
double psrm_nearest(double x);
double psrm_scaled(double x, int32_t n);

/* Limit x to [low, high]; NaN stays NaN. */
double psrm_clip(double x, double low, double high);

/* Return the larger of x and 0; 0 for NaN. */
double psrm_positive(double x);

/* Return e^x for x <= 0, relative error below 1e-14 + 1.2e-16 |x|; below -700 it stays e^-700. */
double psrm_exponential(double x);

/* Give sin and cos of 2 pi turns. */
void psrm_sine_cosine(double turns, double *sine, double *cosine);

/*
 * Give e^-x and phi_1 = (1 - e^-x)/x, its mean over a step, for x >= 0, the step's length times
 * the decay rate.
 */
void psrm_decay(double x, double *decayed, double *phi_1);

#endif
