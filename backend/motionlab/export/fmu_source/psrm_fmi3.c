/*
 * FMI 3.0 for co-simulation around psrm_unit.c. The headers of FMI 3.0 belong to the importer.
 */
#include "fmi3Functions.h"
#include "psrm_fmi3.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MESSAGE_LENGTH 200U

enum { INSTANTIATED, INITIALIZATION, STEP, TERMINATED };

typedef struct {
    psrm_memory memory;
    uint8_t stale; /* 1: outputs are older than what they depend on */
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
} unit;

/* -- helpers ---------------------------------------------------------------------------------- */

static fmi3Status failed(const unit *u, const char *message)
{
    if (u->log != NULL) {
        u->log(u->environment, fmi3Error, "logStatusError", message);
    }
    return fmi3Error;
}

static fmi3Status unsupported(fmi3Instance instance, const char *name)
{
    char message[MESSAGE_LENGTH];

    (void)snprintf(message, sizeof message, "%s is not supported", name);
    return (instance != NULL) ? failed((const unit *)instance, message) : fmi3Error;
}

static double *place(unit *u, const psrm_variable *variable)
{
    return (double *)(void *)((char *)&u->memory + variable->offset);
}

static void restart(unit *u)
{
    uint32_t i;

    (void)memset(&u->memory, 0, sizeof u->memory);
    psrm_unit_initialise(&u->memory);
    for (i = 0U; i < PSRM_VARIABLES; i++) {
        *place(u, &PSRM_VARIABLE[i]) = PSRM_VARIABLE[i].start;
    }
    psrm_unit_reset(&u->memory);
    u->memory.mode = INSTANTIATED;
    u->stale = 1U;
}

static fmi3Status checked(const unit *u)
{
    fmi3Status status = fmi3OK;
    char message[MESSAGE_LENGTH];
    const char *refusal;
    uint32_t axis;

    for (axis = 0U; axis < PSRM_AXES; axis++) {
        refusal = psrm_unit_refusal(&u->memory, axis);
        if (refusal != NULL) {
            (void)snprintf(message, sizeof message, "axis %c: %s", (axis == 0U) ? 'x' : 'y',
                           refusal);
            status = failed(u, message);
        }
    }
    return status;
}

static const psrm_variable *found(const unit *u, fmi3ValueReference reference, psrm_type type)
{
    char message[MESSAGE_LENGTH];

    if ((reference < PSRM_VARIABLES) && (PSRM_VARIABLE[reference].type == type)) {
        return &PSRM_VARIABLE[reference];
    }
    (void)snprintf(message, sizeof message, "value reference %lu is of no such variable",
                   (unsigned long)reference);
    (void)failed(u, message);
    return NULL;
}

static fmi3Status get(unit *u, fmi3ValueReference reference, psrm_type type, double *value)
{
    const psrm_variable *variable = found(u, reference, type);

    if (variable == NULL) {
        return fmi3Error;
    }
    if (u->stale != 0U) {
        psrm_unit_measure(&u->memory);
        u->stale = 0U;
    }
    *value = *place(u, variable);
    return fmi3OK;
}

static fmi3Status set(unit *u, fmi3ValueReference reference, psrm_type type, double value)
{
    const psrm_variable *variable = found(u, reference, type);
    char message[MESSAGE_LENGTH];

    if (variable == NULL) {
        return fmi3Error;
    }
    if ((variable->causality == PSRM_OUTPUT) || (u->memory.mode == TERMINATED) ||
        ((variable->causality == PSRM_FIXED) && (u->memory.mode == STEP))) {
        (void)snprintf(message, sizeof message, "%s cannot be set now", variable->name);
        return failed(u, message);
    }
    if (!((value >= variable->least) && (value <= variable->most)) || /* NaN too */
        ((variable->open != 0U) && (value <= variable->least))) {
        (void)snprintf(message, sizeof message, "%s = %g is not from %g%s to %g", variable->name,
                       value, variable->least, (variable->open != 0U) ? " (excluded)" : "",
                       variable->most);
        return failed(u, message);
    }
    *place(u, variable) = value;
    if (u->memory.mode != STEP) {
        psrm_unit_reset(&u->memory);
    }
    u->stale = 1U;
    return fmi3OK;
}

