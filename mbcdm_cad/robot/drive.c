/* A cable drive as an FMU for co-simulation (FMI 2.0): motors, cables with hysteresis, parts that give, friction.

   Coordinates, at the drum, positive where they drive it positively: one for the rotor of each input, the drum, the
   payload, and one for each input's pulley where there is play between it and its motor. Springs, the elastic-slip elements of gearhead and cables, and dry friction are one kind of element: a spring of stiffness k
   over a difference of coordinates, which slips where its torque reaches a limit. The step is implicit:

       M (v' - v)/h = torques - sum of a F,   F = k (z + h a v') held within its limit,

   solved by Newton steps on the set of elements that slip; it is stable at any step. parameters.h holds the figures of
   one design; the value reference of a variable is its place in the array. SI throughout. */

#include "parameters.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

/* The types of fmi2TypesPlatform.h and fmi2FunctionTypes.h. */
typedef void *Component;
typedef unsigned int Reference;
typedef enum { OK, WARNING, DISCARD, ERROR, FATAL, PENDING } Status;

#define N (N_INPUTS + 2 + N_PULLEYS)
#define N_ELEMENTS (N_INPUTS + 2 + N_CABLES + N_PULLEYS)
#define DRUM N_INPUTS
#define PAYLOAD (N_INPUTS + 1)
/* What the cables of input i turn with. */
#define PULLEY(i) (N_PULLEYS ? N_INPUTS + 2 + (i) : (i))
#define STEP 1e-4
#define CORRECTIONS 30
/* Turn of the drum over which friction is elastic before it slides. */
#define PRESLIDING 2e-6

typedef struct {
  double arm[N], stiffness, limit, deflection, gap; /* gap: play, within which it carries nothing, to each side */
} Element;

typedef struct {
  double v[N_VALUES], angle[N], speed[N], carried[N_INPUTS], winding[N_INPUTS];
  Element element[N_ELEMENTS];
} Drive;

static const double START[N_VALUES] = VALUES;
static const double PRELOAD[N_INPUTS] = PRELOADS;
static const double TURN[N_INPUTS] = TURNS;
static const double PULLEY_INERTIA[N_INPUTS] = PULLEY_INERTIAS;
static const double SHARES[2] = DRUM_SHARES; /* of a load that the drive moves against, and of one that moves it */
static const double CABLES[N_CABLES][3] = CABLE_ELEMENTS; /* input, stiffness, limit */

static void reset(Drive *d) {
  memset(d, 0, sizeof *d);
  memcpy(d->v, START, sizeof START);
  Element *e = d->element;
  for (int i = 0; i < N_INPUTS; i++, e++) e->arm[i] = 1.0; /* friction of motor, gearhead, input */
  e++->arm[DRUM] = 1.0;                                     /* friction of the drum */
  e->arm[DRUM] = 1.0;                                       /* parts */
  e->arm[PAYLOAD] = -1.0;
  e++->limit = HUGE_VAL;
  for (int k = 0; k < N_CABLES; k++, e++) {
    e->arm[DRUM] = 1.0;
    e->arm[PULLEY((int)CABLES[k][0])] = -1.0;
    e->stiffness = CABLES[k][1];
    e->limit = CABLES[k][2];
  }
  for (int i = 0; i < N_PULLEYS; i++, e++) {
    e->arm[i] = 1.0;
    e->arm[PULLEY(i)] = -1.0;
    e->stiffness = CONTACT * TURN[i] * TURN[i];
    e->limit = HUGE_VAL;
    e->gap = 0.5 * PLAY / TURN[i];
    e->deflection = PRELOAD[i] / e->stiffness + (PRELOAD[i] > 0.0 ? e->gap : PRELOAD[i] < 0.0 ? -e->gap : 0.0);
  }
  for (int i = 0; i < N_INPUTS; i++) {
    d->winding[i] = d->v[AMBIENT];
    d->carried[i] = PRELOAD[i];
  }
}

