"""Rope that creeps on the bodies it passes: in the declared model the tension passes a guide without slip."""

from dataclasses import replace

from mbcdm_cad.loop.effect import MOST_STRENGTH, Effect, Effects, Parameter
from mbcdm_cad.loop.prepare.setup import DriveSI, Floats, Prepared, Setup, Simulator


def _apply(setup: Setup, values: Floats, simulate: Simulator) -> Setup:
    # The tension profiles of wound-on cable assume no slip on the guide: the change by slip is computed without them.
    bare = replace(setup, winding=0.0, creep=0.0)
    whole = simulate(replace(bare, d=setup.drive.with_passed_slip)) - simulate(bare)
    return setup.with_added(values[0] * whole)


def offer(d: DriveSI | None, p: Prepared) -> Effects:
    """With torque, where the cables pass a body and the design does not count slip there."""
    if d is None or p.load_Nm is None or not d.passed_wrap_rad or d.slips_on_passed:
        return
    yield Effect(
        "passed_slip",
        "rope creeps on the guide",
        "the rope slips on the guide too, from both ends of its wrap; strength 1 is the whole effect",
        "no part of the bench: in the declared model the tension passes the guide without slip",
        "loads of several sizes: slip on the guide ends where it has reached the whole wrap",
        (Parameter("strength", 0.5, 0.0, MOST_STRENGTH),),
        _apply,
        plain="the rope creeps on the guide: {strength} times what its friction and wrap allow",
    )
