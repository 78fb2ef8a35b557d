/* One instance of the co-simulation unit, and its table of variables. */
#ifndef PSRM_FMI3_H
#define PSRM_FMI3_H

#include <stddef.h>
#include <stdint.h>

#include "psrm_unit.h"

typedef enum {
    PSRM_OUTPUT,  /* and what cannot be set else */
    PSRM_INPUT,
    PSRM_TUNABLE, /* a parameter that may be set at any time */
    PSRM_FIXED    /* a parameter that may be set before the first step */
} psrm_causality;

typedef enum { PSRM_FLOAT64, PSRM_BOOLEAN } psrm_type;

/* The place in its table is the variable's value reference. */
typedef struct {
    const char *name;
    size_t offset; /* of a double in psrm_memory */
    psrm_type type;
    psrm_causality causality;
    double start;
    double least;
    double most;
    uint8_t open; /* 1: the least value itself is not allowed */
} psrm_variable;

/* Of what the unit is: psrm_unit.c */

/* Give memory that is zero what no variable holds. */
void psrm_unit_initialise(psrm_memory *memory);

/* Put the state to the start. */
void psrm_unit_reset(psrm_memory *memory);

/* Return why an axis cannot be stepped, or NULL. */
const char *psrm_unit_refusal(const psrm_memory *memory, uint32_t axis);

/* Advance by a duration, s; return why that failed, or NULL. */
const char *psrm_unit_advance(psrm_memory *memory, double duration);

/* Compute the outputs. */
void psrm_unit_measure(psrm_memory *memory);

/* Generated: psrm_variables.c */
extern const char *const PSRM_INSTANTIATION_TOKEN;
extern const uint32_t PSRM_VARIABLES;
extern const psrm_variable PSRM_VARIABLE[];

#endif