/* Gauss elimination of a symmetric positive matrix; b becomes the solution. */
static void solve(double A[N][N], double b[N]) {
  for (int i = 0; i < N; i++)
    for (int r = i + 1; r < N; r++) {
      double f = A[r][i] / A[i][i];
      for (int k = i; k < N; k++) A[r][k] -= f * A[i][k];
      b[r] -= f * b[i];
    }
  for (int i = N - 1; i >= 0; i--) {
    for (int k = i + 1; k < N; k++) b[i] -= A[i][k] * b[k];
    b[i] /= A[i][i];
  }
}

/* Torque of each motor at its shaft, within its limits, and the temperature that it leads to. */
static double motor(Drive *d, int i, double h) {
  double shaft = GEAR_RATIO * TURN[i], constant = d->v[TORQUE_CONSTANT];
  double hot = 1.0 + COPPER_PER_K * (d->winding[i] - RATED_AT);
  double resistance = d->v[RESISTANCE] * hot, torque = d->v[MOTOR_TORQUE + i], most = d->v[PEAK_TORQUE];
  double top = most, bottom = -most;
  if (BUS_VOLTAGE > 0.0) {
    double back = constant * d->speed[i] * shaft;
    top = fmax(fmin(most, constant * (BUS_VOLTAGE - back) / resistance), -most);
    bottom = fmin(fmax(-most, constant * (-BUS_VOLTAGE - back) / resistance), most);
  }
  torque = fmin(fmax(torque, bottom), top);
  double current = torque / constant;
  double heat = resistance * current * current - (d->winding[i] - d->v[AMBIENT]) / HEAT_K_W;
  d->winding[i] += h * heat / HEAT_J_K;
  return torque;
}

/* On which side of a band about zero a value lies; 0 within it. */
static int side(double value, double half) { return value > half ? 1 : value < -half ? -1 : 0; }

