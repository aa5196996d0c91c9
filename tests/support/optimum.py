"""A front of three designs beside one, with figures and checks made up, for what shows it."""

from pathlib import Path

from mbcdm_cad.checks.comparison import CheckResult, Status
from mbcdm_cad.optimising.evaluate import Evaluated
from mbcdm_cad.optimising.result import BesideDesign, FrontPoint, Optimum
from mbcdm_cad.optimising.search import Searched, TriedPoint
from mbcdm_cad.optimising.wishes import wishes_of

FIGURES = [
    {
        "mass_g": 300.0 + 20.0 * k,
        "swing_mrad": 0.9 - 0.1 * k,
        "torque_Nm": 3.0,
        "box_x_mm": 120.0 + k,
        "efficiency": 0.5,
    }
    for k in range(3)
]


def check(name: str, status: Status, margin: float) -> CheckResult:
    return CheckResult(name, name.replace("_", " "), status, 10.0 + margin, 10.0, "mm", margin, "", "", "made up")


def optimum() -> Optimum:
    """Ten points tried, of which three are on the front; ``a_gap`` binds everywhere, ``b_gap`` at the first alone."""
    points = tuple(
        FrontPoint(
            f"made-{k + 1:02d}",
            "siso_spur",
            f"name: made-{k + 1:02d}\n",
            f"-name: made\n+name: made-{k + 1:02d} <b>&",
            figures,
            (
                check("a_gap", "pass", 0.0),
                check("b_gap", "pass", 0.1 + 0.2 * k),
                check("c_gap", "pass", 5.0),
                check("a_warning", "warn", -1.0),
            ),
            {"cables": [[[0.0, 0.0, 10.0], [5.0, 5.0, 0.0]]], "bodies": [[[10.0, 0.0, 0.0], [0.0, 0.0, 9.0 + k]]]},
        )
        for k, figures in enumerate(FIGURES)
    )
    start = TriedPoint(0, {}, Evaluated((), "", {**FIGURES[0], "mass_g": 350.0}))
    failed = TriedPoint(0, {}, Evaluated((("b_gap", 1.2),)))
    curve = ((4, 0.2), (8, 0.6), (10, 0.7))
    searched = Searched(
        wishes_of(["mass_g:min", "swing_mrad:min"]), (start, *[failed] * 9), (), curve, "made up", True, {"b_gap": 9}
    )
    published = BesideDesign("published", {**FIGURES[1], "mass_g": 380.0}, ("a_gap",))
    return Optimum(searched.wishes, Path("out/made-optimum"), points, (start,), searched, (published,))
