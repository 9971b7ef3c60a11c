#!/usr/bin/env python3
"""Reference traces of a brushed DC actuator from SciPy's integrators.

    python3 generate.py            write every CSV beside this file
    python3 generate.py --check    write nothing; integrate again by another formula, a hundred
                                   times tighter and in steps half as long, and print by how much
                                   position, velocity and current change

Within a stretch of sliding one way the actuator obeys

    L di/dt = u - R i - k w
    J dw/dt = k i - b w - s Fc - c (x - x0) - p sgn(x - x0)          s = sign of w
      dx/dt = w

A stretch ends where w reaches zero, where x passes the spring's rest x0, or where x reaches a
stop (inelastic). At w = 0 the load T = k i - c (x - x0) - p sgn(x - x0) decides: the actuator
sticks while |T| <= Fs (at x0 itself while |k i| <= Fs + p; on a stop also while T points into
it), else it slides the way T points. While it sticks, i follows its exponential exactly and the
instant of breakaway is known in closed form. The input u is constant over each hold.
"""

import argparse
import math
import pathlib
from dataclasses import dataclass

import numpy as np
from scipy.integrate import DOP853, RK45, solve_ivp

HERE = pathlib.Path(__file__).parent


@dataclass(frozen=True)
class Integrator:
    """How a smooth stretch is integrated."""

    method: type
    rtol: float
    # Longest step as a share of the stretch.
    share: float


# Over holds this short the reference's tolerance is met by far in one step, so tightening it
# alone would change nothing: the check takes another formula and shorter steps as well.
REFERENCE = Integrator(DOP853, 1e-10, 1.0)
CHECK = Integrator(RK45, 1e-12, 0.5)


@dataclass(frozen=True)
class Actuator:
    """SI; all motor values referred to the coordinate x in rad."""

    resistance: float
    inductance: float
    torque_constant: float
    inertia: float
    viscous: float
    coulomb: float
    static: float
    spring: float = 0.0
    rest: float = 0.0
    preload: float = 0.0
    lower: float = -math.inf
    upper: float = math.inf


EMA = Actuator(1.0, 1.0e-3, 0.06, 1.2e-4, 2.0e-4, 0.12, 0.12)
EMA_STATIC = Actuator(1.0, 1.0e-3, 0.06, 1.2e-4, 2.0e-4, 0.12, 0.15)
THROTTLE = Actuator(
    2.0, 1.2e-3, 0.38, 1.6e-3, 8.0e-3, 0.24, 0.28, 0.25, 0.2, 0.3, 0.02, 1.57
)