static void step(Drive *d, double h) {
  double mass[N], torque[N], v[N], limit[N_ELEMENTS];
  int slips[N_ELEMENTS] = {0};
  for (int i = 0; i < N_INPUTS; i++) {
    double shaft = GEAR_RATIO * TURN[i];
    mass[i] = ROTOR_INERTIA * shaft * shaft;
    torque[i] = motor(d, i, h) * shaft;
    Element *e = &d->element[i];
    e->limit = (d->v[INPUT_FRICTION + i] + d->v[GEAR_SHARE] * fabs(d->carried[i]) / TURN[i]) * TURN[i] +
               d->v[MOTOR_FRICTION] * shaft;
    e->stiffness = e->limit / PRESLIDING;
  }
  mass[DRUM] = DRUM_INERTIA;
  mass[PAYLOAD] = d->v[PAYLOAD_INERTIA];
  torque[DRUM] = 0.0;
  for (int i = 0; i < N_PULLEYS; i++) mass[PULLEY(i)] = PULLEY_INERTIA[i], torque[PULLEY(i)] = 0.0;
  for (int i = 0; i < N_INPUTS; i++) torque[DRUM] += PRELOAD[i], torque[PULLEY(i)] -= PRELOAD[i];
  torque[PAYLOAD] = -d->v[LOAD_TORQUE];
  double turning = d->speed[DRUM], load = d->element[N_INPUTS + 1].stiffness * d->element[N_INPUTS + 1].deflection;
  double crawl = turning / DRUM_FADES, rubs = d->v[DRUM_FRICTION] + DRUM_STRIBECK * exp(-crawl * crawl);
  rubs = fmax(rubs + SHARES[turning * load < 0.0] * fabs(load), 0.0);
  d->element[N_INPUTS].limit = rubs;
  d->element[N_INPUTS].stiffness = rubs / PRESLIDING;
  d->element[N_INPUTS + 1].stiffness = 1.0 / d->v[COMPLIANCE];
  for (int e = 0; e < N_ELEMENTS; e++) {
    limit[e] = d->element[e].limit;
    if (d->element[e].gap > 0.0) slips[e] = side(d->element[e].deflection, d->element[e].gap);
  }
  for (int trial = 0; trial < CORRECTIONS; trial++) {
    double A[N][N] = {{0.0}};
    int changed = 0;
    for (int i = 0; i < N; i++) {
      A[i][i] = mass[i];
      v[i] = mass[i] * d->speed[i] + h * torque[i];
    }
    A[DRUM][DRUM] += h * DRUM_VISCOUS;
    for (int e = 0; e < N_ELEMENTS; e++) {
      const Element *el = &d->element[e];
      /* One with play is a spring beyond its gap; the others are springs until they slip. */
      int springs = el->gap > 0.0 ? slips[e] != 0 : !slips[e];
      double held = springs ? el->stiffness * (el->deflection - slips[e] * el->gap) : el->gap > 0.0 ? 0.0 : slips[e] * limit[e];
      for (int i = 0; i < N; i++) {
        v[i] -= h * el->arm[i] * held;
        if (springs)
          for (int k = 0; k < N; k++) A[i][k] += h * h * el->stiffness * el->arm[i] * el->arm[k];
      }
    }
    solve(A, v);
    for (int e = 0; e < N_ELEMENTS; e++) {
      const Element *el = &d->element[e];
      double moved = el->deflection;
      for (int i = 0; i < N; i++) moved += h * el->arm[i] * v[i];
      int now = el->gap > 0.0 ? side(moved, el->gap) : side(el->stiffness * moved, limit[e]);
      if (now != slips[e]) changed = 1;
      slips[e] = now;
    }
    if (!changed) break;
  }
  for (int i = 0; i < N_INPUTS; i++) d->carried[i] = PRELOAD[i];
  for (int e = 0; e < N_ELEMENTS; e++) {
    Element *el = &d->element[e];
    double moved = el->deflection;
    for (int i = 0; i < N; i++) moved += h * el->arm[i] * v[i];
    if (el->stiffness > 0.0)
      el->deflection = fmin(fmax(moved, -limit[e] / el->stiffness), limit[e] / el->stiffness);
    if (e >= N_INPUTS + 2 && e < N_INPUTS + 2 + N_CABLES) d->carried[(int)CABLES[e - N_INPUTS - 2][0]] -= el->stiffness * el->deflection;
  }
  for (int i = 0; i < N; i++) {
    d->speed[i] = v[i];
    d->angle[i] += h * v[i];
  }
}

static void outputs(Drive *d) {
  double twist = d->angle[DRUM] - d->angle[PAYLOAD];
  d->v[DRUM_ENCODER] = d->angle[DRUM] - ENCODER_SHARE * twist;
  d->v[PAYLOAD_ANGLE] = d->angle[PAYLOAD];
  d->v[PAYLOAD_SPEED] = d->speed[PAYLOAD];
  for (int i = 0; i < N_INPUTS; i++) {
    d->v[INPUT_ENCODER + i] = N_PULLEYS ? d->angle[PULLEY(i)] * TURN[i]
                                        : d->angle[i] * TURN[i] - INPUT_GIVE * (d->carried[i] - PRELOAD[i]) / TURN[i];
    d->v[MOTOR_ANGLE + i] = d->angle[i] * TURN[i] * GEAR_RATIO;
    d->v[WINDING_TEMPERATURE + i] = d->winding[i];
  }
}

EXPORT const char *fmi2GetTypesPlatform(void) { return "default"; }
EXPORT const char *fmi2GetVersion(void) { return "2.0"; }

EXPORT Component fmi2Instantiate(const char *name, int type, const char *guid, const char *resources, const void *callbacks,
                                 int visible, int logging) {
  (void)name, (void)resources, (void)callbacks, (void)visible, (void)logging;
  if (type != 1 || guid == NULL || strcmp(guid, GUID) != 0) return NULL;
  Drive *d = malloc(sizeof *d);
  if (d != NULL) reset(d), outputs(d);
  return d;
}

