"""docs/optimum.md: the best designs found in the paper's box beside the paper's drive; a leg and a printed capstan.

    mbcdm build params/optimum/NAME.yaml --out BUILDS     (for each design that the page shows as built)
    python -m mbcdm_cad.optimising.paper_page params docs BUILDS

reads the reference design and the designs of ``params/optimum``, checks them, reads the reports of those that are
built, and writes the page.
"""

import json
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.model.equations import DESIGN_TORQUE_TO_WEIGHT_NM_KG, TORQUE_TO_WEIGHT_NM_KG
from mbcdm_cad.optimising.evaluate import Evaluated, evaluate
from mbcdm_cad.report.table import ReportTable
from mbcdm_cad.solving.question import read_question
from mbcdm_cad.storage.folders import write_whole

DESIGNS = (
    "paper-box-01",
    "paper-box-12",
    "paper-box-34",
    "paper-life-light",
    "paper-life-long",
    "paper-stiff-42",
    "paper-rope-01",
)
_ROWS = (
    (
        "torque to weight without losses, N m/kg",
        "torque_to_weight_lossless_Nm_kg",
        f"{DESIGN_TORQUE_TO_WEIGHT_NM_KG} by design, {TORQUE_TO_WEIGHT_NM_KG} measured",
    ),
    ("the same with all losses, N m/kg", "torque_to_weight_with_losses_Nm_kg", ""),
    ("peak torque without losses, N m", "torque_lossless_Nm", "3.9 by design, 3.3 measured"),
    ("peak torque with all losses, N m", "torque_with_losses_Nm", ""),
    ("mass, g", "mass_g", "350 by design, 342 measured"),
    ("swing of the drum by the cables at 0.91 N m, mrad", "cable_swing_mrad", "0.33"),
    ("swing of the payload, structure counted, mrad", "swing_mrad", ""),
    ("least D/d", "bend_ratio", "14.8"),
    ("cycles at which half of the cables that break first have broken", "life_cycles", ""),
    ("box along X, mm", "box_x_mm", "126"),
    ("box along Z, mm", "box_z_mm", "97"),
    ("box along Y, mm", "box_y_mm", "34.8"),
)
# The designs that are drawn with CAD, and beside what each stands; the first of each group is the file as given.
BUILT = ("paper-box-01", "leg-aluminium-01", "capstan-printed-01")
OTHERS = (
    "leg-aluminium",
    "leg-aluminium-01",
    "leg-aluminium-12",
    "capstan-printed",
    *(f"capstan-printed-{k:02d}" for k in (1, 5)),
)
_OTHER_ROWS = (
    ("mass, g", "mass_g"),
    ("swing of the payload, mrad", "swing_mrad"),
    ("peak torque with all losses, N m", "torque_with_losses_Nm"),
    ("over the mass, N m/kg", "torque_to_weight_with_losses_Nm_kg"),
    ("efficiency at the peak torque", "efficiency"),
    ("torque that starts to turn it back, N m", "backdrive_Nm"),
    ("least D/d", "bend_ratio"),
    ("material of the made parts, EUR (estimate)", "material_cost_EUR"),
    ("box along X, mm", "box_x_mm"),
    ("box along Z, mm", "box_z_mm"),
    ("box along Y, mm", "box_y_mm"),
)
_WORDS = """\
By torque to weight the paper's drive can be beaten in its own box: {best:.4g} N m/kg without losses in the
weaker direction, against {own:.4g} of the same model for the paper's own dimensions, and {lossy:.4g} with all
losses. It comes from a larger ratio on thinner ropes; these swing {further:.1f} times as far under the test
torque. For {less:.0f} % less torque to weight `paper-box-12` swings {middle:.1f} times as far. `paper-stiff-42` is
better in both: {both:.4g} N m/kg, and a swing of {both_swing:.3g} mrad for {own_swing:.3g}; its rope is a strand of
1x19, which has more metal, is seldom led over pulleys, and has no figure of life. With the paper's rope and
peak torque (`paper-rope`) the front reaches {stiff:.4g} N m/kg with a swing of {stiff_swing:.3g} mrad.

The peak torque here is that at which a motor, a gearhead or a cable is at its limit or a cable goes slack; the
strength of drum and frame is checked at `loads.peak_torque_Nm` of the file, which in `paper-box-01`, `-12` and `-34` is
more than the paper's 3.9 N m. Life is that of oiled ropes for 0.91 N m over the whole travel, to and
fro, by a generic figure with a factor of 5 to 6 either way: thin ropes under less preload do not live shorter
than the paper's.

Longer life costs swing first: a rope under less preload is worn less and gives more. `paper-life-light` lives
{light[life]:.1f} times as long as `paper-box-01` for {light[less]:.0f} % less torque to weight and
{light[more]:.0f} % more swing, with a preload of {light[preload]:.0f} N for {light[before]:.0f} N. `paper-life-long`
lives {long[life]:.1f} times as long for {long[less]:.0f} % less torque to weight and {long[more]:.0f} % more swing; its
rope is bent less too, and its peak torque is lower. Its {long[cycles]:,.0f} cycles are the most of all that passed.
Both are of the 217 designs of the search of `paper-box` that no other beats in all three figures; life was no aim of
that search, so that one which has it (the third command) may find longer ones. `paper-stiff-42` has no life, so that
such a search leaves it out, and says so.

The search of `paper-box` that found them tried 5,000 designs in 275 s on the clock of two cores; 2,173 passed. Its last
generations still let the front's hypervolume grow by 4 %, so that better ones are likely. The same search by an
engine without a surrogate ended at 16.2 N m/kg with four fifths of the hypervolume, but found `paper-stiff-42`, of
which the other missed the rope. Since then a quarter of a search tries ropes, and other options, that no good design
has: the same 5,000 designs take 454 s of processor time, 1,253 pass, the best has 18.5 N m/kg and the hypervolume is
0.98 of that before (1.05 times after 1,200 designs); the rope of `paper-stiff-42` was tried five times and not kept.
No search of this kind proves that nothing is better. That of `paper-rope` was short and older. All ran before rules
stopped where mass times compliance is least; each design is sized and checked again with the present program.
"""
_OTHER_WORDS = """\
Ratio, rope, motor where none is stated, and all dimensions are free. The first column of each group is the file as its
rules fill it. The searches were short, 8 minutes each; that of the milled leg had two workers and came to 205 designs.

The same leg printed of PA12 (`leg-printed.yaml`): the search found no design that passes. What binds is the joint to
what it stands on: threads cut in PA12 creep, and a printed frame turns further than the rules allow beside a steel
rope. Two words lead to a drive that passes every check, with 9:1 and 1827 g (the milled one weighs {milled_g:.4g} g):

- brass inserts (`printing: {{threads: inserts}}`), on which base and payload lie: M4 in the frame, and with
  `drum: {{output_screws: 8}}` M4 in a hub of 80 mm, where four cut threads need 165 mm;
- `limits: {{frame_windup_max_mrad: 2.5}}`: at the test torque of 9 N m the frame turns the drum so far, and by 8.3 mrad
  at 30 N m. Who cannot take that mills the frame.

The drum's web is full and 27.5 mm thick then. With cut threads the mounting screws alone fail (M6: 1.2 times the peak
torque for 1.5).
"""
_SEARCH = """\
mbcdm optimise params/optimum/{name}.yaml --aim torque_to_weight_lossless_Nm_kg:max --aim cable_swing_mrad:min{aim} \\
  --keep "box_x_mm:<=126" --keep "box_z_mm:<=97" --keep "box_y_mm:<=34.8" \\
  --beside params/mbcdm.yaml {more}"""


