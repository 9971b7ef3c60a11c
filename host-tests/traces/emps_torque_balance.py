#!/usr/bin/env python3
"""Least squares on the torque balance of EMPS, by SciPy: the anchors of `tests/emps.rs`.

    python3 emps_torque_balance.py [DIRECTORY]

DIRECTORY holds `train.csv` and `validate.csv`, `../../../shared/data/emps` from here unless told
otherwise. Three forms of friction are fitted to the training log:

    symmetric            F = M a + Fv v + Fc sgn v
    with an offset       F = M a + Fv v + Fc sgn v + F0
    direction-dependent  F = M a + Fv± v + Fc± sgn v, one pair of coefficients each way

For each form: its parameters, and the norm of the force residual over the norm of the force on the
training and on the validation log. The position is filtered (Butterworth, 4th order, a tenth of
the sampling rate, forward and backward) and differentiated centrally; force and regressors are
decimated by 10 (Chebyshev I, 8th order, forward and backward) and lose 5 samples at either end.

The input is held from its row to the next, so the force *at* a row is the mean of the two held
around it ("aligned"). Taken as the row's own ("not aligned"), it comes half a sample early.
"""

import pathlib
import sys

import numpy as np
from scipy import signal

GAIN = 35.15065188  # N/V
DECIMATE = 10
EDGE = 5
DATA = pathlib.Path(__file__).parent / "../../../shared/data/emps"

BUTTERWORTH = signal.butter(4, 0.2, output="sos")
DECIMATION = signal.cheby1(8, 0.05, 0.8 / DECIMATE, output="sos")


def decimated(series):
    """Low-passed, every tenth sample, without the ends."""
    return signal.sosfiltfilt(DECIMATION, series)[::DECIMATE][EDGE:-EDGE]


def load(path, aligned):
    """Force, acceleration and velocity at every row of a log."""
    time, _, volt, position = np.loadtxt(path, delimiter=",", skiprows=1, unpack=True)
    period = (time[-1] - time[0]) / (len(time) - 1)
    position = signal.sosfiltfilt(BUTTERWORTH, position)
    velocity = np.gradient(position, period)
    acceleration = np.gradient(velocity, period)
    force = GAIN * volt
    if aligned:
        force = 0.5 * (force + np.concatenate((force[:1], force[:-1])))
    return force, acceleration, velocity


def symmetric(acceleration, velocity):
    return [acceleration, velocity, np.sign(velocity)]


def with_offset(acceleration, velocity):
    return symmetric(acceleration, velocity) + [np.ones_like(velocity)]


def direction_dependent(acceleration, velocity):
    ahead, back = velocity > 0.0, velocity < 0.0
    return [acceleration, velocity * ahead, velocity * back, 1.0 * ahead, -1.0 * back]


FORMS = [
    ("symmetric", symmetric, ["M", "Fv", "Fc"]),
    ("with an offset", with_offset, ["M", "Fv", "Fc", "F0"]),
    ("direction-dependent", direction_dependent, ["M", "Fv+", "Fv-", "Fc+", "Fc-"]),
]


def main():
    directory = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else DATA
    for aligned in (False, True):
        print("aligned" if aligned else "not aligned")
        logs = [load(directory / name, aligned) for name in ("train.csv", "validate.csv")]
        for name, form, names in FORMS:
            balance = [
                (decimated(force), np.column_stack([decimated(c) for c in form(*motion)]))
                for force, *motion in logs
            ]
            force, regressors = balance[0]
            fitted = np.linalg.lstsq(regressors, force, rcond=None)[0]
            errors = [
                np.linalg.norm(force - regressors @ fitted) / np.linalg.norm(force)
                for force, regressors in balance
            ]
            values = ", ".join(f"{n} {v:.3f}" for n, v in zip(names, fitted))
            print(f"  {name}: {values}; {100 * errors[0]:.3f} / {100 * errors[1]:.3f} %")


if __name__ == "__main__":
    main()
