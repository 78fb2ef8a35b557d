/* All that a state of the unit consists of: a controller of two axes. */
#ifndef PSRM_UNIT_H
#define PSRM_UNIT_H

#include "psrm_controller.h"

typedef struct {
    uint32_t mode;
    double time; /* s */
    psrm_parameters par;
    psrm_reference reference[PSRM_AXES];
    double position[PSRM_AXES]; /* measured, m */
    psrm_state state;
    psrm_output out;
} psrm_memory;

#endif