def optimum_page(params: Path, builds: Path) -> str:
    """The page. Raises ``MbcdmError`` if a design does not pass, or one of :data:`BUILT` has no report."""
    with threadpool_limits(1):
        reference = _figures(params / "mbcdm.yaml")
        found = {name: _figures(params / "optimum" / f"{name}.yaml") for name in (*DESIGNS, *OTHERS)}
    built = {name: _report(builds / name / "report.json") for name in BUILT}
    lines = [*_page(reference, {name: found[name] for name in DESIGNS}), *_others(found, built)]
    return "\n".join(lines) + "\n"


def _report(path: Path) -> dict[str, Any]:
    try:
        report: dict[str, Any] = json.loads(path.read_text("utf-8"))
    except OSError:
        raise MbcdmError(f"{path}: no such report; run mbcdm build for this design first") from None
    return report


def _others(found: dict[str, Evaluated], built: dict[str, dict[str, Any]]) -> Iterator[str]:
    yield "\n## A leg that holds 30 N m, and the printed capstan with its own motor\n"
    rows = tuple((title, *(_shown(found[name].figures.get(key)) for name in OTHERS)) for title, key in _OTHER_ROWS)
    yield from ReportTable(("", *OTHERS), rows).markdown()
    yield "\n" + _OTHER_WORDS.format(milled_g=found["leg-aluminium-01"].figures["mass_g"]) + "\n```"
    for name in ("leg-aluminium", "leg-printed", "capstan-printed"):
        yield f"mbcdm optimise params/optimum/{name}.yaml --aim mass_g:min --aim swing_mrad:min --time 480s"
    yield "```\n\n## Built with CAD\n"
    yield "From the reports of the builds; a later state of the rules may size a design a little otherwise.\n"
    yield from ReportTable(
        ("design", "mass estimated, g", "mass of the solids, g", "clashes", "checks that fail"),
        tuple(
            (
                name,
                _shown(next(check["actual"] for check in report["checks"] if check["id"] == "mass_estimate")),
                _shown(report["mass"]["mass_g"]),
                len(report["interference"]["clashes"]),
                sum(check["status"] == "fail" for check in report["checks"]),
            )
            for name, report in built.items()
        ),
    ).markdown()


