/* A bouncing ball as a unit of FMI 3.0 with event mode, early returns at bounces, and a time event each second; its
   state and all other functions are those of spring.c: f counts seconds, x is the height, v the speed, m the time. */

#include <math.h>

#define fmi3InstantiateCoSimulation spring_instantiate
#define fmi3DoStep spring_step
#define fmi3EnterEventMode spring_event_mode
#define fmi3EnterStepMode spring_step_mode
#define fmi3UpdateDiscreteStates spring_update
#include "spring.c"
#undef fmi3InstantiateCoSimulation
#undef fmi3DoStep
#undef fmi3EnterEventMode
#undef fmi3EnterStepMode
#undef fmi3UpdateDiscreteStates

static const double g = 9.81, e = 0.8;

void *fmi3InstantiateCoSimulation() {
    Spring *s = spring_instantiate();
    s->m = 0.0;
    return s;
}

int fmi3DoStep(Spring *s, double t, double h, bool kept, bool *event, bool *ends, bool *early, double *reached) {
    double falls = (s->v + sqrt(s->v * s->v + 2.0 * g * s->x)) / g;
    *event = falls <= h;
    *early = falls < h;
    *ends = false;
    double passed = *event ? falls : h;
    s->x = *event ? 0.0 : s->x + passed * (s->v - 0.5 * g * passed);
    s->v -= g * passed;
    *reached = s->m = t + passed;
    return 0;
}

int fmi3UpdateDiscreteStates(Spring *s, bool *again, bool *ends, bool *nominals, bool *values, bool *timed,
                             double *next) {
    *again = *ends = *nominals = false;
    *values = s->x == 0.0 && s->v < 0.0;
    if (*values) {
        s->v *= -e;
        s->steps++;
    }
    s->f = floor(s->m + 1e-12);
    *timed = true;
    *next = s->f + 1.0;
    return 0;
}

NONE(EnterEventMode) NONE(EnterStepMode)
