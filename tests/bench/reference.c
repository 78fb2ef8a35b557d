/* The model of the simulator's kernel as plain scalar C: the reference of the speed benchmark.
 *
 * Written from the equations for one lane at a time, with libm, without a log: only the final state
 * and the largest following error are kept. What does not change from tick to tick is computed
 * once; of the compensation laws only the selected one is evaluated; what is switched off is
 * skipped. T_S, SUBSTEPS and the layout of parameters, state and inputs come from the caller.
 */

#include <math.h>
#ifdef __SSE2__
#include <immintrin.h>
#endif

#define H (T_S / SUBSTEPS)
#define TWO_PI 6.283185307179586
#define HALF_SQRT3 0.8660254037844386

enum law { OFF, OBSERVER, PUBLISHED, RESIDUAL, CANUDAS_DE_WIT, REVERSED };

struct lugre { double sigma_0, sigma_1, sigma_2, F_c, F_s, v_s; };
struct force_map { double tau, offset, F_pk, N_pk, I_pk, I_knee, h_2, h_3; };

struct table { double thrust, normal, positions, currents, per_ampere, gain; }; /* unused */

struct parameters {
    struct lugre friction;
    struct force_map map;
    struct table table;
    struct { double half_step, gain[3], offset[3], limit; } amplifiers;
    struct { double resolution, sde_amplitude, sde_period; } encoder;
    struct { double M, stop, stop_stiffness, stop_damping; } mechanics;
    struct { double compliance, hold, drift, pull, keep; } resonance;
    struct {
        double k_p, k_d, M, force_limit, feedforward, observer, observer_alpha, delay, ideal_force;
    } controller;
    struct { double b_0, b_1, b_2, a_1, a_2; } notch;
    struct {
        double law, enabled, from_reference, gain, residual_alpha, regularisation, z_limit,
            k_d_share;
    } compensation;
    struct lugre model_friction;
    struct force_map model_map;
    struct table model_table;
    struct { double law, inverse, shares, current_limit, overlap; } sharing;
    struct { double error; } limits;
};

struct state {
    double p, v, z, y, y_rate, i[3];
    double p_last, v_last, e_last, z_hat, residual, d, n_1, n_2;
    double f_acting, f_hat_acting, f_added_acting, K_acting, c_acting[3]; /* c_acting: unused */
    double f_pending, f_hat_pending, f_added_pending, K_pending, c_pending[3];
    double age, failed;
};

struct inputs {
    double p_ref[2], v_ref[2], a_ref[2], load[2], noise[2], current[3][2];
    double learnt[2], jitter[2]; /* unused */
};

/* Friction and force map with their constants worked out. */
struct friction { double sigma_0, sigma_1, sigma_2, F_c, drop, w; };
struct map { double turns, offset, F_pk, b, inverse_I, I_pk, double_h_2, h_3, scale; };

static struct friction prepare_friction(const struct lugre *f)
{
    return (struct friction){
        f->sigma_0, f->sigma_1, f->sigma_2, f->F_c, f->F_s - f->F_c, 1.0 / (f->v_s * f->v_s)};
}

static struct map prepare_map(const struct force_map *m)
{
    double knee = m->I_pk / m->I_knee;
    return (struct map){TWO_PI / m->tau, m->offset,  m->F_pk, knee * knee,           1.0 / m->I_pk,
                        m->I_pk,         2 * m->h_2, m->h_3,  1.0 / (1.0 - m->h_3)};
}

static inline double clip(double x, double low, double high)
{
    return x < low ? low : x > high ? high : x;
}

static inline double stribeck(const struct friction *f, double v)
{
    return f->F_c + f->drop * exp(-v * v * f->w);
}

/* e^-x and phi1 = (1 - e^-x)/x. */
static inline void decay(double x, double *e, double *phi_1)
{
    if (x < 0.03) {
        *phi_1 = 1 - x * (1. / 2 - x * (1. / 6 - x * (1. / 24 - x * (1. / 120 - x / 720))));
        *e = 1 - x * *phi_1;
    } else {
        *e = exp(-x);
        *phi_1 = (1 - *e) / x;
    }
}

