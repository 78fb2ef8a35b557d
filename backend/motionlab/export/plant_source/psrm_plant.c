#include "psrm_plant.h"

#include "psrm_math.h"

static const double TWO_PI = 6.283185307179586;

/* A rest below this part of a step is rounding of the caller's time. */
static const double ROUNDING = 1e-6;

/* A bristle that gives way at 1e-60 N: below the last bit of any force, and no 0/0 */
static const psrm_friction FRICTIONLESS = {1.0, 0.0, 0.0, 1e-60, 1e-60, 1.0};

/* What depends on the length of a step, or of table and parameters together */
typedef struct {
    double h;          /* s */
    double rest;       /* what remains of a current's deviation after half a step, 1 */
    double compliance; /* deflection under a constant thrust, m/N */
    double hold;       /* deflection after a step, of a deflection, 1 */
    double drift;      /* of a deflection rate, s */
    double pull;       /* deflection rate after a step, of a deflection, 1/s */
    double keep;       /* of a deflection rate, 1 */
} sampled;

static const psrm_friction *friction_of(const psrm_plant_parameters *par)
{
    return (par->friction_on != 0.0) ? &par->friction : &FRICTIONLESS;
}

const char *psrm_plant_refusal(const psrm_plant_parameters *par)
{
    const double h = PSRM_PLANT_STEP;
    const psrm_friction *friction = friction_of(par);
    const char *refusal = 0;

    if (friction->F_s < friction->F_c) {
        refusal = "friction.F_s is below friction.F_c";
    } else if (par->mass < (h * par->stop_damping)) {
        refusal = "mass is too small for stop_damping: at least 1e-4 s stop_damping";
    } else if (par->mass < (h * h * par->stop_stiffness)) {
        refusal = "mass is too small for stop_stiffness: at least 1e-8 s^2 stop_stiffness";
    } else if (par->mass < (h * h * friction->sigma_0)) {
        refusal = "mass is too small for friction.sigma_0: at least 1e-8 s^2 sigma_0";
    } else if (par->mass < (h * friction->sigma_1)) {
        refusal = "mass is too small for friction.sigma_1: at least 1e-4 s sigma_1";
    } else {
        refusal = 0;
    }
    return refusal;
}

void psrm_plant_reset(const psrm_plant_parameters *par, psrm_plant_state *state)
{
    static const psrm_plant_state REST = {0.0, 0.0, 0.0, 0.0, 0.0, {0.0, 0.0, 0.0}};

    *state = REST;
    state->p = par->position_start;
}

/* -- forces ----------------------------------------------------------------------------------- */

static double thrust_of(const psrm_plant_parameters *par, const psrm_table *table, double position,
                        const double current[PSRM_PHASES])
{
    psrm_table scaled = *table;
    double place[PSRM_PHASES];
    double thrust;

    if (table->positions > 0U) {
        scaled.gain = par->map_gain;
        psrm_phase_turns(&par->force_map, position, place);
        thrust = psrm_table_thrust(&scaled, place[0], current[0]) +
                 psrm_table_thrust(&scaled, place[1], current[1]) +
                 psrm_table_thrust(&scaled, place[2], current[2]);
    } else {
        psrm_thrust_shape(&par->force_map, position, place);
        thrust = par->force_map.F_pk *
                 ((psrm_force_fraction(&par->force_map, current[0]) * place[0]) +
                  (psrm_force_fraction(&par->force_map, current[1]) * place[1]) +
                  (psrm_force_fraction(&par->force_map, current[2]) * place[2]));
    }
    return thrust;
}

static double normal_force_of(const psrm_plant_parameters *par, const psrm_table *table,
                              double position, const double current[PSRM_PHASES])
{
    psrm_table scaled = *table;
    double place[PSRM_PHASES];
    double sine[PSRM_PHASES];
    double cosine[PSRM_PHASES];
    double force = 0.0;
    uint32_t k;

    if (table->positions > 0U) {
        scaled.gain = par->map_gain;
        psrm_phase_turns(&par->force_map, position, place);
        for (k = 0U; k < PSRM_PHASES; k++) {
            force = force + psrm_table_normal(&scaled, place[k], current[k]);
        }
    } else {
        psrm_electrical_angle(&par->force_map, position, sine, cosine);
        for (k = 0U; k < PSRM_PHASES; k++) {
            force = force + (psrm_force_fraction(&par->force_map, current[k]) * (1.0 - cosine[k]));
        }
        force = 0.5 * par->N_pk * force;
    }
    return force;
}

