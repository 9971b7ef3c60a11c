
#include <math.h>

/* Where the actuator is. Read what you need; let actuator_start and actuator_step write it. */
typedef struct {
    double time;     /* s since the start */
    double position; /* of the drive, @POSITION@ */
    double velocity; /* of the drive, @POSITION@/s */
    double current;  /* of the winding, A; 0 without one */
    double warmth;   /* share by which heat has raised the winding's resistance */
    double reported; /* what the position sensor reports, @POSITION@ */
    double begun;    /* time at which the integration step began */
    double far;      /* far side of the play before the sensor, @POSITION@ */
    int motion;      /* -1 backward, 0 held, 1 forward */
    int side;        /* side of the spring's rest; 0 while its preload holds */
    int flow;        /* sign of the current, 0 while brushes or bridge hold it */
} actuator_state;

@CONSTANTS@
/* Events end a smooth stretch; from then on the next one is at least so long, s. */
static const double LEAST_STEP = 1e-4 * @MOST_STEP@;
/* What bounces about the spring's rest for less than that rests there, s. */
static const double RESTING = 1e-6;
/* What comes to that within less than that is there, s. */
static const double AT_ONCE = 1e-9;

typedef struct {
    double torque;    /* all but friction */
    double coulomb;   /* friction while sliding, but the viscous one */
    double breakaway; /* friction to be overcome from rest */
} actuator_load;

static double within(double value, double low, double high)
{
    return value < low ? low : value > high ? high : value;
}

/* What is left of the torque constant where the motor would have this torque. */
static double left_of(double torque)
{
    return 1.0 / (1.0 + SATURATION * fabs(torque));
}

/* The voltage that brushes and bridge may hold against the current, V. */
static double held_voltage(double voltage)
{
    const double asked = fabs(voltage);
    return BRUSH_DROP + (DEAD_TIME < asked ? DEAD_TIME : asked);
}

/* What drives the current but its resistance and what brushes and bridge hold, V. */
static double driving_voltage(double voltage, double current, double velocity)
{
    const double sag = within(SUPPLY_SAG * voltage * current, -1.0, 1.0);
    const double constant = TORQUE_CONSTANT * left_of(TORQUE_CONSTANT * current);
    return voltage * (1.0 - sag) - constant * velocity;
}

/* The current of a winding without inductance, A: what supply and saturation take depends on it. */
static double steady_current(double voltage, double velocity, double warmth)
{
    const double held = held_voltage(voltage);
    double current = 0.0;
    int round;
    for (round = 0; round < 100; ++round) {
        const double drive = driving_voltage(voltage, current, velocity);
        const double over = drive > held ? drive - held : drive < -held ? drive + held : 0.0;
        const double next = over / (RESISTANCE * (1.0 + warmth));
        const double change = next - current;
        current = next;
        if (fabs(change) <= 1e-13 * (1.0 + fabs(current)))
            break;
    }
    return current;
}

static double current_of(const actuator_state *s, double input)
{
    if (!HAS_WINDING)
        return 0.0;
    if (INDUCTANCE > 0.0)
        return s->current;
    return steady_current(GAIN * input, s->velocity, s->warmth);
}

/* Torque of the motor as the declared torque constant has it. */
static double motor_torque(const actuator_state *s, double input)
{
    return HAS_WINDING ? TORQUE_CONSTANT * current_of(s, input) : GAIN * input;
}

/* All that acts, for a motion in this direction. */
static actuator_load load_of(const actuator_state *s, double input, double load_torque, int direction)
{
    const double x = s->position, v = s->velocity, t = s->time, begun = s->begun + AT_ONCE;
    const double motor = motor_torque(s, input);
    actuator_load load;
    load.torque = OFFSET;
    load.coulomb = direction > 0 ? COULOMB_FORWARD : COULOMB_BACKWARD;
    load.breakaway = direction > 0 ? BREAKAWAY_FORWARD : BREAKAWAY_BACKWARD;
@LAWS@    load.torque += motor * left_of(motor) - load_torque;
    load.torque -= SPRING * (x - SPRING_REST) + SPRING_PRELOAD * s->side;
    if (load.breakaway < load.coulomb)
        load.breakaway = load.coulomb;
    (void)v, (void)t, (void)begun;
    return load;
}

