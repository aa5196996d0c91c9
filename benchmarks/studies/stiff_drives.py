"""Mass and compliance of the drives of short files: the table of docs/structure.md, its figures of today written anew.

    python -m benchmarks.studies.stiff_drives params docs/structure.md [NAME ...]

A row has its figures before and today. Those before, when rules ended at strength and place, stay as they are; with
names, only those files are sized anew.
"""

import sys
from pathlib import Path

from mbcdm_cad.checks.size import estimated_mass_g
from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.layouts.structure import structure_of
from mbcdm_cad.storage.folders import write_whole

HEAD = "| file | mass, g | turn of the payload, urad/N m | structure over cables | mass times turn |"


def figures(path: Path) -> tuple[float, float, float]:
    """Mass, g, turn of the payload, urad/N m, and the structure's part of it over that of the cables."""
    layout = layout_of(load_design(path).drive)
    structure = structure_of(layout)
    assert structure is not None
    return estimated_mass_g(layout.bill()), 1e6 / structure.stiffness_Nm_rad, structure.over_cables


def renewed(row: str, path: Path) -> str:
    """A row of the table with the figures of today."""
    name, *pairs = row.removeprefix("| ").removesuffix(" |").split(" | ")[:4]
    before = [pair.split(", ")[0] for pair in pairs]
    mass_g, turn_urad_Nm, share = figures(path)
    now = f"{mass_g:.0f}", f"{turn_urad_Nm:.{int(turn_urad_Nm < 20.0)}f}", f"{share:.2g}"
    shown = [f"{first}, {second}" for first, second in zip(before, now, strict=True)]
    if shown == pairs:
        return row  # the product is that of figures before they were rounded
    product = mass_g * turn_urad_Nm / (float(before[0]) * float(before[1]))
    return " | ".join((f"| {name}", *shown, f"{product:.2f} |"))


def main(params: Path, page: Path, *names: str) -> None:
    """Write the page with the table anew."""
    lines = page.read_text("utf-8").split("\n")
    n = lines.index(HEAD) + 2
    while lines[n].startswith("| "):
        name = lines[n].split(" | ")[0].removeprefix("| ")
        if not names or name in names:
            lines[n] = renewed(lines[n], params / f"{name}.yaml")
            print(lines[n], flush=True)
        n += 1
    write_whole({page: "\n".join(lines).encode()})


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]), *sys.argv[3:])
