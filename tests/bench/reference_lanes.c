/* The model of the simulator's kernel in C over W lanes side by side: the reference of a batch.
 *
 * Every step is a loop over the lanes, free of branches and of calls, that the compiler turns into
 * vector instructions; exponential and sine are the polynomials of the kernel. What does not change
 * from tick to tick is computed once. As in reference.c there is no log: only the final state and
 * the largest following error are kept. Layouts are the kernel's, (rows, W); even lanes are x. T_S,
 * SUBSTEPS and W come from the caller.
 */

#include <math.h>
#include <stdint.h>
#include <string.h>
#ifdef __SSE2__
#include <immintrin.h>
#endif

#define H (T_S / SUBSTEPS)
#define TWO_PI 6.283185307179586
#define HALF_SQRT3 0.8660254037844386
#define EACH_LANE _Pragma("omp simd") for (int l = 0; l < W; l++)
#define INLINE static inline __attribute__((always_inline))

typedef double lanes[W];

struct lugre { lanes sigma_0, sigma_1, sigma_2, F_c, F_s, v_s; };
struct force_map { lanes tau, offset, F_pk, N_pk, I_pk, I_knee, h_2, h_3; };

struct table { lanes thrust, normal, positions, currents, per_ampere, gain; }; /* unused */

struct parameters {
    struct lugre friction;
    struct force_map map;
    struct table table;
    struct { lanes half_step, gain[3], offset[3], limit; } amplifiers;
    struct { lanes resolution, sde_amplitude, sde_period; } encoder;
    struct { lanes M, stop, stop_stiffness, stop_damping; } mechanics;
    struct { lanes compliance, hold, drift, pull, keep; } resonance;
    struct {
        lanes k_p, k_d, M, force_limit, feedforward, observer, observer_alpha, delay, ideal_force;
    } controller;
    struct { lanes b_0, b_1, b_2, a_1, a_2; } notch;
    struct {
        lanes law, enabled, from_reference, gain, residual_alpha, regularisation, z_limit,
            k_d_share;
    } compensation;
    struct lugre model_friction;
    struct force_map model_map;
    struct table model_table;
    struct { lanes law, inverse, shares, current_limit, overlap; } sharing;
    struct { lanes error; } limits;
};

struct state {
    lanes p, v, z, y, y_rate, i[3];
    lanes p_last, v_last, e_last, z_hat, residual, d, n_1, n_2;
    lanes f_acting, f_hat_acting, f_added_acting, K_acting, c_acting[3]; /* c_acting: unused */
    lanes f_pending, f_hat_pending, f_added_pending, K_pending, c_pending[3];
    lanes age, failed;
};

struct inputs {
    double p_ref[2], v_ref[2], a_ref[2], load[2], noise[2], current[3][2];
    double learnt[2], jitter[2]; /* unused */
};

/* Friction and force map with their constants worked out. */
struct friction { lanes w, softness; };
struct map { lanes per_tau, b, inverse_I, scale; };
struct phases { double a, b, c; };

int parameter_rows(void) { return sizeof(struct parameters) / sizeof(lanes); }
int state_rows(void) { return sizeof(struct state) / sizeof(lanes); }
int input_rows(void) { return sizeof(struct inputs) / (2 * sizeof(double)); }

INLINE double clip(double x, double low, double high)
{
    x = x < low ? low : x;
    return x > high ? high : x;
}

/* e^x for x <= 700, by range reduction and Estrin's scheme. */
INLINE double exponential(double x)
{
    x = x < -700 ? -700 : x;
    double n = rint(x * 1.4426950408889634), r = x - n * 0.6931471805599453;
    double r2 = r * r, r4 = r2 * r2;
    double low = (1 + r) + r2 * (1. / 2 + r * (1. / 6));
    double middle = (1. / 24 + r * (1. / 120)) + r2 * (1. / 720 + r * (1. / 5040));
    double high = (1. / 40320 + r * (1. / 362880)) + r2 * (1. / 3628800 + r * (1. / 39916800));
    double shifted = n + (6755399441055744.0 + 1023.0);
    int64_t bits;
    memcpy(&bits, &shifted, sizeof bits);
    bits <<= 52;
    double power;
    memcpy(&power, &bits, sizeof power);
    return (low + r4 * (middle + r4 * high)) * power;
}

