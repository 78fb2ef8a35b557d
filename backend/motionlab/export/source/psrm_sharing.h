#ifndef PSRM_SHARING_H
#define PSRM_SHARING_H

#include "psrm_controller.h"

/*
 * Share a force command, N, among the three phases of an axis at the measured position, m.
 *
 * current: overwritten with the current commands, A.
 * force: overwritten with what they give on the controller's map, N.
 * Return 1 where the current limit keeps them from giving all of the command, else 0.
 */
uint8_t psrm_share(const psrm_sharing *sharing, double position, double command,
                   double current[PSRM_PHASES], double *force);

#endif