static fmi3Status enter(fmi3Instance instance, uint32_t from, uint32_t to, const char *name)
{
    unit *u = (unit *)instance;
    char message[MESSAGE_LENGTH];

    if (u->memory.mode != from) {
        (void)snprintf(message, sizeof message, "%s cannot be called now", name);
        return failed(u, message);
    }
    u->memory.mode = to;
    return fmi3OK;
}

/* -- creation and modes ----------------------------------------------------------------------- */

const char *fmi3GetVersion(void)
{
    return fmi3Version;
}

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean loggingOn, size_t nCategories,
                               const fmi3String categories[])
{
    (void)instance; /* errors are always logged, and nothing else is */
    (void)loggingOn;
    (void)nCategories;
    (void)categories;
    return fmi3OK;
}

fmi3Instance fmi3InstantiateCoSimulation(
    fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath,
    fmi3Boolean visible, fmi3Boolean loggingOn, fmi3Boolean eventModeUsed,
    fmi3Boolean earlyReturnAllowed, const fmi3ValueReference requiredIntermediateVariables[],
    size_t nRequiredIntermediateVariables, fmi3InstanceEnvironment instanceEnvironment,
    fmi3LogMessageCallback logMessage, fmi3IntermediateUpdateCallback intermediateUpdate)
{
    unit *u = NULL;

    (void)instanceName;
    (void)resourcePath;
    (void)visible;
    (void)loggingOn;
    (void)eventModeUsed;
    (void)earlyReturnAllowed;
    (void)requiredIntermediateVariables;
    (void)nRequiredIntermediateVariables;
    (void)intermediateUpdate;
    if ((instantiationToken != NULL) && (strcmp(instantiationToken, PSRM_INSTANTIATION_TOKEN) == 0)) {
        u = (unit *)malloc(sizeof(unit));
    } else if (logMessage != NULL) {
        logMessage(instanceEnvironment, fmi3Error, "logStatusError",
                   "the instantiation token is not that of modelDescription.xml");
    } else {
        u = NULL;
    }
    if (u != NULL) {
        u->environment = instanceEnvironment;
        u->log = logMessage;
        restart(u);
    }
    return (fmi3Instance)u;
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String instanceName, fmi3String instantiationToken,
                                          fmi3String resourcePath, fmi3Boolean visible,
                                          fmi3Boolean loggingOn,
                                          fmi3InstanceEnvironment instanceEnvironment,
                                          fmi3LogMessageCallback logMessage)
{
    (void)instanceName;
    (void)instantiationToken;
    (void)resourcePath;
    (void)visible;
    (void)loggingOn;
    (void)instanceEnvironment;
    (void)logMessage;
    return NULL;
}

fmi3Instance fmi3InstantiateScheduledExecution(
    fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath,
    fmi3Boolean visible, fmi3Boolean loggingOn, fmi3InstanceEnvironment instanceEnvironment,
    fmi3LogMessageCallback logMessage, fmi3ClockUpdateCallback clockUpdate,
    fmi3LockPreemptionCallback lockPreemption, fmi3UnlockPreemptionCallback unlockPreemption)
{
    (void)clockUpdate;
    (void)lockPreemption;
    (void)unlockPreemption;
    return fmi3InstantiateModelExchange(instanceName, instantiationToken, resourcePath, visible,
                                        loggingOn, instanceEnvironment, logMessage);
}

void fmi3FreeInstance(fmi3Instance instance)
{
    free(instance);
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean toleranceDefined,
                                       fmi3Float64 tolerance, fmi3Float64 startTime,
                                       fmi3Boolean stopTimeDefined, fmi3Float64 stopTime)
{
    (void)toleranceDefined;
    (void)tolerance;
    (void)stopTimeDefined;
    (void)stopTime;
    ((unit *)instance)->memory.time = startTime;
    return enter(instance, INSTANTIATED, INITIALIZATION, "fmi3EnterInitializationMode");
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance)
{
    fmi3Status status = checked((const unit *)instance);

    if (status == fmi3OK) {
        status = enter(instance, INITIALIZATION, STEP, "fmi3ExitInitializationMode");
    }
    return status;
}

fmi3Status fmi3Terminate(fmi3Instance instance)
{
    return enter(instance, STEP, TERMINATED, "fmi3Terminate");
}