/* S(theta) of the three phases from one sine and one cosine. */
static inline void thrust_shape(const struct map *m, double position, double S[3])
{
    double theta = m->turns * (position + m->offset);
    double s = sin(theta), c = cos(theta);
    double third = m->h_3 * s * (3 - 4 * s * s);
    double s_b = -0.5 * s - HALF_SQRT3 * c, c_b = -0.5 * c + HALF_SQRT3 * s;
    double s_c = -0.5 * s + HALF_SQRT3 * c, c_c = -0.5 * c - HALF_SQRT3 * s;
    S[0] = (s * (1 + m->double_h_2 * c) + third) * m->scale;
    S[1] = (s_b * (1 + m->double_h_2 * c_b) + third) * m->scale;
    S[2] = (s_c * (1 + m->double_h_2 * c_c) + third) * m->scale;
}

static inline double force_fraction(const struct map *m, double i)
{
    double q = i * m->inverse_I;
    q *= q;
    return (1 + m->b) * q / (1 + m->b * q);
}

static inline double thrust(const struct map *m, double position, const double i[3])
{
    double S[3];
    thrust_shape(m, position, S);
    return m->F_pk
        * (force_fraction(m, i[0]) * S[0] + force_fraction(m, i[1]) * S[1]
           + force_fraction(m, i[2]) * S[2]);
}

/* Currents that share `force` among the phases; returns the force they give on the map. */
static inline double share_force(
    const struct map *m, double most, double position, double force, double i[3])
{
    double x[3], squares = 0, given = 0;
    thrust_shape(m, position, x);
    for (int k = 0; k < 3; k++) {
        double along = force > 0 ? x[k] : -x[k];
        x[k] = along > 0 ? along : 0;
        squares += x[k] * x[k];
    }
    double scale = fabs(force) / (m->F_pk * squares);
    for (int k = 0; k < 3; k++) {
        double y = clip(scale * x[k], 0, most);
        i[k] = m->I_pk * sqrt(y / (1 + m->b * (1 - y)));
        given += y * x[k];
    }
    return force > 0 ? m->F_pk * given : -m->F_pk * given;
}

int parameter_rows(void) { return sizeof(struct parameters) / sizeof(double); }
int state_rows(void) { return sizeof(struct state) / sizeof(double); }
int input_rows(void) { return sizeof(struct inputs) / (2 * sizeof(double)); }

