"""A reading that walks with the path travelled: a counter that loses counts, a coupling that slips at each stroke."""

from collections.abc import Callable

from mbcdm_cad.loop.effect import Effect, Parameter
from mbcdm_cad.loop.prepare.setup import DriveSI, Floats, Prepared, Setup, Simulator

# Words for the path that counts, and that path from the whole path and the angle, both rad at the drum.
PATHS: tuple[tuple[str, Callable[[Floats, Floats], Floats]], ...] = (
    ("in both directions", lambda path, angle: path),
    ("in the positive direction", lambda path, angle: 0.5 * (path + angle)),
    ("in the negative direction", lambda path, angle: 0.5 * (path - angle)),
)


def offer(d: DriveSI | None, p: Prepared) -> list[Effect]:
    """Always."""

    def form(words: str, counted: Callable[[Floats, Floats], Floats]) -> Effect:
        def apply(setup: Setup, values: Floats, _: Simulator) -> Setup:
            return setup.with_added(values[0] * counted(setup.p.path_rad / setup.ratio, setup.drum_rad))

        return Effect(
            "lost_counts",
            words,
            "the reading walks in proportion to the path travelled and stands while the drive rests: a counter that "
            "loses counts of output or input, or a coupling or friction drive that slips a little at each stroke",
            "counter and cable of both encoders at lower speed, couplings and clamps between the encoders",
            "let the drive rest in mid-run: a walk with the path stands still, a drift in time goes on",
            (Parameter("share", 1e-6, -0.2, 0.2),),
            apply,
            hangs_on="the path travelled",
            plain="the output reading walks by {share} of the path travelled, as where counts are lost",
        )

    return [form(words, counted) for words, counted in PATHS]