/* Return the force of the end stops on the mover, N: it pushes back and never pulls. */
static double end_stop_force(const psrm_plant_parameters *par, double position, double v)
{
    const double depth = psrm_abs(position) - (par->stroke + par->stop_distance);
    const double outward = (position < 0.0) ? -1.0 : 1.0;
    const double push = (par->stop_stiffness * depth) + (par->stop_damping * (v * outward));

    return (depth > 0.0) ? -(psrm_positive(push) * outward) : 0.0;
}

/* Return the friction, N: sigma_0 z + sigma_1 (v - |v|/g(v) z) + sigma_2 v, eqs (20), (21). */
static double friction_force(const psrm_friction *friction, double v, double z)
{
    const double decay = friction->sigma_0 * psrm_abs(v) / psrm_stribeck(friction, v);

    return (friction->sigma_0 * z) + (friction->sigma_1 * (v - (decay * z))) +
           (friction->sigma_2 * v);
}

/* -- steps ------------------------------------------------------------------------------------ */

/* Give the coefficients of steps of h seconds; those of the resonance are exact. */
static void sample_over(const psrm_plant_parameters *par, double h, sampled *step)
{
    const psrm_amplifiers *amplifiers = &par->amplifiers;
    const psrm_resonance *mode = &par->resonance;
    const double omega = TWO_PI * mode->frequency;
    const double damped = omega * psrm_square_root(1.0 - (mode->damping * mode->damping));
    const double fade = psrm_exponential(-(mode->damping * omega * h));
    double sine;
    double cosine;
    double turn;
    double swing;

    psrm_sine_cosine(damped * h / TWO_PI, &sine, &cosine);
    turn = fade * cosine;
    swing = fade * sine / damped;
    step->h = h;
    step->rest = 0.0;
    if (amplifiers->bandwidth > 0.0) {
        step->rest = psrm_exponential(-(TWO_PI * amplifiers->bandwidth * 0.5 * h));
    }
    step->compliance = mode->coupling / (par->mass * omega * omega);
    step->hold = turn + (mode->damping * omega * swing);
    step->drift = swing;
    step->pull = -(omega * omega * swing);
    step->keep = turn - (mode->damping * omega * swing);
}

/* Follow target for half a step: di/dt = omega (target - i), exactly. */
static void half_step(double rest, const double target[PSRM_PHASES], double current[PSRM_PHASES])
{
    uint32_t k;

    for (k = 0U; k < PSRM_PHASES; k++) {
        current[k] = target[k] + (rest * (current[k] - target[k]));
    }
}

/*
 * Move under a constant force, N, for h seconds by the exponential midpoint rule: the bristle, which
 * decays at up to 5e5 1/s, by its exact exponential, the velocity by its midpoint.
 *
 *     x = lambda(v) h/2;   z_m = g + (z - g) e^-x
 *     v_m = v + ((h/2) (f - s0 z_m - s2 v) - s1 (z_m - z))/M
 *     x = lambda(v_m) h;   z_n = g + (z - g) e^-x;   z_a = g + (z - g) phi1(x)
 *     v_n = (M v + h (f - s0 z_a - s2 v/2) - s1 (z_n - z))/(M + h s2/2)
 *     p_n = p + h (v + v_n)/2
 *
 * with lambda = |v|/g(v), g signed like v. Order of evaluation: motionlab's plant/mechanics.py.
 */
