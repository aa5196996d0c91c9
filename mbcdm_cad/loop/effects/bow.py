"""A smooth bow in angle: runout of input and output together, a pulley that is not round, a nonlinear sensor."""

from collections.abc import Callable
from functools import partial

import numpy as np

from mbcdm_cad.loop.effect import Effect, Figure, Parameter
from mbcdm_cad.loop.prepare.setup import DriveSI, Floats, Prepared, Setup, Simulator
from mbcdm_cad.measurement.run import smoothed

# Points at which the height of the bow is evaluated.
POINTS = 201
# Samples over which the error of the output is smoothed: the noise is of each, a bow of many.
WINDOW = 50


def _shapes(angle_rad: Floats, low_rad: float, high_rad: float) -> tuple[Floats, Floats]:
    """A parabola and a cubic without mean and without linear part over the travel, in rad^2 and rad^3."""
    middle, half = 0.5 * (low_rad + high_rad), 0.5 * (high_rad - low_rad)
    x = angle_rad - middle
    return x**2 - half**2 / 3.0, x**3 - 0.6 * half**2 * x


def _bent(angle_of: Callable[[Setup], Floats], setup: Setup, values: Floats, _: Simulator) -> Setup:
    angle = angle_of(setup)
    square, cube = _shapes(angle, float(angle.min()), float(angle.max()))
    return setup.with_added(values[0] * square + values[1] * cube)


def _reached(setup: Setup) -> Floats:
    """The output's angle without the noise of each reading: a curve over that would explain the noise by itself."""
    expected, p = setup.drum_rad, setup.p
    return np.asarray(expected + smoothed(p.output_rad - expected, WINDOW * p.step_s, p.step_s))


# A bow of a tenth of a radian is another curve over the angle that it bends.
FORMS: dict[str, Callable[[Setup], Floats]] = {
    "smooth curve in angle": lambda setup: setup.drum_rad,
    "smooth curve in the output's angle": _reached,
}


def offer(d: DriveSI | None, p: Prepared) -> list[Effect]:
    """Always."""
    half = 0.5 * float(np.ptp(p.output_rad))
    angle = np.linspace(-half, half, POINTS)
    square, cube = _shapes(angle, -half, half)

    def height(values: Floats) -> float:
        return 0.5 * float(np.ptp(values[0] * square + values[1] * cube))

    return [
        Effect(
            "bow",
            form,
            "the error bends over the travel, the same at every pass: no ratio, and no wave of a known shaft",
            "runout of pulleys and encoder discs together, a pulley that is not round, linearity of the output sensor",
            "a longer travel: a wave of the drum comes back after a turn, a bow goes on",
            (Parameter("parabola_rad_rad2", 1e-6 / half**2), Parameter("cubic_rad_rad3", 1e-6 / half**3)),
            partial(_bent, angle_of),
            last=True,
            plain="the output reading bends smoothly over the travel, by {height_rad}",
            figures=(Figure("height_rad", height),),
        )
        for form, angle_of in FORMS.items()
    ]
