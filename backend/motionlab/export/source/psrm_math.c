#include "psrm_math.h"

#include <math.h>

static const double TWO_PI = 6.283185307179586;
static const double LN_2 = 0.6931471805599453;
static const double LOG2_E = 1.0 / 0.6931471805599453;
static const double LEAST_EXPONENT = -700.0;

/* Below it phi_1 comes from its series: the quotient loses digits. */
static const double SERIES_BELOW = 0.03;

/* 1/k!, the Taylor series of e^x */
static const double E_2 = 1.0 / 2.0;
static const double E_3 = 1.0 / 6.0;
static const double E_4 = 1.0 / 24.0;
static const double E_5 = 1.0 / 120.0;
static const double E_6 = 1.0 / 720.0;
static const double E_7 = 1.0 / 5040.0;
static const double E_8 = 1.0 / 40320.0;
static const double E_9 = 1.0 / 362880.0;
static const double E_10 = 1.0 / 3628800.0;
static const double E_11 = 1.0 / 39916800.0;

/* The Taylor series of sin x */
static const double S_3 = -1.0 / 6.0;
static const double S_5 = 1.0 / 120.0;
static const double S_7 = -1.0 / 5040.0;
static const double S_9 = 1.0 / 362880.0;
static const double S_11 = -1.0 / 39916800.0;
static const double S_13 = 1.0 / 6227020800.0;
static const double S_15 = -1.0 / 1307674368000.0;
static const double S_17 = 1.0 / 355687428096000.0;

/* The Taylor series of cos x */
static const double C_2 = -1.0 / 2.0;
static const double C_4 = 1.0 / 24.0;
static const double C_6 = -1.0 / 720.0;
static const double C_8 = 1.0 / 40320.0;
static const double C_10 = -1.0 / 3628800.0;
static const double C_12 = 1.0 / 479001600.0;
static const double C_14 = -1.0 / 87178291200.0;
static const double C_16 = 1.0 / 20922789888000.0;

double psrm_abs(double x)
{
    return fabs(x);
}

double psrm_square_root(double x)
{
    return sqrt(x);
}

double psrm_floor(double x)
{
    return floor(x);
}

double psrm_nearest(double x)
{
    return rint(x);
}

double psrm_scaled(double x, int32_t n)
{
    return ldexp(x, (int)n);
}

double psrm_clip(double x, double low, double high)
{
    double limited = x;

    if (limited < low) {
        limited = low;
    }
    if (limited > high) {
        limited = high;
    }
    return limited;
}

double psrm_positive(double x)
{
    return (x > 0.0) ? x : 0.0;
}

double psrm_exponential(double x)
{
    double bounded;
    double n;
    double r;
    double r_2;
    double r_4;
    double low;
    double middle;
    double high;
    double result = x; /* NaN stays NaN */

    if (x <= 0.0) {
        /* e^x = 2^n e^r with |r| <= ln(2)/2, e^r by its Taylor polynomial of degree 11 */
        bounded = (x < LEAST_EXPONENT) ? LEAST_EXPONENT : x;
        n = psrm_nearest(bounded * LOG2_E);
        r = bounded - (n * LN_2);
        r_2 = r * r;
        r_4 = r_2 * r_2;
        low = (1.0 + r) + (r_2 * (E_2 + (E_3 * r)));
        middle = (E_4 + (E_5 * r)) + (r_2 * (E_6 + (E_7 * r)));
        high = (E_8 + (E_9 * r)) + (r_2 * (E_10 + (E_11 * r)));
        result = psrm_scaled(low + (r_4 * (middle + (r_4 * high))), (int32_t)n);
    }
    return result;
}

void psrm_sine_cosine(double turns, double *sine, double *cosine)
{
    /* 2 pi turns = quarter pi/2 + x with |x| <= pi/4; q is the quarter modulo 4, -2 to 2 */
    const double quarter = psrm_nearest(4.0 * turns);
    const double q = quarter - (4.0 * psrm_nearest(0.25 * quarter));
    const double x = TWO_PI * (turns - (0.25 * quarter));
    const double x_2 = x * x;
    const double x_4 = x_2 * x_2;
    const double x_8 = x_4 * x_4;
    double s;
    double c;

    s = (S_3 + (S_5 * x_2)) + (x_4 * (S_7 + (S_9 * x_2)));
    s = s + (x_8 * ((S_11 + (S_13 * x_2)) + (x_4 * (S_15 + (S_17 * x_2)))));
    s = x + (x * x_2 * s);
    c = (C_2 + (C_4 * x_2)) + (x_4 * (C_6 + (C_8 * x_2)));
    c = c + (x_8 * ((C_10 + (C_12 * x_2)) + (x_4 * (C_14 + (C_16 * x_2)))));
    c = 1.0 + (x_2 * c);

    if (q > 1.5) {
        *sine = -s;
        *cosine = -c;
    } else if (q > 0.5) {
        *sine = c;
        *cosine = -s;
    } else if (q < -1.5) {
        *sine = -s;
        *cosine = -c;
    } else if (q < -0.5) {
        *sine = -c;
        *cosine = s;
    } else {
        *sine = s;
        *cosine = c;
    }
}

void psrm_decay(double x, double *decayed, double *phi_1)
{
    const double e = psrm_exponential(-x);
    double series;

    if (x < SERIES_BELOW) {
        series = E_5 - (x * (E_6 - (x * E_7)));
        *phi_1 = 1.0 - (x * (E_2 - (x * (E_3 - (x * (E_4 - (x * series)))))));
    } else {
        *phi_1 = (1.0 - e) / x;
    }
    *decayed = e;
}
