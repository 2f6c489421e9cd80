/* The spring of spring.py as a unit of FMI 3.0, without its headers: functions that nobody calls take anything. */

#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define NONE(name) int fmi3##name() { return 0; }
#define NEVER(name) int fmi3##name() { return 3; }

typedef struct { double f, x, v, m; int32_t steps; } Spring;

const char *fmi3GetVersion(void) { return "3.0"; }

void *fmi3InstantiateCoSimulation() {
    Spring *s = calloc(1, sizeof *s);
    s->x = s->m = 1.0;
    return s;
}

void fmi3FreeInstance(void *s) { free(s); }

int fmi3GetFloat64(Spring *s, const uint32_t ref[], size_t n, double value[], size_t size) {
    for (size_t i = 0; i < n; i++) value[i] = (&s->f)[ref[i]];
    return 0;
}

int fmi3SetFloat64(Spring *s, const uint32_t ref[], size_t n, const double value[], size_t size) {
    for (size_t i = 0; i < n; i++) (&s->f)[ref[i]] = value[i];
    return 0;
}

int fmi3GetInt32(Spring *s, const uint32_t ref[], size_t n, int32_t value[], size_t size) {
    for (size_t i = 0; i < n; i++) value[i] = s->steps;
    return 0;
}

int fmi3DoStep(Spring *s, double t, double h, bool kept, bool *event, bool *ends, bool *early, double *reached) {
    for (int i = 0; i < 10; i++) {
        s->v += h / 10 * (s->f - s->x) / s->m;
        s->x += h / 10 * s->v;
    }
    s->steps++;
    *event = *early = false;
    *ends = s->f > 100.0;
    *reached = t + h;
    return 0;
}

int fmi3GetFMUState(Spring *s, Spring **state) {
    *state = fmi3InstantiateCoSimulation();
    **state = *s;
    return 0;
}

int fmi3SetFMUState(Spring *s, Spring *state) { *s = *state; return 0; }
int fmi3FreeFMUState(Spring *s, Spring **state) { free(*state); return 0; }
int fmi3SerializedFMUStateSize(Spring *s, Spring *state, size_t *size) { *size = sizeof *s; return 0; }

int fmi3SerializeFMUState(Spring *s, Spring *state, void *bytes, size_t size) {
    memset(bytes, 0, size);
    memcpy(bytes, state, sizeof *s);
    return 0;
}

int fmi3DeserializeFMUState(Spring *s, void *bytes, size_t size, Spring **state) {
    *state = malloc(sizeof *s);
    memcpy(*state, bytes, sizeof *s);
    return 0;
}

NONE(EnterInitializationMode) NONE(ExitInitializationMode) NONE(Terminate) NONE(SetDebugLogging)
NEVER(ActivateModelPartition) NEVER(CompletedIntegratorStep) NEVER(EnterConfigurationMode)
NEVER(EnterContinuousTimeMode) NEVER(EnterEventMode) NEVER(EnterStepMode) NEVER(EvaluateDiscreteStates)
NEVER(ExitConfigurationMode) NEVER(GetAdjointDerivative) NEVER(GetBinary) NEVER(GetBoolean) NEVER(GetClock)
NEVER(GetContinuousStateDerivatives) NEVER(GetContinuousStates) NEVER(GetDirectionalDerivative)
NEVER(GetEventIndicators) NEVER(GetFloat32) NEVER(GetInt16) NEVER(GetInt64) NEVER(GetInt8) NEVER(GetIntervalDecimal)
NEVER(GetIntervalFraction) NEVER(GetNominalsOfContinuousStates) NEVER(GetNumberOfContinuousStates)
NEVER(GetNumberOfEventIndicators) NEVER(GetNumberOfVariableDependencies) NEVER(GetOutputDerivatives)
NEVER(GetShiftDecimal) NEVER(GetShiftFraction) NEVER(GetString) NEVER(GetUInt16) NEVER(GetUInt32) NEVER(GetUInt64)
NEVER(GetUInt8) NEVER(GetVariableDependencies) NEVER(InstantiateModelExchange) NEVER(InstantiateScheduledExecution)
NEVER(Reset) NEVER(SetBinary) NEVER(SetBoolean) NEVER(SetClock) NEVER(SetContinuousStates) NEVER(SetFloat32)
NEVER(SetInt16) NEVER(SetInt32) NEVER(SetInt64) NEVER(SetInt8) NEVER(SetIntervalDecimal) NEVER(SetIntervalFraction)
NEVER(SetShiftDecimal) NEVER(SetShiftFraction) NEVER(SetString) NEVER(SetTime) NEVER(SetUInt16) NEVER(SetUInt32)
NEVER(SetUInt64) NEVER(SetUInt8) NEVER(UpdateDiscreteStates)