static double lane(
    const struct parameters *par, struct state *now, const struct inputs *inputs, long ticks,
    int axis)
{
    const struct friction truth = prepare_friction(&par->friction);
    const struct friction model = prepare_friction(&par->model_friction);
    const struct map map = prepare_map(&par->map), model_map = prepare_map(&par->model_map);
    const double most = force_fraction(&model_map, par->sharing.current_limit);
    const double M = par->mechanics.M, inverse_M = 1 / M;
    const double inverse_M_damped = 1 / (M + 0.5 * H * truth.sigma_2);
    const double half_pull = (0.5 * H * truth.sigma_0 + truth.sigma_1) * inverse_M;
    const double softness = 1 / truth.sigma_0;
    const double stop = par->mechanics.stop, compliance = par->resonance.compliance;
    const double k_p = par->controller.k_p, k_d = par->controller.k_d;
    const double model_M = par->controller.M, force_limit = par->controller.force_limit;
    const double resolution = par->encoder.resolution;
    const double per_count = resolution > 0 ? 1 / resolution : 0;
    const double sde = par->encoder.sde_amplitude, sde_turns = TWO_PI / par->encoder.sde_period;
    const double rest = par->amplifiers.half_step, limit = par->amplifiers.limit;
    const enum law law = (enum law)par->compensation.law;
    const double z_limit = par->compensation.z_limit;
    const int enabled = par->compensation.enabled > 0, late = par->controller.delay > 0;
    const int ideal = par->controller.ideal_force > 0;
    const int from_reference = par->compensation.from_reference > 0;
    const int feedforward = par->controller.feedforward > 0;
    const int notched = par->notch.b_0 != 1;
    const int observer = par->controller.observer > 0;
    struct state s = *now;
    double largest = 0;

    for (long k = 0; k < ticks; k++) {
        const struct inputs *in = &inputs[k];
        const int first = s.age == 0;

        /* measure */
        double seen = s.p + s.y, p_meas = seen + in->noise[axis];
        if (sde != 0)
            p_meas += sde * sin(sde_turns * seen);
        if (resolution > 0)
            p_meas = resolution * rint(p_meas * per_count);
        double e = in->p_ref[axis] - p_meas;
        double de = first ? 0 : (e - s.e_last) * (1 / T_S);
        double v = first ? 0 : (p_meas - s.p_last) * (1 / T_S);
        double a = first ? 0 : (v - s.v_last) * (1 / T_S);
        s.e_last = e;
        s.p_last = p_meas;
        s.v_last = v;
        largest = fabs(e) > largest ? fabs(e) : largest;

        /* compensate */
        double u = clip(k_p * e + k_d * de, -force_limit, force_limit);
        double v_hat = from_reference ? in->v_ref[axis] : v;
        double rate = model.sigma_0 * fabs(v_hat) / stribeck(&model, v_hat);
        double K = 0;
        switch (law) {
        case PUBLISHED: {
            double D = model.sigma_1 * rate - model.sigma_0;
            double denominator = model.sigma_1 * u + e * k_d * D;
            if (fabs(denominator) < 1e-12)
                denominator = 1e-12;
            K = u * (model_M * a - u) / denominator;
            break;
        }
        case RESIDUAL: {
            double D = model.sigma_1 * rate - model.sigma_0;
            double floor = par->compensation.regularisation * model.sigma_0;
            double known = s.f_acting - s.f_hat_acting;
            double balance = model_M * a - known - model.sigma_1 * s.K_acting;
            s.residual = first
                ? 0
                : s.residual + par->compensation.residual_alpha * (balance - s.residual);
            if (D < 0)
                K = par->compensation.gain * D * s.residual / (D * D + floor * floor);
            break;
        }
        case REVERSED: {
            double D = model.sigma_1 * rate - model.sigma_0;
            double balance = model_M * a - (s.f_acting - s.f_hat_acting);
            double slope = model.sigma_1
                + par->compensation.k_d_share * k_d * e / (fabs(u) < 1e-12 ? 1e-12 : u) * D;
            s.residual = first
                ? 0
                : s.residual + par->compensation.residual_alpha * (balance - s.residual);
            K = fabs(slope) < 1e-12 ? 0 : -s.residual / slope;
            break;
        }
        case CANUDAS_DE_WIT:
            K = par->compensation.gain * e;
            break;
        default:
            break;
        }
        double hold, phi_1;
        decay(rate * T_S, &hold, &phi_1);
        double z_hat = clip(s.z_hat * hold + T_S * (v_hat + K) * phi_1, -z_limit, z_limit);
        double f_hat = model.sigma_0 * z_hat + model.sigma_1 * (z_hat - s.z_hat) * (1 / T_S)
            + model.sigma_2 * v_hat;
        double added = enabled ? f_hat : 0;
        s.z_hat = z_hat;

        /* control */
        double wanted = u + added;
        if (feedforward)
            wanted += model_M * in->a_ref[axis];
        if (observer) {
            double known = s.f_acting - s.f_added_acting;
            s.d = first
                ? 0
                : s.d + par->controller.observer_alpha * (known - model_M * a - s.d);
            wanted += s.d;
        }
        if (notched) {
            double feedback = observer ? u + s.d : u;
            double passed = par->notch.b_0 * feedback + s.n_1;
            s.n_1 = par->notch.b_1 * feedback - par->notch.a_1 * passed + s.n_2;
            s.n_2 = par->notch.b_2 * feedback - par->notch.a_2 * passed;
            wanted += passed - feedback;
        }
        double command = clip(wanted, -force_limit, force_limit);

        /* share */
        double c[3] = {0, 0, 0}, realised = command;
        if (!ideal)
            realised = share_force(&model_map, most, p_meas, command, c);
        s.f_acting = realised;
        s.f_hat_acting = f_hat;
        s.f_added_acting = added;
        s.K_acting = K;
        if (late) {
            s.f_acting = s.f_pending;
            s.f_hat_acting = s.f_hat_pending;
            s.f_added_acting = s.f_added_pending;
            s.K_acting = s.K_pending;
            s.f_pending = realised;
            s.f_hat_pending = f_hat;
            s.f_added_pending = added;
            s.K_pending = K;
            for (int j = 0; j < 3; j++) {
                double acting = s.c_pending[j];
                s.c_pending[j] = c[j];
                c[j] = acting;
            }
        }

        /* drive and move */
        double target[3];
        for (int j = 0; j < 3; j++)
            target[j] = clip(
                par->amplifiers.gain[j] * c[j] + par->amplifiers.offset[j] + in->current[j][axis],
                -limit, limit);
        for (int n = 0; n < SUBSTEPS; n++) {
            double middle = s.p + 0.5 * H * s.v, force = s.f_acting;
            if (!ideal) {
                for (int j = 0; j < 3; j++)
                    s.i[j] = target[j] + rest * (s.i[j] - target[j]);
                force = thrust(&map, middle, s.i);
                for (int j = 0; j < 3; j++)
                    s.i[j] = target[j] + rest * (s.i[j] - target[j]);
            }
            if (compliance != 0) {
                double settled = compliance * force, away = s.y - settled;
                s.y = settled + par->resonance.hold * away + par->resonance.drift * s.y_rate;
                s.y_rate = par->resonance.pull * away + par->resonance.keep * s.y_rate;
            }
            force -= in->load[axis];
            if (fabs(middle) > stop) {
                double outward = middle < 0 ? -1 : 1;
                double push = par->mechanics.stop_stiffness * (fabs(middle) - stop)
                    + par->mechanics.stop_damping * s.v * outward;
                force -= push > 0 ? push * outward : 0;
            }

            double level = stribeck(&truth, s.v);
            double g = s.v < 0 ? -level * softness : level * softness;
            double fade = exp(-(0.5 * H) * truth.sigma_0 * fabs(s.v) / level);
            double z_mid = g + (s.z - g) * fade;
            double impulse = 0.5 * H * (force - truth.sigma_2 * s.v) + truth.sigma_1 * s.z;
            double v_mid = s.v + impulse * inverse_M - half_pull * z_mid;

            level = stribeck(&truth, v_mid);
            g = v_mid < 0 ? -level * softness : level * softness;
            decay(H * truth.sigma_0 * fabs(v_mid) / level, &fade, &phi_1);
            double z = g + (s.z - g) * fade, z_mean = g + (s.z - g) * phi_1;
            impulse = H * (force - truth.sigma_0 * z_mean - 0.5 * truth.sigma_2 * s.v);
            double v_new = (M * s.v + impulse - truth.sigma_1 * (z - s.z)) * inverse_M_damped;
            s.p += 0.5 * H * (s.v + v_new);
            s.v = v_new;
            s.z = z;
        }
        if (s.failed < 0 && !(fabs(e) <= par->limits.error))
            s.failed = s.age;
        s.age += 1;
    }
    *now = s;
    return largest;
}

/* Run every lane to its end; even lanes are x, odd lanes y. Subnormal numbers are flushed to zero
 * meanwhile, as in any program that is linked with -ffast-math. */
void run_lanes(
    const struct parameters *par, struct state *states, const struct inputs *inputs, long ticks,
    int lanes, double *largest)
{
#ifdef __SSE2__
    unsigned int mode = _mm_getcsr();
    _mm_setcsr(mode | 0x8040);
#endif
    for (int i = 0; i < lanes; i++)
        largest[i] = lane(&par[i], &states[i], inputs, ticks, i % 2);
#ifdef __SSE2__
    _mm_setcsr(mode);
#endif
}
