/*
 * What the controller takes of the target's C library: fabs, sqrt, floor, rint (halves either way
 * will do) and ldexp, which are exact or correctly rounded everywhere. exp, sin and cos are not
 * among them.
 */
#ifndef PSRM_MATH_H
#define PSRM_MATH_H

#include <math.h>

/* Return 2^n for a whole number n; 0 below -1022, and for NaN. */
static inline double power_of_two(double n)
{
    return (n >= -1022.0) ? ldexp(1.0, (int)n) : 0.0;
}

#endif