/* How far the torque exceeds what holds the actuator at rest, and which way it points. */
static double excess_of(const actuator_state *s, double input, double load_torque, int *direction)
{
    actuator_load load = load_of(s, input, load_torque, 1);
    double held;
    *direction = load.torque < 0.0 ? -1 : 1;
    if ((*direction > 0 && s->position >= UPPER_STOP) || (*direction < 0 && s->position <= LOWER_STOP))
        return -1.0;
    if (*direction < 0)
        load = load_of(s, input, load_torque, -1);
    held = load.breakaway + (s->side == 0 ? SPRING_PRELOAD : 0.0);
    return fabs(load.torque) - held;
}

/* Rates of position, velocity, current and warmth while the mode lasts. */
static void rates(const actuator_state *s, double input, double load_torque, double rate[4])
{
    const double current = current_of(s, input);
    rate[0] = 0.0;
    rate[1] = 0.0;
    rate[2] = 0.0;
    if (s->motion != 0) {
        const actuator_load load = load_of(s, input, load_torque, s->motion);
        const double viscous = s->motion > 0 ? VISCOUS_FORWARD : VISCOUS_BACKWARD;
        rate[0] = s->velocity;
        rate[1] = (load.torque - s->motion * load.coulomb - viscous * s->velocity) / INERTIA;
    }
    if (HAS_WINDING && INDUCTANCE > 0.0 && (s->flow != 0 || !HOLDS_CURRENT)) {
        const double voltage = GAIN * input;
        const double drop = RESISTANCE * (1.0 + s->warmth) * current;
        const double held = HOLDS_CURRENT ? s->flow * held_voltage(voltage) : 0.0;
        rate[2] = (driving_voltage(voltage, current, s->velocity) - held - drop) / INDUCTANCE;
    }
    rate[3] = HEATING * current * current * (1.0 + s->warmth) - COOLING * s->warmth;
}

/* The state a part of a second on along these rates. */
static actuator_state along(const actuator_state *s, const double rate[4], double seconds)
{
    actuator_state next = *s;
    next.time += seconds;
    next.position += seconds * rate[0];
    next.velocity += seconds * rate[1];
    next.current += seconds * rate[2];
    next.warmth += seconds * rate[3];
    return next;
}

/* The classic method of Runge and Kutta of order 4, in one mode. */
static actuator_state smooth(const actuator_state *s, double input, double load_torque, double seconds)
{
    double a[4], b[4], c[4], d[4], mean[4];
    actuator_state middle;
    int k;
    rates(s, input, load_torque, a);
    middle = along(s, a, 0.5 * seconds);
    rates(&middle, input, load_torque, b);
    middle = along(s, b, 0.5 * seconds);
    rates(&middle, input, load_torque, c);
    middle = along(s, c, seconds);
    rates(&middle, input, load_torque, d);
    for (k = 0; k < 4; ++k)
        mean[k] = (a[k] + 2.0 * b[k] + 2.0 * c[k] + d[k]) / 6.0;
    return along(s, mean, seconds);
}

/* Whether the current would leave zero, and which way. */
static int leaving(const actuator_state *s, double input)
{
    const double voltage = GAIN * input;
    const double drive = driving_voltage(voltage, 0.0, s->velocity);
    const double held = held_voltage(voltage);
    return drive > held ? 1 : drive < -held ? -1 : 0;
}

/* Whether the mode has ended on the way to a state. */
static int ended(const actuator_state *s, double input, double load_torque)
{
    int direction;
    if (s->motion != 0) {
        if (s->motion * s->velocity < 0.0)
            return 1;
        if (s->motion > 0 ? s->position > UPPER_STOP : s->position < LOWER_STOP)
            return 1;
        if (s->side * (s->position - SPRING_REST) < 0.0)
            return 1;
    } else if (excess_of(s, input, load_torque, &direction) > 0.0) {
        return 1;
    }
    if (HOLDS_CURRENT) {
        if (s->flow * s->current < 0.0)
            return 1;
        if (s->flow == 0 && leaving(s, input) != 0)
            return 1;
    }
    return 0;
}