/* sin and cos of 2 pi turns. */
INLINE void sine_cosine(double turns, double *sine, double *cosine)
{
    double quarter = rint(4 * turns), x = TWO_PI * (turns - 0.25 * quarter);
    double q = quarter - 4 * rint(0.25 * quarter);
    double x2 = x * x, x4 = x2 * x2, x8 = x4 * x4;
    double s = (-1. / 6 + x2 * (1. / 120)) + x4 * (-1. / 5040 + x2 * (1. / 362880));
    s += x8
        * ((-1. / 39916800 + x2 * (1. / 6227020800.))
           + x4 * (-1. / 1307674368000. + x2 * (1. / 355687428096000.)));
    s = x + x * x2 * s;
    double c = (-1. / 2 + x2 * (1. / 24)) + x4 * (-1. / 720 + x2 * (1. / 40320));
    c += x8
        * ((-1. / 3628800 + x2 * (1. / 479001600.))
           + x4 * (-1. / 87178291200. + x2 * (1. / 20922789888000.)));
    c = 1 + x2 * c;
    double a = fabs(q) == 1 ? c : s, b = fabs(q) == 1 ? s : c;
    *sine = (fabs(q) == 2) | (q == -1) ? -a : a;
    *cosine = (fabs(q) == 2) | (q == 1) ? -b : b;
}

INLINE double stribeck(const struct lugre *f, const struct friction *c, double v, int l)
{
    return f->F_c[l] + (f->F_s[l] - f->F_c[l]) * exponential(-v * v * c->w[l]);
}

/* phi1 = (1 - e^-x)/x. */
INLINE double phi(double x, double e)
{
    double near = 1 - x * (1. / 2 - x * (1. / 6 - x * (1. / 24 - x * (1. / 120 - x / 720))));
    return x < 0.03 ? near : (1 - e) / x;
}

INLINE struct phases thrust_shape(
    const struct force_map *m, const struct map *k, double position, int l)
{
    double s, c;
    sine_cosine((position + m->offset[l]) * k->per_tau[l], &s, &c);
    double third = m->h_3[l] * s * (3 - 4 * s * s), twice = 2 * m->h_2[l];
    double s_b = -0.5 * s - HALF_SQRT3 * c, c_b = -0.5 * c + HALF_SQRT3 * s;
    double s_c = -0.5 * s + HALF_SQRT3 * c, c_c = -0.5 * c - HALF_SQRT3 * s;
    return (struct phases){
        (s * (1 + twice * c) + third) * k->scale[l],
        (s_b * (1 + twice * c_b) + third) * k->scale[l],
        (s_c * (1 + twice * c_c) + third) * k->scale[l]};
}

INLINE double force_fraction(const struct map *k, double i, int l)
{
    double q = i * k->inverse_I[l];
    q *= q;
    return (1 + k->b[l]) * q / (1 + k->b[l] * q);
}

static void prepare(
    const struct lugre *f, const struct force_map *m, struct friction *friction, struct map *map)
{
    EACH_LANE {
        double knee = m->I_pk[l] / m->I_knee[l];
        friction->w[l] = 1 / (f->v_s[l] * f->v_s[l]);
        friction->softness[l] = 1 / f->sigma_0[l];
        map->per_tau[l] = 1 / m->tau[l];
        map->b[l] = knee * knee;
        map->inverse_I[l] = 1 / m->I_pk[l];
        map->scale[l] = 1 / (1 - m->h_3[l]);
    }
}

/* What phase j is to settle at, of the command that acts now. */
#define DRIVE(j, command_now)                                                                      \
    {                                                                                              \
        double acting = late ? s->c_pending[j][l] : command_now, most = par->amplifiers.limit[l];  \
        s->c_pending[j][l] = command_now;                                                          \
        double settled = par->amplifiers.gain[j][l] * acting + par->amplifiers.offset[j][l];       \
        target[j][l] = clip(settled + in->current[j][axis], -most, most);                          \
    }

/* The thrust of phase j at the middle of a substep, and its current at the end. */
#define PULL(j, shape)                                                                             \
    {                                                                                              \
        double i = target[j][l] + rest * (s->i[j][l] - target[j][l]);                              \
        force += force_fraction(&map, i, l) * shape;                                               \
        s->i[j][l] = target[j][l] + rest * (i - target[j][l]);                                     \
    }