def _figures(path: Path) -> Evaluated:
    result = evaluate(read_question(path), {}, (), ())
    if not result.passes:
        raise MbcdmError(f"{path}: does not pass: {result.refused or ', '.join(name for name, _ in result.failing)}")
    return result


def _page(reference: Evaluated, found: dict[str, Evaluated]) -> Iterator[str]:
    yield "# The best drive in the paper's box\n"
    yield "Written by `python -m mbcdm_cad.optimising.paper_page params docs BUILDS` from the designs of"
    yield "`params/optimum`, which it checks again. The paper's box, motors, gearheads and travel; D/d at least 14.8."
    yield "Torques are those of the weaker direction; the paper's design value is that of its stronger one.\n"
    rows = tuple(
        (title, paper, *(_shown(one.figures.get(name)) for one in (reference, *found.values())))
        for title, name, paper in _ROWS
    )
    yield from (*ReportTable(("", "paper", "its model here (mbcdm.yaml)", *found), rows).markdown(), "")
    name, swing = "torque_to_weight_lossless_Nm_kg", "cable_swing_mrad"
    best = max((one.figures for one in found.values()), key=lambda figures: figures[name])
    both, stiff, own = found[DESIGNS[-2]].figures, found[DESIGNS[-1]].figures, reference.figures
    yield _WORDS.format(
        best=best[name],
        lossy=best["torque_to_weight_with_losses_Nm_kg"],
        own=own[name],
        further=best[swing] / own[swing],
        less=100 * (1 - found[DESIGNS[1]].figures[name] / best[name]),
        middle=found[DESIGNS[1]].figures[swing] / own[swing],
        both=both[name],
        both_swing=both[swing],
        stiff=stiff[name],
        stiff_swing=stiff[swing],
        own_swing=own[swing],
        light=_life(found["paper-life-light"], found[DESIGNS[0]]),
        long=_life(found["paper-life-long"], found[DESIGNS[0]]),
    )
    yield "```"
    box = "--evaluations 5000 --growth 0"
    yield _SEARCH.format(name="paper-box", aim="", more=box)
    yield _SEARCH.format(name="paper-rope", aim="", more="--free rope.preload_N=40..110 --time 330s")
    yield _SEARCH.format(name="paper-box", aim=" --aim life_cycles:max", more=box)
    yield "```"


def _life(one: Evaluated, other: Evaluated) -> dict[str, float]:
    """What the life of one design costs against another."""
    ratio = {name: value / other.figures[name] for name, value in one.figures.items() if name in other.figures}
    return {
        "life": ratio["life_cycles"],
        "less": 100.0 * (1.0 - ratio["torque_to_weight_lossless_Nm_kg"]),
        "more": 100.0 * (ratio["cable_swing_mrad"] - 1.0),
        "cycles": one.figures["life_cycles"],
        "preload": one.fields["rope.preload_N"],
        "before": other.fields["rope.preload_N"],
    }


def _shown(value: float | None) -> str:
    return "" if value is None else f"{value:.4g}" if value < 1e4 else f"{value:.0f}"


def main(arguments: Sequence[str]) -> None:
    """Write ``optimum.md`` into the folder of the docs."""
    params, docs, builds = map(Path, arguments)
    write_whole({docs / "optimum.md": optimum_page(params, builds).encode()})


if __name__ == "__main__":
    main(sys.argv[1:])