/* Takes the state over into the next mode. */
static void turn(actuator_state *s, double input, double load_torque)
{
    const double torque = fabs(load_of(s, input, load_torque, 1).torque) + SPRING_PRELOAD;
    const double acceleration = torque / INERTIA;
    if (HOLDS_CURRENT && s->flow * s->current < 0.0) {
        s->current = 0.0;
        s->flow = 0;
    }
    if (s->motion == 0)
        return;
    if (s->side * (s->position - SPRING_REST) < 0.0) {
        s->position = SPRING_REST;
        s->side = s->motion;
        if (fabs(s->velocity) <= acceleration * RESTING) {
            s->velocity = 0.0;
            s->motion = 0;
            s->side = 0;
        }
    }
    if (s->motion > 0 ? s->position > UPPER_STOP : s->position < LOWER_STOP) {
        s->position = s->motion > 0 ? UPPER_STOP : LOWER_STOP;
        s->velocity = 0.0;
        s->motion = 0;
    } else if (s->motion * s->velocity < 0.0) {
        s->velocity = 0.0;
        s->motion = 0;
        if (s->side != 0 && fabs(s->position - SPRING_REST) <= acceleration * RESTING * RESTING) {
            s->position = SPRING_REST;
            s->side = 0;
        }
    }
}

/* Lets go what the torque or the voltage overcomes. */
static void release(actuator_state *s, double input, double load_torque)
{
    int direction;
    if (HOLDS_CURRENT && s->flow == 0)
        s->flow = leaving(s, input);
    if (s->motion == 0 && excess_of(s, input, load_torque, &direction) > 0.0) {
        s->motion = direction;
        if (SPRING_PRELOAD > 0.0 && s->side == 0)
            s->side = direction;
    }
}

/* A part of a second that ends where an external load begins or ends, if it would pass that. */
static double up_to_edge(double time, double seconds)
{
    if (time + AT_ONCE < LOAD_BEGIN && time + seconds > LOAD_BEGIN)
        return LOAD_BEGIN - time;
    if (time + AT_ONCE < LOAD_END && time + seconds > LOAD_END)
        return LOAD_END - time;
    return seconds;
}

static void report(actuator_state *s)
{
    s->far = within(s->far, s->position - 0.5 * PLAY, s->position + 0.5 * PLAY);
    s->reported = s->far;
@READING@}

/* At rest at a position, without current, cold. */
void actuator_start(actuator_state *s, double position)
{
    const double distance = position - SPRING_REST;
    s->time = 0.0;
    s->begun = 0.0;
    s->position = within(position, LOWER_STOP, UPPER_STOP);
    s->velocity = 0.0;
    s->current = 0.0;
    s->warmth = 0.0;
    s->far = s->position;
    s->motion = 0;
    s->side = SPRING_PRELOAD > 0.0 ? (distance > 0.0) - (distance < 0.0) : 0;
    s->flow = 0;
    report(s);
}

/* Lets dt seconds pass under an input (@INPUT@) and a load against positive motion (@LOAD@), both held. */
void actuator_step(actuator_state *s, double input, double load_torque, double dt)
{
    double left = dt;
    while (left > 0.0) {
        double taken = left < MOST_STEP ? left : MOST_STEP;
        actuator_state next;
        taken = up_to_edge(s->time, taken);
        s->begun = s->time;
        release(s, input, load_torque);
        next = smooth(s, input, load_torque, taken);
        if (ended(&next, input, load_torque)) {
            double from = 0.0, to = taken;
            int k;
            for (k = 0; k < 50 && to > LEAST_STEP; ++k) {
                const double middle = 0.5 * (from + to);
                next = smooth(s, input, load_torque, middle);
                if (ended(&next, input, load_torque))
                    to = middle;
                else
                    from = middle;
            }
            taken = to;
            next = smooth(s, input, load_torque, taken);
            turn(&next, input, load_torque);
        }
        *s = next;
        left -= taken;
        report(s);
    }
    if (HAS_WINDING && INDUCTANCE == 0.0)
        s->current = steady_current(GAIN * input, s->velocity, s->warmth);
}