/* Advance W lanes to their end. */
void run_lanes(
    const struct parameters *restrict par, struct state *restrict s,
    const struct inputs *restrict inputs, long ticks, double *restrict largest)
{
#ifdef __SSE2__
    unsigned int mode = _mm_getcsr();
    _mm_setcsr(mode | 0x8040);
#endif
    struct friction truth, model;
    struct map map, model_map;
    prepare(&par->friction, &par->map, &truth, &map);
    prepare(&par->model_friction, &par->model_map, &model, &model_map);
    lanes most, inverse_M, heavier, load, target[3];
    EACH_LANE {
        most[l] = force_fraction(&model_map, par->sharing.current_limit[l], l);
        inverse_M[l] = 1 / par->mechanics.M[l];
        heavier[l] = 1 / (par->mechanics.M[l] + 0.5 * H * par->friction.sigma_2[l]);
        largest[l] = 0;
    }

    for (long k = 0; k < ticks; k++) {
        const struct inputs *in = &inputs[k];
        EACH_LANE {
            int axis = l & 1, first = s->age[l] == 0;

            /* measure */
            double seen = s->p[l] + s->y[l], sine, cosine;
            sine_cosine(seen / par->encoder.sde_period[l], &sine, &cosine);
            double p_meas = seen + in->noise[axis] + par->encoder.sde_amplitude[l] * sine;
            double resolution = par->encoder.resolution[l];
            double divisor = resolution > 0 ? resolution : 1;
            double counted = resolution * rint(p_meas / divisor);
            p_meas = resolution > 0 ? counted : p_meas;
            double e = in->p_ref[axis] - p_meas;
            double de = first ? 0 : (e - s->e_last[l]) * (1 / T_S);
            double v = first ? 0 : (p_meas - s->p_last[l]) * (1 / T_S);
            double a = first ? 0 : (v - s->v_last[l]) * (1 / T_S);
            s->e_last[l] = e;
            s->p_last[l] = p_meas;
            s->v_last[l] = v;
            largest[l] = fabs(e) > largest[l] ? fabs(e) : largest[l];

            /* compensate: every law, and a selection */
            double law = par->compensation.law[l], gain = par->compensation.gain[l];
            double limit = par->controller.force_limit[l], k_d = par->controller.k_d[l];
            double s_0 = par->model_friction.sigma_0[l], s_1 = par->model_friction.sigma_1[l];
            double inertia = par->controller.M[l] * a;
            double u = clip(par->controller.k_p[l] * e + k_d * de, -limit, limit);
            double v_ref = in->v_ref[axis];
            double v_hat = par->compensation.from_reference[l] > 0 ? v_ref : v;
            double rate = s_0 * fabs(v_hat) / stribeck(&par->model_friction, &model, v_hat, l);
            double balance = inertia - (s->f_acting[l] - s->f_hat_acting[l]);
            balance = law == 5 ? balance : balance - s_1 * s->K_acting[l];
            double alpha = par->compensation.residual_alpha[l];
            double residual = s->residual[l] + alpha * (balance - s->residual[l]);
            residual = first ? 0 : residual;
            s->residual[l] = residual;
            double D = s_1 * rate - s_0, floor = par->compensation.regularisation[l] * s_0;
            double denominator = s_1 * u + e * k_d * D;
            denominator = fabs(denominator) < 1e-12 ? 1e-12 : denominator;
            double published = u * (inertia - u) / denominator;
            double explicit = gain * D * residual / (D * D + floor * floor);
            double share = par->compensation.k_d_share[l] * k_d * e;
            double slope = s_1 + share / (fabs(u) < 1e-12 ? 1e-12 : u) * D;
            double reversed = fabs(slope) < 1e-12 ? 0 : -residual / slope;
            double K = law == 2 ? published : 0;
            K = (law == 3) & (D < 0) ? explicit : K;
            K = law == 4 ? gain * e : K;
            K = law == 5 ? reversed : K;
            double hold = exponential(-rate * T_S), z_limit = par->compensation.z_limit[l];
            double z_hat = s->z_hat[l] * hold + T_S * (v_hat + K) * phi(rate * T_S, hold);
            z_hat = clip(z_hat, -z_limit, z_limit);
            double f_hat = s_0 * z_hat + s_1 * (z_hat - s->z_hat[l]) * (1 / T_S)
                + par->model_friction.sigma_2[l] * v_hat;
            double added = par->compensation.enabled[l] > 0 ? f_hat : 0;
            s->z_hat[l] = z_hat;

            /* control */
            double known = s->f_acting[l] - s->f_added_acting[l] - inertia;
            double d = s->d[l] + par->controller.observer_alpha[l] * (known - s->d[l]);
            d = first ? 0 : d;
            s->d[l] = d;
            double ahead = par->controller.M[l] * in->a_ref[axis];
            double feedback = u + (par->controller.observer[l] > 0 ? d : 0);
            double passed = par->notch.b_0[l] * feedback + s->n_1[l];
            s->n_1[l] = par->notch.b_1[l] * feedback - par->notch.a_1[l] * passed + s->n_2[l];
            s->n_2[l] = par->notch.b_2[l] * feedback - par->notch.a_2[l] * passed;
            double wanted = passed + added + (par->controller.feedforward[l] > 0 ? ahead : 0);
            double command = clip(wanted, -limit, limit);

            /* share */
            double way = command > 0 ? 1 : -1, F_pk = par->model_map.F_pk[l];
            struct phases x = thrust_shape(&par->model_map, &model_map, p_meas, l);
            x.a = way * x.a > 0 ? way * x.a : 0;
            x.b = way * x.b > 0 ? way * x.b : 0;
            x.c = way * x.c > 0 ? way * x.c : 0;
            double scale = way * command / (F_pk * (x.a * x.a + x.b * x.b + x.c * x.c));
            double y_a = clip(scale * x.a, 0, most[l]);
            double y_b = clip(scale * x.b, 0, most[l]);
            double y_c = clip(scale * x.c, 0, most[l]);
            double given = way * F_pk * (y_a * x.a + y_b * x.b + y_c * x.c);
            double I_pk = par->model_map.I_pk[l], b = model_map.b[l];
            double c_a = I_pk * sqrt(y_a / (1 + b * (1 - y_a)));
            double c_b = I_pk * sqrt(y_b / (1 + b * (1 - y_b)));
            double c_c = I_pk * sqrt(y_c / (1 + b * (1 - y_c)));
            double realised = par->controller.ideal_force[l] > 0 ? command : given;
            int late = par->controller.delay[l] > 0;
            s->f_acting[l] = late ? s->f_pending[l] : realised;
            s->f_hat_acting[l] = late ? s->f_hat_pending[l] : f_hat;
            s->f_added_acting[l] = late ? s->f_added_pending[l] : added;
            s->K_acting[l] = late ? s->K_pending[l] : K;
            s->f_pending[l] = realised;
            s->f_hat_pending[l] = f_hat;
            s->f_added_pending[l] = added;
            s->K_pending[l] = K;
            DRIVE(0, c_a)
            DRIVE(1, c_b)
            DRIVE(2, c_c)
            load[l] = in->load[axis];
            int failing = (s->failed[l] < 0) & !(fabs(e) <= par->limits.error[l]);
            s->failed[l] = failing ? s->age[l] : s->failed[l];
            s->age[l] += 1;
        }

        /* drive and move */
        for (int n = 0; n < SUBSTEPS; n++)
            EACH_LANE {
                const struct lugre *f = &par->friction;
                double v = s->v[l], z = s->z[l], rest = par->amplifiers.half_step[l];
                double middle = s->p[l] + 0.5 * H * v, force = 0;
                struct phases S = thrust_shape(&par->map, &map, middle, l);
                PULL(0, S.a)
                PULL(1, S.b)
                PULL(2, S.c)
                force *= par->map.F_pk[l];
                force = par->controller.ideal_force[l] > 0 ? s->f_acting[l] : force;
                double settled = par->resonance.compliance[l] * force, away = s->y[l] - settled;
                double y_rate = s->y_rate[l];
                s->y[l] = settled + par->resonance.hold[l] * away + par->resonance.drift[l] * y_rate;
                s->y_rate[l] = par->resonance.pull[l] * away + par->resonance.keep[l] * y_rate;
                double depth = fabs(middle) - par->mechanics.stop[l];
                double outward = middle < 0 ? -1 : 1;
                double push = par->mechanics.stop_stiffness[l] * depth
                    + par->mechanics.stop_damping[l] * v * outward;
                push = (push > 0) & (depth > 0) ? push * outward : 0;
                force -= load[l] + push;

                double level = stribeck(f, &truth, v, l);
                double g = (v < 0 ? -level : level) * truth.softness[l];
                double fade = exponential(-(0.5 * H) * f->sigma_0[l] * fabs(v) / level);
                double z_mid = g + (z - g) * fade;
                double impulse = 0.5 * H * (force - f->sigma_2[l] * v) + f->sigma_1[l] * z;
                double pull = 0.5 * H * f->sigma_0[l] + f->sigma_1[l];
                double v_mid = v + (impulse - pull * z_mid) * inverse_M[l];

                level = stribeck(f, &truth, v_mid, l);
                g = (v_mid < 0 ? -level : level) * truth.softness[l];
                double way = H * f->sigma_0[l] * fabs(v_mid) / level;
                fade = exponential(-way);
                double z_new = g + (z - g) * fade, z_mean = g + (z - g) * phi(way, fade);
                impulse = H * (force - f->sigma_0[l] * z_mean - 0.5 * f->sigma_2[l] * v);
                double M = par->mechanics.M[l];
                double v_new = (M * v + impulse - f->sigma_1[l] * (z_new - z)) * heavier[l];
                s->p[l] += 0.5 * H * (v + v_new);
                s->v[l] = v_new;
                s->z[l] = z_new;
            }
    }
#ifdef __SSE2__
    _mm_setcsr(mode);
#endif
}
