/*
 * The controller of psrm_controller.c as a co-simulation unit.
 */
#include "psrm_fmi3.h"

#include <math.h>

/* A difference below this part of a period is rounding of the caller's time. */
static const double ROUNDING = 1e-6;

void psrm_unit_initialise(psrm_memory *memory)
{
    psrm_initial_parameters(&memory->par);
}

void psrm_unit_reset(psrm_memory *memory)
{
    psrm_reset(&memory->state);
}

const char *psrm_unit_refusal(const psrm_memory *memory, uint32_t axis)
{
    (void)memory; /* ranges are all that its variables have to keep */
    (void)axis;
    return NULL;
}

const char *psrm_unit_advance(psrm_memory *memory, double duration)
{
    const double periods = floor((duration / PSRM_PERIOD) + 0.5);
    double done;

    if ((periods < 1.0) || (fabs(duration - (periods * PSRM_PERIOD)) > (ROUNDING * PSRM_PERIOD))) {
        return "the communication step size is not a multiple of the control period, 0.0005 s";
    }
    for (done = 0.0; done < periods; done += 1.0) {
        psrm_step(&memory->par, &memory->state, memory->reference, memory->position, &memory->out);
    }
    return NULL;
}

void psrm_unit_measure(psrm_memory *memory)
{
    (void)memory; /* outputs are those of the last period */
}
