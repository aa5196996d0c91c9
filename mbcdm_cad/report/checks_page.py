"""The page that lists every check of a configuration, written from its families: docs/checks.md."""

from __future__ import annotations

from functools import partial

from mbcdm_cad.checks.built import BUILD_IDS
from mbcdm_cad.checks.comparison import Check
from mbcdm_cad.checks.result import figures
from mbcdm_cad.checks.run import run_check
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.base import Layout

_HEAD = """\
# The checks

`mbcdm check DESIGN` runs them in this order; `mbcdm build` runs them before it draws anything and refuses a design that
fails one, unless `--force` is given. This page lists the checks of `miso_bevel` with the
figures of the reference design. The other configurations have most of these checks and some of their own.

- A check reports the worst case that it finds: `actual`, `limit` and `margin` in one unit; the margin is positive
  inside the limit.
- Status: `pass`, `warn` (does not stop a build) or `fail`. Checks marked *warn* never fail.
- Each remedy was tried on the design: with that one change the check passes. Run the command again to see what the
  change does to the other checks.
- A waiver in the design file (`waivers: [{check: ID, reason: WHY}]`) lets a failing check pass; every output prints the
  reason. A figure that does not exist ("not evaluated because ...") cannot be waived.
- Limits that are not in the design file are named constants beside the check, with their source. "Estimate" means that
  the limit was chosen for this program and has no other source.

"""
_BUILD = {
    "mass": "mass of all items against `targets.mass_g`",
    "envelope": "box of all solids, drum centred, against `targets.envelope_mm`",
    "interference": "no two bodies overlap at nine drum angles over the travel",
    "frame_windup": "the drum's turn from the frame's deflection, against `limits.frame_windup_max_mrad`",
    "printed_walls": "*(warn)* thinnest wall of each printed part, by rays in its mesh, against its material's minimum",
    "overhang": "*(warn)* faces of filament parts that overhang by more than 45 degrees in the position of their 3MF",
}


def checks_page(drive: Drive) -> str:
    """Markdown: id, description, figure of ``drive`` and its limit, source; one table for each family."""
    layout, lines = drive.layout, list[str]()
    for family in layout.check_families():
        lines += [
            "",
            f"## {_first_line(family.text)}",
            "",
            "| id | what | figure | source |",
            "| --- | --- | --- | --- |",
        ]
        lines += [_row(check, layout) for check in family.checks]
    lines += ["", "## Checks of the build", "", "| id | what |", "| --- | --- |"]
    lines += [f"| `{name}` | {_BUILD[name]} |" for name in BUILD_IDS]
    return _HEAD + "\n".join(lines).lstrip("\n") + "\n"


def _first_line(text: str | None) -> str:
    return (text or "").strip().split("\n")[0].rstrip(".")


def _row(check: Check, design: Layout) -> str:
    measure = check.measure.func if isinstance(check.measure, partial) else check.measure
    what = f"{check.title}. {_first_line(measure.__doc__)}."
    mark = " *(warn)*" if check.severity == "warn" else ""
    return f"| `{check.id}`{mark} | {what} | {figures(run_check(check, design))} | {check.source} |"


if __name__ == "__main__":
    from pathlib import Path

    from mbcdm_cad.layouts.loader import load_design

    print(checks_page(load_design(Path("params/mbcdm.yaml")).drive), end="")
