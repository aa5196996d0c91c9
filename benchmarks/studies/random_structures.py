"""The turn of whole drives by the model and with drum, input pulleys and frame as solid elements of their STEP.

    python -m benchmarks.studies.random_structures --rows out/structures.jsonl

Of each layout the first random short file with a metal and the first with a printed frame that pass every check, and
two references. Part by part, with the supports that the model assumes; bearings, gearheads, shafts and axle, whose
figures are estimates or beams, are the model's in both sums. Needs gmsh and scikit-fem
(tests/requirements-solids.lock); half a minute a drive. A sum may differ by 10 %.
"""

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from itertools import count
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks.study import ROOT, Row, Study, parser
from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.layouts.sector import SectorLayout
from mbcdm_cad.layouts.structure import structure_of
from mbcdm_cad.model.stiffness import unit_tensions_N
from tests.support.random_generator import LAYOUTS, Passing, passing

ALLOWED = 0.10
REFERENCES = ("mbcdm", "siso_spur")


@dataclass(frozen=True)
class DriveByBoth:
    """One drive by both routes, urad per N m: its parts, and the sums of all causes besides the cables."""

    name: str
    frame_material: str
    parts: dict[str, tuple[float, float]]
    sums: dict[str, tuple[float, float]]

    def __str__(self) -> str:
        def shown(pairs: dict[str, tuple[float, float]]) -> str:
            return ", ".join(f"{k} {a:.4g}/{b:.4g} {a / b - 1.0:+.1%}" for k, (a, b) in pairs.items())

        return f"{self.name} ({self.frame_material}): {shown(self.parts)}; {shown(self.sums)}"


def by_both(name: str, layout: SectorLayout) -> DriveByBoth:
    """Model and solid elements for one drive."""
    from tests.support.drum_solid import drum_by_solids, pulley_torsion_urad_Nm
    from tests.support.frame_solid import frame_by_solids

    drive, d, structure = layout.drive, layout.loads.si, structure_of(layout)
    cables = [t.cable_name for t in layout.drum.tensioners]
    unit = np.abs(unit_tensions_N(d)) * d.drum_radius_m
    share = {c: float(s) for c, s in zip(d.cable_names, unit, strict=True) if c in cables}
    own = sum(share.values())
    preload = {c.name: c.preload_N for c in drive.cables}
    thread = drive.screw(layout.drum.set_screw).thread_mm
    with TemporaryDirectory() as folder:
        frame, _ = frame_by_solids(layout, Path(folder))
        drum = drum_by_solids(
            layout.drum,
            drive.drum_material,
            thread,
            {c: s / own for c, s in share.items()},
            preload,
            drive.loads.peak_torque_Nm,
            Path(folder),
        )
        twist = pulley_torsion_urad_Nm(layout, Path(folder))
    model = {c.name: c.urad_Nm for c in structure.causes}
    in_drum = [name for name in model if name.startswith("drum: ")]
    # One sector is drawn in solid elements; what hubs in line turn by the others' torque is the model's in both.
    hubs, line = sum(model[k] for k in in_drum if "hub" in k), layout.hubs_in_line
    passed = hubs * (1.0 - own / sum((k / line) ** 2 for k in range(1, line + 1)))
    drum_model, drum_solid = sum(model[k] for k in in_drum), drum.turn_urad_Nm * own + passed
    parts = {
        "frame": (model["frame"], frame),
        "drum": (drum_model, drum_solid),
        "pulleys' torsion": (model["input pulleys, torsion"], twist),
    }
    # Of the drum's figure the hub to the payload is not seen by the drum's encoder; its share is the model's.
    scale = drum_solid / drum_model
    solid = model | {"frame": frame, "input pulleys, torsion": twist} | {k: model[k] * scale for k in in_drum}

    def both(causes: tuple) -> tuple[float, float]:
        return sum(c.urad_Nm for c in causes), sum(solid[c.name] for c in causes)

    sums = {
        "encoder": both(structure.at_encoder),
        "payload": both(structure.at_payload),
        "motors held": both(structure.causes),
    }
    return DriveByBoth(name, layout.frame_material.name, parts, sums)


def drives() -> Iterator[tuple[str, SectorLayout]]:
    """Ten drives: two of each layout, and two references."""
    for name, space in LAYOUTS.items():
        wanted = {False, True}
        for seed in count(1):
            found = passing(seed, space)
            if isinstance(found, Passing):
                layout = layout_of(found.loaded.drive)
                assert isinstance(layout, SectorLayout)
                if layout.printed_frame in wanted:
                    wanted.remove(layout.printed_frame)
                    yield f"{name} random-{seed}", layout
            if not wanted:
                break
    for name in REFERENCES:
        layout = layout_of(load_design(ROOT / "params" / f"{name}.yaml").drive)
        assert isinstance(layout, SectorLayout)
        yield name, layout


def table(rows: list[Row]) -> str:
    """Every drive, and the largest difference of a sum."""
    found = [DriveByBoth(**{key: value for key, value in row.items() if key != "task"}) for row in rows]
    worst = max((a / b - 1.0 for drive in found for a, b in drive.sums.values()), key=abs)
    return "\n".join([*map(str, found), f"largest difference of a sum {worst:+.1%}, allowed {ALLOWED:.0%}"])


def main() -> None:
    """Parse and do."""
    given, designs = parser(__doc__).parse_args(), dict(drives())
    Study(lambda task: asdict(by_both(task[0], designs[task[0]])), table).run([(name,) for name in designs], given)


if __name__ == "__main__":
    main()