class Simulation:
    """State (i, w, x) of one actuator and the mode it is in."""

    # Absolute tolerances of i, w and x, as multiples of the relative one.
    SCALE = np.array([1e-2, 1e-1, 1e-3])
    # Closer to the spring's rest than this at w = 0, the actuator is on it: between preload and
    # friction it would bounce about the rest infinitely often in finite time.
    CAPTURE = 1e-10

    def __init__(self, actuator, position, integrator):
        self.actuator = actuator
        self.integrator = integrator
        self.tolerances = {
            "rtol": integrator.rtol,
            "atol": integrator.rtol * self.SCALE,
        }
        self.state = np.array([0.0, 0.0, position])
        self.direction = 0  # 0: sticking
        self.side = int(np.sign(position - actuator.rest)) if actuator.preload else 0
        self.events = {"halt": 0, "breakaway": 0, "rest": 0, "stop": 0}

    def load(self, current, position):
        a = self.actuator
        return (
            a.torque_constant * current
            - a.spring * (position - a.rest)
            - a.preload * self.side
        )

    def rates(self, input_, direction, side):
        a = self.actuator
        constant = a.spring * a.rest - a.preload * side - a.coulomb * direction

        def f(_, y):
            i, w, x = y
            return np.array(
                (
                    (input_ - a.resistance * i - a.torque_constant * w) / a.inductance,
                    (a.torque_constant * i - a.viscous * w - a.spring * x + constant)
                    / a.inertia,
                    w,
                )
            )

        return f

    def advance(self, input_, seconds):
        left = seconds
        while left > 1e-16:
            left -= (self.slide if self.direction else self.stick)(input_, left)

    def stick(self, input_, seconds):
        """Advances at standstill to the breakaway or the end; returns the time taken."""
        a = self.actuator
        i0, _, x = self.state
        final = input_ / a.resistance
        tau = a.inductance / a.resistance
        hold = a.static + (a.preload if self.side == 0 else 0.0)
        rest_load = self.load(0.0, x)
        # Currents at which the load exceeds what holds; none towards a stop.
        up = math.inf if x >= a.upper else (hold - rest_load) / a.torque_constant
        down = -math.inf if x <= a.lower else (-hold - rest_load) / a.torque_constant
        threshold = up if final > i0 else down
        direction = 1 if final > i0 else -1
        if i0 > up or i0 < down:
            # The load exceeds friction already: friction fell from moving to standstill, or the
            # actuator has just turned round.
            taken, direction = 0.0, (1 if i0 > up else -1)
        elif (final - threshold) * direction > 0:
            taken = tau * math.log((final - i0) / (final - threshold))
        else:
            taken = math.inf
        if taken >= seconds:
            self.state[0] = final + (i0 - final) * math.exp(-seconds / tau)
            return seconds
        self.state[0] = final + (i0 - final) * math.exp(-taken / tau)
        self.direction = direction
        self.events["breakaway"] += 1
        if a.preload and self.side == 0:
            self.side = direction
        return taken

    def slide(self, input_, seconds):
        """Advances in motion to the next event or the end; returns the time taken."""
        f = self.rates(input_, self.direction, self.side)
        longest = seconds * self.integrator.share
        solver = self.integrator.method(
            f,
            0.0,
            self.state,
            seconds,
            first_step=longest,
            max_step=longest,
            **self.tolerances,
        )
        while solver.status == "running":
            solver.step()
        assert solver.status == "finished", solver.status
        if not self.suspicious(f, solver.y):
            self.state = solver.y
            return seconds
        return self.slide_to_event(f, seconds)

    def suspicious(self, f, end):
        """Whether an event may lie between self.state and `end`."""
        a, s = self.actuator, self.direction
        if self.state[1] == 0.0 or end[1] * s <= 0.0:
            return True
        # A dip of the speed between two positive ends.
        before, after = f(0.0, self.state)[1] * s, f(0.0, end)[1] * s
        if before < 0.0 < after:
            return True
        if self.side and (end[2] - a.rest) * self.side <= 0.0:
            return True
        return not a.lower < end[2] < a.upper

    def slide_to_event(self, f, seconds):
        a, s = self.actuator, self.direction

        def halt(_, y):
            return y[1]

        def rest(_, y):
            return y[2] - a.rest

        def upper(_, y):
            return y[2] - a.upper

        def lower(_, y):
            return y[2] - a.lower

        halt.direction, rest.direction = -s, s
        wanted = {"halt": halt}
        if self.side and self.side != s:
            wanted["rest"] = rest
        if s > 0 and math.isfinite(a.upper):
            wanted["stop"] = upper
        if s < 0 and math.isfinite(a.lower):
            wanted["stop"] = lower
        for event in wanted.values():
            event.terminal = True
        solution = solve_ivp(
            f,
            (0.0, seconds),
            self.state,
            method=self.integrator.method,
            max_step=min(seconds, 2e-5) * self.integrator.share,
            events=list(wanted.values()),
            **self.tolerances,
        )
        assert solution.success, solution.message
        self.state = solution.y[:, -1].copy()
        hit = next((n for n, t in zip(wanted, solution.t_events) if len(t)), None)
        if hit is None:
            return seconds
        self.events[hit] += 1
        if hit == "rest":
            self.side = s
            self.state[2] = a.rest
            return solution.t[-1]
        if hit == "stop":
            self.state[2] = a.upper if s > 0 else a.lower
        self.state[1] = 0.0
        self.direction = 0
        if a.preload and abs(self.state[2] - a.rest) < self.CAPTURE:
            self.state[2] = a.rest
            self.side = 0
        return solution.t[-1]


