"""The page that lists every check of some layouts, written from their families: docs/checks.md.

The command takes a design file of each layout, whose figures the page states.
"""

from collections.abc import Iterator, Sequence
from functools import partial

from mbcdm_cad.checks.comparison import Check, figures
from mbcdm_cad.checks.run import run_check
from mbcdm_cad.checks.size import BUILD_IDS
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.registry import layout_of

_HEAD = """\
# The checks

`mbcdm check DESIGN` runs them in the order of its layout; `mbcdm build` runs them before it draws anything and refuses
a design that fails one, unless `--force` is given. Behind each check stand the figures of the reference designs of the
layouts that have it; *asked* marks checks that only run where a design file asks for what they compare, such as idlers
or a continuous torque. A check that stands on two lines compares something else in the second layout.

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


# What a row says besides its figures: mark and id, what the check compares, source.
_Said = tuple[str, str, str]
# The figure of each layout for what is said of a check, by its id.
_Rows = dict[str, dict[_Said, dict[str, str]]]


def checks_page(drives: Sequence[Drive]) -> str:
    """Markdown: id, description, source, and the figure and limit of each drive; one table for each family.

    A check stands once, in the first family that has it; where another drive's layout says something else of it, in a
    line of its own behind that.
    """
    columns = [layout_of(drive).name for drive in drives]
    families, section = dict[str, _Rows](), dict[str, _Rows]()
    for drive in drives:
        for family in layout_of(drive).check_families():
            rows = families.setdefault(_first_line(family.text), {})
            for check in family.checks:
                variants = section.setdefault(check.id, rows).setdefault(check.id, {})
                variants.setdefault(_said(check), {})[layout_of(drive).name] = _figure(check, drive)
    lines = list[str]()
    for text, rows in families.items():
        if rows:
            heads = ["id", "what", "source", *(f"`{name}`" for name in columns)]
            lines += ["", f"## {text}", "", _line(heads), _line(["---"] * len(heads))]
            lines += _rows(rows, columns)
    lines += ["", "## Checks of the build", "", "| id | what |", "| --- | --- |"]
    lines += [f"| `{name}` | {_BUILD[name]} |" for name in BUILD_IDS]
    return _HEAD + "\n".join(lines).lstrip("\n") + "\n"


def _rows(rows: _Rows, columns: Sequence[str]) -> Iterator[str]:
    for variants in rows.values():
        for said, found in variants.items():
            yield _line([*said, *(found.get(name, "") for name in columns)])


def _line(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _first_line(text: str | None) -> str:
    return (text or "").strip().split("\n")[0].rstrip(".")


def _said(check: Check) -> _Said:
    measure = check.measure.func if isinstance(check.measure, partial) else check.measure
    mark = " *(warn)*" if check.severity == "warn" else ""
    return f"`{check.id}`{mark}", f"{check.title}. {_first_line(measure.__doc__)}.", check.source


def _figure(check: Check, drive: Drive) -> str:
    return figures(run_check(check, layout_of(drive))) if check.asked_of(drive) else "*asked*"


if __name__ == "__main__":
    import sys

    from mbcdm_cad.layouts.loader import load_design

    print(checks_page([load_design(path).drive for path in sys.argv[1:]]), end="")