fmi3Status fmi3Reset(fmi3Instance instance)
{
    restart((unit *)instance);
    return fmi3OK;
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 currentCommunicationPoint,
                      fmi3Float64 communicationStepSize,
                      fmi3Boolean noSetFMUStatePriorToCurrentPoint,
                      fmi3Boolean *eventHandlingNeeded, fmi3Boolean *terminateSimulation,
                      fmi3Boolean *earlyReturn, fmi3Float64 *lastSuccessfulTime)
{
    unit *u = (unit *)instance;
    psrm_memory *m = &u->memory;
    const char *reason;

    (void)noSetFMUStatePriorToCurrentPoint;
    *eventHandlingNeeded = fmi3False;
    *terminateSimulation = fmi3False;
    *earlyReturn = fmi3False;
    *lastSuccessfulTime = m->time;
    if (m->mode != STEP) {
        return failed(u, "fmi3DoStep cannot be called now");
    }
    if (!(communicationStepSize > 0.0) || !(communicationStepSize < 1e6)) {
        return failed(u, "the communication step size is not from 0 (excluded) to 1e6 s");
    }
    if (checked(u) != fmi3OK) {
        return fmi3Error;
    }
    reason = psrm_unit_advance(m, communicationStepSize);
    u->stale = 1U;
    if (reason != NULL) {
        return failed(u, reason);
    }
    m->time = currentCommunicationPoint + communicationStepSize;
    *lastSuccessfulTime = m->time;
    return fmi3OK;
}

/* -- variables -------------------------------------------------------------------------------- */

fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                          size_t nValueReferences, fmi3Float64 values[], size_t nValues)
{
    fmi3Status status = (nValueReferences == nValues) ? fmi3OK : fmi3Error;
    size_t i;

    for (i = 0U; (i < nValues) && (status == fmi3OK); i++) {
        status = get((unit *)instance, valueReferences[i], PSRM_FLOAT64, &values[i]);
    }
    return status;
}

fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                          size_t nValueReferences, const fmi3Float64 values[], size_t nValues)
{
    fmi3Status status = (nValueReferences == nValues) ? fmi3OK : fmi3Error;
    size_t i;

    for (i = 0U; (i < nValues) && (status == fmi3OK); i++) {
        status = set((unit *)instance, valueReferences[i], PSRM_FLOAT64, values[i]);
    }
    return status;
}

fmi3Status fmi3GetBoolean(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                          size_t nValueReferences, fmi3Boolean values[], size_t nValues)
{
    fmi3Status status = (nValueReferences == nValues) ? fmi3OK : fmi3Error;
    double value = 0.0;
    size_t i;

    for (i = 0U; (i < nValues) && (status == fmi3OK); i++) {
        status = get((unit *)instance, valueReferences[i], PSRM_BOOLEAN, &value);
        values[i] = (value != 0.0);
    }
    return status;
}

fmi3Status fmi3SetBoolean(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                          size_t nValueReferences, const fmi3Boolean values[], size_t nValues)
{
    fmi3Status status = (nValueReferences == nValues) ? fmi3OK : fmi3Error;
    size_t i;

    for (i = 0U; (i < nValues) && (status == fmi3OK); i++) {
        status = set((unit *)instance, valueReferences[i], PSRM_BOOLEAN, values[i] ? 1.0 : 0.0);
    }
    return status;
}

/* -- states ----------------------------------------------------------------------------------- */

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *FMUState)
{
    const unit *u = (const unit *)instance;

    if (*FMUState == NULL) {
        *FMUState = malloc(sizeof(psrm_memory));
    }
    if (*FMUState == NULL) {
        return failed(u, "there is no memory for a state");
    }
    (void)memcpy(*FMUState, &u->memory, sizeof(psrm_memory));
    return fmi3OK;
}

fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState FMUState)
{
    unit *u = (unit *)instance;

    (void)memcpy(&u->memory, FMUState, sizeof(psrm_memory));
    u->stale = 1U;
    return fmi3OK;
}

fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *FMUState)
{
    (void)instance;
    if (FMUState != NULL) {
        free(*FMUState);
        *FMUState = NULL;
    }
    return fmi3OK;
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState FMUState, size_t *size)
{
    (void)instance;
    (void)FMUState;
    *size = sizeof(psrm_memory);
    return fmi3OK;
}

fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState FMUState,
                                 fmi3Byte serializedState[], size_t size)
{
    if (size != sizeof(psrm_memory)) {
        return failed((const unit *)instance, "the size is not that of a serialized state");
    }
    (void)memcpy(serializedState, FMUState, size);
    return fmi3OK;
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte serializedState[],
                                   size_t size, fmi3FMUState *FMUState)
{
    fmi3Status status;

    if (size != sizeof(psrm_memory)) {
        return failed((const unit *)instance, "the size is not that of a serialized state");
    }
    status = fmi3GetFMUState(instance, FMUState);
    if (status == fmi3OK) {
        (void)memcpy(*FMUState, serializedState, size);
    }
    return status;
}

/* -- what this unit does not have ------------------------------------------------------------- */

/* Getter and setter of a type of which there is no variable */
#define NO_VARIABLES(Type)                                                                          \
    fmi3Status fmi3Get##Type(fmi3Instance instance, const fmi3ValueReference valueReferences[],    \
                             size_t nValueReferences, fmi3##Type values[], size_t nValues)         \
    {                                                                                              \
        (void)valueReferences;                                                                     \
        (void)values;                                                                              \
        (void)nValues;                                                                             \
        return (nValueReferences == 0U) ? fmi3OK : unsupported(instance, "fmi3Get" #Type);         \
    }                                                                                              \
    fmi3Status fmi3Set##Type(fmi3Instance instance, const fmi3ValueReference valueReferences[],    \
                             size_t nValueReferences, const fmi3##Type values[], size_t nValues)   \
    {                                                                                              \
        (void)valueReferences;                                                                     \
        (void)values;                                                                              \
        (void)nValues;                                                                             \
        return (nValueReferences == 0U) ? fmi3OK : unsupported(instance, "fmi3Set" #Type);         \
    }

NO_VARIABLES(Float32)
NO_VARIABLES(Int8)
NO_VARIABLES(UInt8)
NO_VARIABLES(Int16)
NO_VARIABLES(UInt16)
NO_VARIABLES(Int32)
NO_VARIABLES(UInt32)
NO_VARIABLES(Int64)
NO_VARIABLES(UInt64)
NO_VARIABLES(String)

/* A function of so many further arguments */
#define NONE_0(name)                                                                               \
    fmi3Status name(fmi3Instance instance)                                                         \
    {                                                                                              \
        return unsupported(instance, #name);                                                       \
    }
#define NONE_1(name, A)                                                                            \
    fmi3Status name(fmi3Instance instance, A a)                                                    \
    {                                                                                              \
        (void)a;                                                                                   \
        return unsupported(instance, #name);                                                       \
    }
#define NONE_2(name, A, B)                                                                         \
    fmi3Status name(fmi3Instance instance, A a, B b)                                               \
    {                                                                                              \
        (void)a;                                                                                   \
        (void)b;                                                                                   \
        return unsupported(instance, #name);                                                       \
    }
#define NONE_3(name, A, B, C)                                                                      \
    fmi3Status name(fmi3Instance instance, A a, B b, C c)                                          \
    {                                                                                              \
        (void)a;                                                                                   \
        (void)b;                                                                                   \
        (void)c;                                                                                   \
        return unsupported(instance, #name);                                                       \
    }
#define NONE_4(name, A, B, C, D)                                                                   \
    fmi3Status name(fmi3Instance instance, A a, B b, C c, D d)                                     \
    {                                                                                              \
        (void)a;                                                                                   \
        (void)b;                                                                                   \
        (void)c;                                                                                   \
        (void)d;                                                                                   \
        return unsupported(instance, #name);                                                       \
    }
#define NONE_5(name, A, B, C, D, E)                                                                \
    fmi3Status name(fmi3Instance instance, A a, B b, C c, D d, E e)                                \
    {                                                                                              \
        (void)a;                                                                                   \
        (void)b;                                                                                   \
        (void)c;                                                                                   \
        (void)d;                                                                                   \
        (void)e;                                                                                   \
        return unsupported(instance, #name);                                                       \
    }
#define NONE_6(name, A, B, C, D, E, F)                                                             \
    fmi3Status name(fmi3Instance instance, A a, B b, C c, D d, E e, F f)                           \
    {                                                                                              \
        (void)a;                                                                                   \
        (void)b;                                                                                   \
        (void)c;                                                                                   \
        (void)d;                                                                                   \
        (void)e;                                                                                   \
        (void)f;                                                                                   \
        return unsupported(instance, #name);                                                       \
    }

typedef const fmi3ValueReference *references;

NONE_0(fmi3EnterEventMode)
NONE_0(fmi3EnterStepMode)
NONE_0(fmi3EnterConfigurationMode)
NONE_0(fmi3ExitConfigurationMode)
NONE_0(fmi3EvaluateDiscreteStates)
NONE_2(fmi3GetNumberOfVariableDependencies, fmi3ValueReference, size_t *)
NONE_6(fmi3GetVariableDependencies, fmi3ValueReference, size_t *, fmi3ValueReference *, size_t *,
       fmi3DependencyKind *, size_t)
NONE_5(fmi3GetBinary, references, size_t, size_t *, fmi3Binary *, size_t)
NONE_5(fmi3SetBinary, references, size_t, const size_t *, const fmi3Binary *, size_t)
NONE_3(fmi3GetClock, references, size_t, fmi3Clock *)
NONE_3(fmi3SetClock, references, size_t, const fmi3Clock *)
NONE_4(fmi3GetIntervalDecimal, references, size_t, fmi3Float64 *, fmi3IntervalQualifier *)
NONE_5(fmi3GetIntervalFraction, references, size_t, fmi3UInt64 *, fmi3UInt64 *,
       fmi3IntervalQualifier *)
NONE_3(fmi3GetShiftDecimal, references, size_t, fmi3Float64 *)
NONE_4(fmi3GetShiftFraction, references, size_t, fmi3UInt64 *, fmi3UInt64 *)
NONE_3(fmi3SetIntervalDecimal, references, size_t, const fmi3Float64 *)
NONE_4(fmi3SetIntervalFraction, references, size_t, const fmi3UInt64 *, const fmi3UInt64 *)
NONE_3(fmi3SetShiftDecimal, references, size_t, const fmi3Float64 *)
NONE_4(fmi3SetShiftFraction, references, size_t, const fmi3UInt64 *, const fmi3UInt64 *)
NONE_6(fmi3UpdateDiscreteStates, fmi3Boolean *, fmi3Boolean *, fmi3Boolean *, fmi3Boolean *,
       fmi3Boolean *, fmi3Float64 *)
NONE_5(fmi3GetOutputDerivatives, references, size_t, const fmi3Int32 *, fmi3Float64 *, size_t)

#define NO_DERIVATIVE(name)                                                                        \
    fmi3Status name(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t nUnknowns,  \
                    const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[],   \
                    size_t nSeed, fmi3Float64 sensitivity[], size_t nSensitivity)                  \
    {                                                                                              \
        (void)unknowns;                                                                            \
        (void)nUnknowns;                                                                           \
        (void)knowns;                                                                              \
        (void)nKnowns;                                                                             \
        (void)seed;                                                                                \
        (void)nSeed;                                                                               \
        (void)sensitivity;                                                                         \
        (void)nSensitivity;                                                                        \
        return unsupported(instance, #name);                                                       \
    }

NO_DERIVATIVE(fmi3GetDirectionalDerivative)
NO_DERIVATIVE(fmi3GetAdjointDerivative)

/* Of model exchange and scheduled execution; some importers look for every function. */
NONE_0(fmi3EnterContinuousTimeMode)
NONE_3(fmi3CompletedIntegratorStep, fmi3Boolean, fmi3Boolean *, fmi3Boolean *)
NONE_1(fmi3SetTime, fmi3Float64)
NONE_2(fmi3SetContinuousStates, const fmi3Float64 *, size_t)
NONE_2(fmi3GetContinuousStateDerivatives, fmi3Float64 *, size_t)
NONE_2(fmi3GetEventIndicators, fmi3Float64 *, size_t)
NONE_2(fmi3GetContinuousStates, fmi3Float64 *, size_t)
NONE_2(fmi3GetNominalsOfContinuousStates, fmi3Float64 *, size_t)
NONE_1(fmi3GetNumberOfEventIndicators, size_t *)
NONE_1(fmi3GetNumberOfContinuousStates, size_t *)
NONE_2(fmi3ActivateModelPartition, fmi3ValueReference, fmi3Float64)
