
/* The Functional Mock-up Interface 2.0 for co-simulation, around the model. Names, types and values are those of the
   specification (FMI 2.0.4, sections 2.1 and 4.2). */
#include <stddef.h>
#include <string.h>
#include "model.c"

#if defined _WIN32
#define EXPORTED __declspec(dllexport)
#else
#define EXPORTED __attribute__((visibility("default")))
#endif

typedef void *fmi2Component;
typedef void *fmi2ComponentEnvironment;
typedef void *fmi2FMUstate;
typedef unsigned int fmi2ValueReference;
typedef double fmi2Real;
typedef int fmi2Integer;
typedef int fmi2Boolean;
typedef char fmi2Char;
typedef const fmi2Char *fmi2String;
typedef char fmi2Byte;
typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef enum { fmi2ModelExchange, fmi2CoSimulation } fmi2Type;
typedef enum { fmi2DoStepStatus, fmi2PendingStatus, fmi2LastSuccessfulTime, fmi2Terminated } fmi2StatusKind;

typedef struct {
    void (*logger)(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String, ...);
    void *(*allocateMemory)(size_t, size_t);
    void (*freeMemory)(void *);
    void (*stepFinished)(fmi2ComponentEnvironment, fmi2Status);
    fmi2ComponentEnvironment componentEnvironment;
} fmi2CallbackFunctions;

/* Value references, as in modelDescription.xml. */
enum { INPUT, LOAD_TORQUE, POSITION, VELOCITY, CURRENT, REPORTED, START_POSITION };

typedef struct {
    actuator_state state;
    double input;
    double load_torque;
    double start_position;
    fmi2CallbackFunctions functions;
} instance;

EXPORTED fmi2String fmi2GetTypesPlatform(void)
{
    return "default";
}

EXPORTED fmi2String fmi2GetVersion(void)
{
    return "2.0";
}

EXPORTED fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t count, const fmi2String categories[])
{
    (void)c, (void)on, (void)count, (void)categories;
    return fmi2OK;
}

static void restart(instance *own)
{
    own->input = 0.0;
    own->load_torque = 0.0;
    own->start_position = 0.0;
    actuator_start(&own->state, own->start_position);
}

EXPORTED fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                                       const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging)
{
    instance *own;
    (void)resources, (void)visible, (void)logging;
    if (functions == NULL || functions->allocateMemory == NULL || functions->freeMemory == NULL)
        return NULL;
    if (type != fmi2CoSimulation || guid == NULL || strcmp(guid, GUID) != 0) {
        if (functions->logger != NULL)
            functions->logger(functions->componentEnvironment, name, fmi2Error, "error",
                              "expected co-simulation, and the GUID of modelDescription.xml");
        return NULL;
    }
    own = functions->allocateMemory(1, sizeof *own);
    if (own == NULL)
        return NULL;
    own->functions = *functions;
    restart(own);
    return own;
}

EXPORTED void fmi2FreeInstance(fmi2Component c)
{
    instance *own = c;
    if (own != NULL)
        own->functions.freeMemory(own);
}

EXPORTED fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean has_tolerance, fmi2Real tolerance, fmi2Real start,
                                        fmi2Boolean has_stop, fmi2Real stop)
{
    /* Time counts from the start of the model, whatever the master's clock shows. */
    (void)c, (void)has_tolerance, (void)tolerance, (void)start, (void)has_stop, (void)stop;
    return fmi2OK;
}

EXPORTED fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    (void)c;
    return fmi2OK;
}

EXPORTED fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    instance *own = c;
    actuator_start(&own->state, own->start_position);
    return fmi2OK;
}

EXPORTED fmi2Status fmi2Terminate(fmi2Component c)
{
    (void)c;
    return fmi2OK;
}

EXPORTED fmi2Status fmi2Reset(fmi2Component c)
{
    restart(c);
    return fmi2OK;
}

EXPORTED fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference references[], size_t count, fmi2Real values[])
{
    const instance *own = c;
    size_t k;
    for (k = 0; k < count; ++k) {
        switch (references[k]) {
        case INPUT: values[k] = own->input; break;
        case LOAD_TORQUE: values[k] = own->load_torque; break;
        case POSITION: values[k] = own->state.position; break;
        case VELOCITY: values[k] = own->state.velocity; break;
        case CURRENT: values[k] = own->state.current; break;
        case REPORTED: values[k] = own->state.reported; break;
        case START_POSITION: values[k] = own->start_position; break;
        default: return fmi2Error;
        }
    }
    return fmi2OK;
}