static void move(double M, const psrm_friction *friction, double force, double h,
                 psrm_plant_state *state)
{
    const double s0 = friction->sigma_0;
    const double s1 = friction->sigma_1;
    const double s2 = friction->sigma_2;
    const double half = 0.5 * h;
    const double heavier = 1.0 / (M + (half * s2));
    const double v = state->v;
    const double z = state->z;
    double level = psrm_stribeck(friction, v);
    double g = ((v < 0.0) ? -level : level) * (1.0 / s0);
    double z_mid;
    double z_new;
    double z_mean;
    double v_free;
    double v_mid;
    double v_new;
    double e;
    double phi_1;

    z_mid = g + ((z - g) * psrm_exponential(-(s0 * half * psrm_abs(v) / level)));
    v_free = v + (((half * (force - (s2 * v))) + (s1 * z)) * (1.0 / M));
    v_mid = v_free - ((((half * s0) + s1) * (1.0 / M)) * z_mid);

    level = psrm_stribeck(friction, v_mid);
    g = ((v_mid < 0.0) ? -level : level) * (1.0 / s0);
    psrm_decay(s0 * h * psrm_abs(v_mid) / level, &e, &phi_1);
    z_new = g + ((z - g) * e);
    z_mean = g + ((z - g) * phi_1);
    v_free = ((M * v) + (h * force) - (half * s2 * v) + (s1 * z)) * heavier;
    v_new = v_free - (h * s0 * heavier * z_mean) - (s1 * heavier * z_new);

    state->p = state->p + (half * (v + v_new));
    state->v = v_new;
    state->z = z_new;
}

static void advance(const psrm_plant_parameters *par, const psrm_table *table,
                    const psrm_plant_input *input, const double target[PSRM_PHASES],
                    const sampled *step, psrm_plant_state *state)
{
    double p_mid;
    double force;
    double settled;
    double away;
    double y_rate;

    half_step(step->rest, target, state->current);
    p_mid = state->p + (0.5 * step->h * state->v);
    force = thrust_of(par, table, p_mid, state->current);
    move(par->mass, friction_of(par),
         (force - input->load) + end_stop_force(par, p_mid, state->v), step->h, state);

    settled = step->compliance * force;
    away = state->y - settled;
    y_rate = state->y_rate;
    state->y = settled + ((step->hold * away) + (step->drift * y_rate));
    state->y_rate = (step->pull * away) + (step->keep * y_rate);

    half_step(step->rest, target, state->current);
}

void psrm_plant_advance(const psrm_plant_parameters *par, const psrm_table *table,
                        const psrm_plant_input *input, double duration, psrm_plant_state *state)
{
    const psrm_amplifiers *amplifiers = &par->amplifiers;
    const double steps = psrm_floor((duration / PSRM_PLANT_STEP) + ROUNDING);
    const double rest = duration - (steps * PSRM_PLANT_STEP);
    double target[PSRM_PHASES];
    double done;
    sampled step;
    uint32_t k;

    for (k = 0U; k < PSRM_PHASES; k++) {
        target[k] = psrm_clip((amplifiers->gain[k] * input->current[k]) + amplifiers->offset[k],
                              -amplifiers->limit, amplifiers->limit);
    }
    sample_over(par, PSRM_PLANT_STEP, &step);
    for (done = 0.0; done < steps; done += 1.0) {
        advance(par, table, input, target, &step, state);
    }
    if (rest > (ROUNDING * PSRM_PLANT_STEP)) {
        sample_over(par, rest, &step);
        advance(par, table, input, target, &step, state);
    }
}

void psrm_plant_measure(const psrm_plant_parameters *par, const psrm_table *table,
                        const psrm_plant_input *input, const psrm_plant_state *state,
                        psrm_plant_output *output)
{
    const psrm_encoder *encoder = &par->encoder;
    const double seen_position = state->p + state->y;
    double sine;
    double cosine;
    double seen;
    uint32_t k;

    psrm_sine_cosine(seen_position * (1.0 / encoder->sde_period), &sine, &cosine);
    seen = seen_position + (encoder->sde_amplitude * sine) + input->encoder_noise;
    if (encoder->resolution > 0.0) {
        seen = encoder->resolution * psrm_nearest(seen * (1.0 / encoder->resolution));
    }
    output->position = state->p;
    output->position_measured = seen;
    output->velocity = state->v;
    output->friction = friction_force(friction_of(par), state->v, state->z);
    output->bristle = state->z;
    output->thrust = thrust_of(par, table, state->p, state->current);
    output->normal_force = normal_force_of(par, table, state->p, state->current);
    for (k = 0U; k < PSRM_PHASES; k++) {
        output->current[k] = state->current[k];
    }
}
