/*
 * The motor of psrm_plant.c as a co-simulation unit.
 */
#include "psrm_fmi3.h"

#include <math.h>

/* A rest below this part of a step is rounding of the caller's time. */
static const double ROUNDING = 1e-6;

void psrm_unit_initialise(psrm_memory *memory)
{
    (void)memory; /* every number is a variable's */
}

void psrm_unit_reset(psrm_memory *memory)
{
    uint32_t axis;

    for (axis = 0U; axis < PSRM_AXES; axis++) {
        psrm_plant_reset(axis, &memory->par[axis], &memory->state[axis]);
    }
}

const char *psrm_unit_refusal(const psrm_memory *memory, uint32_t axis)
{
    const psrm_plant_parameters *par = &memory->par[axis];
    const double h = PSRM_PLANT_STEP;
    const bool rubs = par->friction_on != 0.0;
    const char *refusal = NULL;

    if (rubs && (par->friction.F_s < par->friction.F_c)) {
        refusal = "friction.F_s is below friction.F_c";
    } else if (par->mass < (h * par->stop_damping)) {
        refusal = "mass is too small for stop_damping: at least 1e-4 s stop_damping";
    } else if (par->mass < (h * h * par->stop_stiffness)) {
        refusal = "mass is too small for stop_stiffness: at least 1e-8 s^2 stop_stiffness";
    } else if (rubs && (par->mass < (h * h * par->friction.sigma_0))) {
        refusal = "mass is too small for friction.sigma_0: at least 1e-8 s^2 sigma_0";
    } else if (rubs && (par->mass < (h * par->friction.sigma_1))) {
        refusal = "mass is too small for friction.sigma_1: at least 1e-4 s sigma_1";
    } else {
        refusal = NULL;
    }
    return refusal;
}

/* Advance an axis by a duration, s, in steps of PSRM_PLANT_STEP and a shorter one for the rest. */
static void advance(psrm_memory *m, uint32_t axis, double duration)
{
    const double steps = floor((duration / PSRM_PLANT_STEP) + ROUNDING);
    const double rest = duration - (steps * PSRM_PLANT_STEP);
    psrm_plant_sampled step;
    double done;

    psrm_plant_sample(axis, &m->par[axis], PSRM_PLANT_STEP, &step);
    for (done = 0.0; done < steps; done += 1.0) {
        psrm_plant_step(axis, &m->par[axis], &step, &m->in[axis], &m->state[axis]);
    }
    if (rest > (ROUNDING * PSRM_PLANT_STEP)) {
        psrm_plant_sample(axis, &m->par[axis], rest, &step);
        psrm_plant_step(axis, &m->par[axis], &step, &m->in[axis], &m->state[axis]);
    }
}

const char *psrm_unit_advance(psrm_memory *memory, double duration)
{
    double sum = 0.0;
    uint32_t axis;

    for (axis = 0U; axis < PSRM_AXES; axis++) {
        const psrm_plant_state *state = &memory->state[axis];

        advance(memory, axis, duration);
        sum += state->p + state->v + state->z + state->y;
    }
    return ((sum - sum) != 0.0) ? "the motion is no longer finite" : NULL; /* infinite or NaN */
}

void psrm_unit_measure(psrm_memory *memory)
{
    psrm_memory *m = memory;
    uint32_t axis;

    for (axis = 0U; axis < PSRM_AXES; axis++) {
        psrm_plant_measure(axis, &m->par[axis], &m->in[axis], &m->state[axis], &m->out[axis]);
    }
}