EXPORTED fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference references[], size_t count,
                                const fmi2Real values[])
{
    instance *own = c;
    size_t k;
    for (k = 0; k < count; ++k) {
        switch (references[k]) {
        case INPUT: own->input = values[k]; break;
        case LOAD_TORQUE: own->load_torque = values[k]; break;
        case START_POSITION:
            own->start_position = values[k];
            actuator_start(&own->state, values[k]);
            break;
        default: return fmi2Error;
        }
    }
    return fmi2OK;
}

/* There are real variables alone. */
#define NONE_OF(TYPE, NAME)                                                                                           \
    EXPORTED fmi2Status fmi2Get##NAME(fmi2Component c, const fmi2ValueReference references[], size_t count,            \
                                      TYPE values[])                                                                   \
    {                                                                                                                  \
        (void)c, (void)references, (void)values;                                                                       \
        return count == 0 ? fmi2OK : fmi2Error;                                                                        \
    }                                                                                                                  \
    EXPORTED fmi2Status fmi2Set##NAME(fmi2Component c, const fmi2ValueReference references[], size_t count,            \
                                      const TYPE values[])                                                             \
    {                                                                                                                  \
        (void)c, (void)references, (void)values;                                                                       \
        return count == 0 ? fmi2OK : fmi2Error;                                                                        \
    }
NONE_OF(fmi2Integer, Integer)
NONE_OF(fmi2Boolean, Boolean)
NONE_OF(fmi2String, String)

EXPORTED fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *kept)
{
    const instance *own = c;
    if (*kept == NULL)
        *kept = own->functions.allocateMemory(1, sizeof *own);
    if (*kept == NULL)
        return fmi2Error;
    memcpy(*kept, own, sizeof *own);
    return fmi2OK;
}

EXPORTED fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate kept)
{
    memcpy(c, kept, sizeof(instance));
    return fmi2OK;
}

EXPORTED fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *kept)
{
    const instance *own = c;
    if (*kept != NULL)
        own->functions.freeMemory(*kept);
    *kept = NULL;
    return fmi2OK;
}

EXPORTED fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate kept, size_t *size)
{
    (void)c, (void)kept, (void)size;
    return fmi2Error;
}

EXPORTED fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate kept, fmi2Byte bytes[], size_t size)
{
    (void)c, (void)kept, (void)bytes, (void)size;
    return fmi2Error;
}

EXPORTED fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *kept)
{
    (void)c, (void)bytes, (void)size, (void)kept;
    return fmi2Error;
}

EXPORTED fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[], size_t unknowns,
                                                 const fmi2ValueReference known[], size_t knowns,
                                                 const fmi2Real seed[], fmi2Real sensitivity[])
{
    (void)c, (void)unknown, (void)unknowns, (void)known, (void)knowns, (void)seed, (void)sensitivity;
    return fmi2Error;
}

EXPORTED fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference references[], size_t count,
                                                const fmi2Integer order[], const fmi2Real values[])
{
    (void)c, (void)references, (void)count, (void)order, (void)values;
    return fmi2Error;
}

EXPORTED fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference references[], size_t count,
                                                 const fmi2Integer order[], fmi2Real values[])
{
    (void)c, (void)references, (void)count, (void)order, (void)values;
    return fmi2Error;
}

EXPORTED fmi2Status fmi2DoStep(fmi2Component c, fmi2Real now, fmi2Real step, fmi2Boolean no_set_before)
{
    instance *own = c;
    (void)now, (void)no_set_before;
    if (!isfinite(step) || step < 0.0)
        return fmi2Error;
    actuator_step(&own->state, own->input, own->load_torque, step);
    return fmi2OK;
}

EXPORTED fmi2Status fmi2CancelStep(fmi2Component c)
{
    (void)c;
    return fmi2Error;
}

/* No step is ever pending. */
#define STATUS(TYPE, NAME)                                                                                            \
    EXPORTED fmi2Status fmi2Get##NAME(fmi2Component c, const fmi2StatusKind kind, TYPE *value)                         \
    {                                                                                                                  \
        (void)c, (void)kind, (void)value;                                                                              \
        return fmi2Discard;                                                                                            \
    }
STATUS(fmi2Status, Status)
STATUS(fmi2Real, RealStatus)
STATUS(fmi2Integer, IntegerStatus)
STATUS(fmi2Boolean, BooleanStatus)
STATUS(fmi2String, StringStatus)
