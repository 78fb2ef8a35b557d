#include "psrm_controller.h"

#include "psrm_friction.h"
#include "psrm_math.h"
#include "psrm_sharing.h"

static const double RATE = 1.0 / PSRM_PERIOD; /* Hz */

static const psrm_command NO_COMMAND = {0.0, 0.0, 0.0, 0.0, {0.0, 0.0, 0.0}};

/* Return the output of the notch filter for a force, N, and step its state. */
static double notch_output(const psrm_notch *notch, psrm_axis_state *state, double force)
{
    const double passed = (notch->b_0 * force) + state->notch_1;

    state->notch_1 = (notch->b_1 * force) - (notch->a_1 * passed) + state->notch_2;
    state->notch_2 = (notch->b_2 * force) - (notch->a_2 * passed);
    return passed;
}

/*
 * Return the force command before its limit, N.
 *
 * The notch filters PD and disturbance observer alone: friction estimate and feedforward would be
 * wrong if delayed, and feedforward cannot make a loop unstable.
 */
static double force_command(const psrm_axis_parameters *par, psrm_axis_state *state,
                            const psrm_reference *reference, double u, double added)
{
    const double opposed = (par->disturbance_observer != 0U) ? state->disturbance : 0.0;
    const double feedback = u + opposed;
    double force = u + added;

    if (par->feedforward != 0U) {
        force = force + (par->M * reference->acceleration);
    }
    force = force + opposed;
    return force + (notch_output(&par->notch, state, feedback) - feedback);
}

static void step_axis(const psrm_axis_parameters *par, psrm_axis_state *state,
                      const psrm_reference *reference, double position,
                      double current[PSRM_PHASES], psrm_signals *signals)
{
    const psrm_compensation *law = &par->compensation;
    const psrm_command acted = state->acting;
    const double error = reference->position - position;
    double error_rate = 0.0;
    double v = 0.0;
    double a = 0.0;
    double u;
    double f;
    uint8_t limited;
    uint32_t k;
    psrm_balance balance;
    psrm_command made;

    /* motion by differences; none on the first step */
    if (state->started != 0U) {
        error_rate = (error - state->error) * RATE;
        v = (position - state->position) * RATE;
        a = (v - state->velocity) * RATE;
    }

    /* eq. (15) */
    u = psrm_clip((par->k_p * error) + (par->k_d * error_rate), -par->force_limit,
                  par->force_limit);

    /* friction estimate */
    balance.v = (law->from_reference != 0U) ? reference->velocity : v;
    balance.error = error;
    balance.k_d = par->k_d;
    balance.u = u;
    balance.inertia = par->M * a;
    if (state->started != 0U) {
        state->residual = psrm_residual(law, &par->friction, &acted, state->residual,
                                        balance.inertia);
        state->disturbance = state->disturbance
            + (par->disturbance_alpha
               * ((acted.force - acted.added) - (par->M * a) - state->disturbance));
    }
    balance.residual = state->residual;
    made.K = psrm_adaptation(law, &par->friction, &balance);
    made.estimate = psrm_estimate_friction(law, &par->friction, balance.v, made.K,
                                           &state->bristle);
    made.added = (law->enabled != 0U) ? made.estimate : 0.0;

    /* force and currents */
    f = psrm_clip(force_command(par, state, reference, u, made.added), -par->force_limit,
                  par->force_limit);
    limited = psrm_share(&par->sharing, position, f, made.current, &made.force);
    if (par->ideal_force != 0U) {
        made.force = f;
        limited = 0U;
    }

    /* what acts from now on */
    state->acting = (par->delay != 0U) ? state->computed : made;
    state->computed = made;
    state->position = position;
    state->velocity = v;
    state->error = error;
    state->started = 1U;

    for (k = 0U; k < PSRM_PHASES; k++) {
        current[k] = state->acting.current[k];
        signals->current_next[k] = made.current[k];
    }
    signals->following_error = error;
    signals->velocity = v;
    signals->pd_force = u;
    signals->friction_estimate = made.estimate;
    signals->bristle_estimate = state->bristle;
    signals->K = made.K;
    signals->disturbance_estimate = state->disturbance;
    signals->force_command = f;
    signals->force_realised = state->acting.force;
    signals->force_saturated = (psrm_abs(f) >= par->force_limit) ? 1U : 0U;
    signals->current_saturated = limited;
    signals->healthy = ((psrm_abs(error) <= par->error_limit) && (psrm_abs(f) <= par->force_limit))
        ? 1U : 0U;
}

void psrm_reset(psrm_state *state)
{
    uint32_t k;

    for (k = 0U; k < PSRM_AXES; k++) {
        state->axis[k].started = 0U;
        state->axis[k].position = 0.0;
        state->axis[k].velocity = 0.0;
        state->axis[k].error = 0.0;
        state->axis[k].bristle = 0.0;
        state->axis[k].residual = 0.0;
        state->axis[k].disturbance = 0.0;
        state->axis[k].notch_1 = 0.0;
        state->axis[k].notch_2 = 0.0;
        state->axis[k].acting = NO_COMMAND;
        state->axis[k].computed = NO_COMMAND;
    }
}

void psrm_step(const psrm_parameters *parameters, psrm_state *state,
               const psrm_reference reference[PSRM_AXES], const double position[PSRM_AXES],
               psrm_output *output)
{
    uint32_t k;

    for (k = 0U; k < PSRM_AXES; k++) {
        step_axis(&parameters->axis[k], &state->axis[k], &reference[k], position[k],
                  output->current[k], &output->axis[k]);
    }
}
