/*
 * Friction estimate: the LuGre observer and the laws for its term K.
 *
 *     g(v)  = (F_c + (F_s - F_c) exp(-(v/v_s)^2))/sigma_0                  eq. (22)
 *     dz_hat/dt = v - |v|/g(v) z_hat + K                                  eq. (24)
 *     f_hat = sigma_0 z_hat + sigma_1 dz_hat/dt + sigma_2 v               eq. (23)
 *
 * stepped by its exact exponential, since the decay rate |v|/g reaches 5e5 1/s:
 *
 *     z_n = z_hat exp(-l T_s) + T_s (v + K) phi_1(l T_s),  l = |v|/g(v)
 *
 * With D = sigma_1 l - sigma_0, the force balance's residual r, and c of each law:
 *
 *     off, observer    K = 0
 *     published-k      K = u (M a - u)/(sigma_1 u + e k_d D)              eq. (25)
 *     residual-k       K = gain e_z where D < 0, e_z = D r/(D^2 + (c sigma_0)^2)
 *     canudas-de-wit   K = gain e          IEEE Trans. Autom. Control 40(3), 1995
 *     reversed-k       K = -r/(sigma_1 + c k_d D e/u)
 *
 * Equation numbers are those of Huang et al. 2019.
 */
#include "psrm_friction.h"

#include "psrm_math.h"

/* Denominators smaller than it count as zero: eq. (25) is 0/0 at rest on the reference. */
static const double SMALLEST_DENOMINATOR = 1e-12;

/* Return the decay rate |v|/g(v) of the bristle, 1/s. */
static double bristle_decay(const psrm_friction *model, double v)
{
    return model->sigma_0 * psrm_abs(v) / psrm_stribeck(model, v);
}

double psrm_residual(const psrm_compensation *law, const psrm_friction *model,
                     const psrm_command *acting, double residual, double inertia)
{
    double balance = inertia - (acting->force - acting->estimate);

    if (law->law != PSRM_LAW_REVERSED_K) {
        balance = balance - (model->sigma_1 * acting->K);
    }
    return residual + (law->residual_alpha * (balance - residual));
}

static double published_K(const psrm_friction *model, const psrm_balance *b, double D)
{
    double denominator = (model->sigma_1 * b->u) + (b->error * b->k_d * D);

    if (psrm_abs(denominator) < SMALLEST_DENOMINATOR) {
        denominator = SMALLEST_DENOMINATOR;
    }
    return b->u * (b->inertia - b->u) / denominator;
}

static double residual_K(const psrm_compensation *law, const psrm_friction *model,
                         const psrm_balance *b, double D)
{
    const double floor_D = law->regularisation * model->sigma_0;
    double K = 0.0;

    if (D < 0.0) {
        K = law->gain * (D * b->residual / ((D * D) + (floor_D * floor_D)));
    }
    return K;
}

static double reversed_K(const psrm_compensation *law, const psrm_friction *model,
                         const psrm_balance *b, double D)
{
    const double u = (psrm_abs(b->u) < SMALLEST_DENOMINATOR) ? SMALLEST_DENOMINATOR : b->u;
    const double slope = model->sigma_1 + ((law->k_d_share * b->k_d * b->error / u) * D);

    return (psrm_abs(slope) < SMALLEST_DENOMINATOR) ? 0.0 : (-b->residual / slope);
}

double psrm_adaptation(const psrm_compensation *law, const psrm_friction *model,
                       const psrm_balance *balance)
{
    const double D = (model->sigma_1 * bristle_decay(model, balance->v)) - model->sigma_0;
    double K;

    switch (law->law) {
    case PSRM_LAW_PUBLISHED_K:
        K = published_K(model, balance, D);
        break;
    case PSRM_LAW_RESIDUAL_K:
        K = residual_K(law, model, balance, D);
        break;
    case PSRM_LAW_CANUDAS_DE_WIT:
        K = law->gain * balance->error;
        break;
    case PSRM_LAW_REVERSED_K:
        K = reversed_K(law, model, balance, D);
        break;
    case PSRM_LAW_OFF:
    case PSRM_LAW_OBSERVER:
    default:
        K = 0.0;
        break;
    }
    return K;
}

double psrm_estimate_friction(const psrm_compensation *law, const psrm_friction *model, double v,
                              double K, double *z)
{
    double decayed;
    double phi_1;
    double z_next;
    double z_rate;

    psrm_decay(bristle_decay(model, v) * PSRM_PERIOD, &decayed, &phi_1);
    z_next = (*z * decayed) + (PSRM_PERIOD * (v + K) * phi_1);
    z_next = psrm_clip(z_next, -law->bristle_limit, law->bristle_limit);
    z_rate = (z_next - *z) * (1.0 / PSRM_PERIOD);
    *z = z_next;
    return (model->sigma_0 * z_next) + (model->sigma_1 * z_rate) + (model->sigma_2 * v);
}