def sweep(time):
    """0.2 to 5 Hz in 10 s, linear in frequency, 12 V."""
    return 12.0 * math.sin(2.0 * math.pi * (0.2 * time + 0.5 * 0.48 * time * time))


def open_loop(actuator, input_of, hold, seconds, every, position=0.0):
    """A trace with a row each `every` holds. The input of a hold is its value at the start."""

    def run(integrator):
        simulation = Simulation(actuator, position, integrator)
        rows = []
        for k in range(round(seconds / hold) + 1):
            time = k * hold
            input_ = input_of(time)
            if k % every == 0:
                i, w, x = simulation.state
                rows.append((time, input_, x, w, i))
            simulation.advance(input_, hold)
        return rows, simulation.events

    return run


HEADER = "time_s,input,position,velocity,current_a"
FORMAT = "{:.3f},{:.6f},{:.9f},{:.6f},{:.6f}"


def throttle_voltage(time):
    """3 s of a triangle of 6 V, then 3 s of steps; in whole microvolts, as the file holds it."""
    if time < 3.0:
        phase = (time / 3.0 + 0.25) % 1.0
        return round(6.0 * (1.0 - 4.0 * abs(phase - 0.5)), 6)
    steps = [8.0, 0.0, -6.0, 0.0, 3.5, -2.0, 5.0, 0.0]
    return steps[min(int((time - 3.0) / 0.375), len(steps) - 1)]


def command(time):
    """A step, a ramp and a sine, rad; in whole nanoradians, as the file holds it."""
    if time < 0.1:
        value = 0.0
    elif time < 1.5:
        value = 2.0
    elif time < 3.5:
        value = 2.0 - 2.0 * (time - 1.5)
    else:
        value = -2.0 + 1.5 * math.sin(2.0 * math.pi * (time - 3.5))
    return round(value, 9)


def closed_loop(integrator):
    """The PID of the README on the exact position; its output in whole microvolts."""
    kp, ki, kd, tau, limit, period = 17.0, 60.0, 0.25, 3.0e-3, 24.0, 1.0e-3
    simulation = Simulation(EMA_STATIC, 0.0, integrator)
    integral, rate, last = 0.0, 0.0, 0.0
    rows = []
    for k in range(6001):
        time = k * period
        i, w, x = simulation.state
        error = command(time) - x
        rate = (tau * rate + (x - last)) / (tau + period)
        last = x
        wanted = kp * error + integral - kd * rate
        output = min(max(wanted, -limit), limit)
        if output == wanted or error * wanted < 0.0:
            integral += ki * period * error
        output = round(output, 6)
        rows.append((time, output, x, w, i, command(time)))
        simulation.advance(output, period)
    return rows, simulation.events


TRACES = {
    f"sweep-{name}-{label}.csv": (
        open_loop(actuator, sweep, hold, 10.0, round(5e-3 / hold)),
        HEADER,
        FORMAT,
    )
    for name, actuator in (("coulomb", EMA), ("static", EMA_STATIC))
    for label, hold in (("50us", 5e-5), ("100us", 1e-4), ("1ms", 1e-3))
}
TRACES["throttle.csv"] = (
    open_loop(THROTTLE, throttle_voltage, 1e-3, 6.0, 1, THROTTLE.rest),
    HEADER,
    FORMAT,
)
TRACES["pid.csv"] = (closed_loop, HEADER + ",command", FORMAT + ",{:.9f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="compare integrators")
    parser.add_argument("names", nargs="*", help="only these files")
    arguments = parser.parse_args()
    for name, (run, header, form) in TRACES.items():
        if arguments.names and name not in arguments.names:
            continue
        rows, events = run(REFERENCE)
        if not arguments.check:
            text = "\n".join([header] + [form.format(*row) for row in rows]) + "\n"
            (HERE / name).write_text(text)
            print(f"{name}: {len(rows)} rows, {len(text) // 1000} kB, {events}", flush=True)
            continue
        again, _ = run(CHECK)
        change = np.abs(np.array(rows) - np.array(again)).max(axis=0)
        print(
            f"{name}: {change[2]:.1e} rad, {change[3]:.1e} rad/s, {change[4]:.1e} A",
            flush=True,
        )


if __name__ == "__main__":
    main()