EXPORT void fmi2FreeInstance(Component c) { free(c); }
EXPORT Status fmi2Reset(Component c) { return reset(c), outputs(c), OK; }
EXPORT Status fmi2Terminate(Component c) { return (void)c, OK; }
EXPORT Status fmi2EnterInitializationMode(Component c) { return (void)c, OK; }
EXPORT Status fmi2ExitInitializationMode(Component c) {
  Drive *d = c;
  for (int i = 0; i < N_INPUTS; i++) d->winding[i] = d->v[AMBIENT];
  return outputs(d), OK;
}
EXPORT Status fmi2SetupExperiment(Component c, int given, double tolerance, double start, int ends, double stop) {
  return (void)c, (void)given, (void)tolerance, (void)start, (void)ends, (void)stop, OK;
}
EXPORT Status fmi2SetDebugLogging(Component c, int on, size_t n, const char *const names[]) {
  return (void)c, (void)on, (void)n, (void)names, OK;
}

EXPORT Status fmi2DoStep(Component c, double now, double size, int keep) {
  (void)now, (void)keep;
  Drive *d = c;
  int count = (int)ceil(size / STEP - 1e-9);
  for (int k = 0; k < count; k++) step(d, size / count);
  outputs(d);
  return isfinite(d->angle[DRUM]) ? OK : ERROR;
}
EXPORT Status fmi2CancelStep(Component c) { return (void)c, ERROR; }

EXPORT Status fmi2GetReal(Component c, const Reference at[], size_t n, double value[]) {
  for (size_t k = 0; k < n; k++) {
    if (at[k] >= N_VALUES) return ERROR;
    value[k] = ((Drive *)c)->v[at[k]];
  }
  return OK;
}
EXPORT Status fmi2SetReal(Component c, const Reference at[], size_t n, const double value[]) {
  for (size_t k = 0; k < n; k++) {
    if (at[k] >= N_VALUES) return ERROR;
    ((Drive *)c)->v[at[k]] = value[k];
  }
  return OK;
}

EXPORT Status fmi2GetFMUstate(Component c, void **state) {
  if (*state == NULL) *state = malloc(sizeof(Drive));
  if (*state == NULL) return ERROR;
  memcpy(*state, c, sizeof(Drive));
  return OK;
}
EXPORT Status fmi2SetFMUstate(Component c, void *state) { return memcpy(c, state, sizeof(Drive)), OK; }
EXPORT Status fmi2FreeFMUstate(Component c, void **state) {
  (void)c;
  free(*state);
  *state = NULL;
  return OK;
}

/* What a drive without integers, strings, derivatives has not: no variable of these kinds is declared. */
#define NONE(name) EXPORT Status name(Component c, const Reference at[], size_t n, void *value) { return (void)c, (void)at, (void)value, n ? ERROR : OK; }
NONE(fmi2GetInteger)
NONE(fmi2SetInteger)
NONE(fmi2GetBoolean)
NONE(fmi2SetBoolean)
NONE(fmi2GetString)
NONE(fmi2SetString)
#define NEVER(name) EXPORT Status name(Component c) { return (void)c, ERROR; }
NEVER(fmi2SerializedFMUstateSize)
NEVER(fmi2SerializeFMUstate)
NEVER(fmi2DeSerializeFMUstate)
NEVER(fmi2GetDirectionalDerivative)
NEVER(fmi2SetRealInputDerivatives)
NEVER(fmi2GetRealOutputDerivatives)
NEVER(fmi2GetStatus)
NEVER(fmi2GetRealStatus)
NEVER(fmi2GetIntegerStatus)
NEVER(fmi2GetBooleanStatus)
NEVER(fmi2GetStringStatus)
