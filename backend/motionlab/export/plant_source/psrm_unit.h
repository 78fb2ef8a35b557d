/* All that a state of the unit consists of: a motor of two axes. */
#ifndef PSRM_UNIT_H
#define PSRM_UNIT_H

#include "psrm_plant.h"

typedef struct {
    uint32_t mode;
    double time; /* s */
    psrm_plant_parameters par[PSRM_AXES];
    psrm_plant_input in[PSRM_AXES];
    psrm_plant_state state[PSRM_AXES];
    psrm_plant_output out[PSRM_AXES];
} psrm_memory;

#endif
