/* Early returns of fmi3DoStep, which the library of pythonfmu3 does not pass on. This library stands before that one:
   the slave shows as its first variables whether a step met an event, whether it ended early, and where. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdbool.h>
#include <stddef.h>

typedef void *Instance;
typedef int Status;
typedef unsigned int Reference;
typedef Status (*Step)(Instance, double, double, bool, bool *, bool *, bool *, double *);
typedef Status (*Get)(Instance, const Reference *, size_t, double *, size_t);
typedef Status (*Set)(Instance, const Reference *, size_t, const double *, size_t);
typedef Instance (*Make)(const char *, const char *, const char *, bool, bool, bool, bool, const Reference *, size_t,
                         void *, void *, void *);

static const Reference WANTED[] = {0}, SHOWN[] = {1, 2, 3}; /* stop at events; met one, ended early, time [s] */

Instance fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources, bool visible,
                                     bool logs, bool events, bool early, const Reference *wanted, size_t n,
                                     void *environment, void *log, void *update) {
    Make make = (Make)dlsym(RTLD_NEXT, "fmi3InstantiateCoSimulation");
    Set set = (Set)dlsym(RTLD_NEXT, "fmi3SetFloat64");
    Instance made = make(name, token, resources, visible, logs, events, early, wanted, n, environment, log, update);
    double stops = events && early;
    if (made) set(made, WANTED, 1, &stops, 1);
    return made;
}

Status fmi3DoStep(Instance unit, double begin, double length, bool final, bool *event, bool *over, bool *early,
                  double *time) {
    Step step = (Step)dlsym(RTLD_NEXT, "fmi3DoStep");
    Get get = (Get)dlsym(RTLD_NEXT, "fmi3GetFloat64");
    double shown[3];
    Status status = step(unit, begin, length, final, event, over, early, time);
    if (status == 0 && get(unit, SHOWN, 3, shown, 3) == 0) {
        *event = shown[0] != 0.0;
        *early = shown[1] != 0.0;
        *time = shown[2];
    }
    return status;
}
