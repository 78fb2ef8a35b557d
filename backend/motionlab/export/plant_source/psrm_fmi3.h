/* One instance of the co-simulation unit, and its table of variables. */
#ifndef PSRM_FMI3_H
#define PSRM_FMI3_H

#include <stddef.h>
#include <stdint.h>

#include "psrm_plant.h"

/* All that a state of the unit consists of */
typedef struct {
    uint32_t mode;
    double time; /* s */
    psrm_plant_parameters par[PSRM_AXES];
    psrm_plant_input in[PSRM_AXES];
    psrm_plant_state state[PSRM_AXES];
    psrm_plant_output out[PSRM_AXES];
} psrm_memory;

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

/* Generated: psrm_variables.c */
extern const char *const PSRM_INSTANTIATION_TOKEN;
extern const uint32_t PSRM_VARIABLES;
extern const psrm_variable PSRM_VARIABLE[];

#endif
