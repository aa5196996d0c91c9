"""Messages of a build during the work and for a part that cannot be drawn; messages that must not appear.

Mass properties of a rod from its centre line: against closed forms, and against the kernel's of the drawn cable.

A process that is forked after its parent used the kernel must not wait for threads that do not exist in it.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from math import cos, pi, sin
from pathlib import Path
from types import SimpleNamespace

import cadquery as cq
import numpy as np
import pytest

from mbcdm_cad.cli.group import progress
from mbcdm_cad.design.bought import Material
from mbcdm_cad.errors import GeometryError
from mbcdm_cad.jobs import build as job
from mbcdm_cad.jobs.build import build
from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.parts.bill import CABLE, Item, Placement, Vector
from mbcdm_cad.routes.curves import Arc, Line
from mbcdm_cad.storage.cache import Cache
from mbcdm_cad.workshop import pictures
from mbcdm_cad.workshop.kernel import measure
from mbcdm_cad.workshop.mass import rod_shape
from mbcdm_cad.workshop.meshing import mesh_solid
from mbcdm_cad.workshop.pictures import EXPLODED, exploded, transfer_section

ROOT = Path(__file__).parents[3]
DESIGN = ROOT / "params" / "mbcdm.yaml"

_STEP_WITHOUT_CADQUERY = """
import sys
from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox
from mbcdm_cad.workshop.export.step import part_step
from mbcdm_cad.layouts.loader import load_design
from pathlib import Path
material = load_design(Path(sys.argv[1])).drive.material("steel")
assert len(part_step("box", BRepPrimAPI_MakeBox(1.0, 2.0, 3.0).Shape(), material)) > 1000
assert "cadquery" not in sys.modules, "the test shows nothing: cadquery silences the kernel too"
"""


def test_the_kernel_writes_no_statistics_to_standard_output() -> None:
    code = [sys.executable, "-c", _STEP_WITHOUT_CADQUERY, str(DESIGN)]
    done = subprocess.run(code, cwd=ROOT, env={"PYTHONPATH": str(ROOT)}, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout == "", done.stdout[:300]


def test_a_part_that_cannot_be_drawn_is_put_down_to_the_checks_that_fail(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A forced build names the checks that failed; one that passed them all asks for the design file."""

    def fails(*_: object) -> None:
        raise GeometryError("drum: cannot be drawn with these dimensions")

    monkeypatch.setattr(job, "made_parts", fails)
    with pytest.raises(GeometryError, match=r"^drum: cannot be drawn with these dimensions; .*please report"):
        build(load_design(DESIGN), tmp_path, cache=Cache(None))
    changed = tmp_path / "changed.yaml"
    text = DESIGN.read_text("utf-8")
    assert text.count("  preload_N: 70.0 ") == 1
    changed.write_text(text.replace("  preload_N: 70.0 ", "  preload_N: 700.0 "), "utf-8")
    with pytest.raises(GeometryError, match=r"although checks fail \([a-z_0-9, .]+\): their messages"):
        build(load_design(changed), tmp_path, cache=Cache(None), force=True)


def test_progress_is_one_line_a_stage_where_it_is_piped(capsys: pytest.CaptureFixture[str]) -> None:
    with progress() as note:
        note("frame, drum")
        note("interference at 9 poses")
    said = capsys.readouterr()
    assert said.err == "making frame, drum\nmaking interference at 9 poses\n" and said.out == ""


PARAMS = Path(__file__).parents[3] / "params"


def test_straight_rod_has_the_inertia_of_a_cylinder() -> None:
    length, radius = 40.0, 3.0
    shape = rod_shape([Line((1.0, 2.0, -20.0), (1.0, 2.0, 5.0)), Line((1.0, 2.0, 5.0), (1.0, 2.0, 20.0))], radius)
    volume = pi * radius**2 * length
    assert shape.volume_mm3 == pytest.approx(volume)
    assert shape.area_mm2 == pytest.approx(2 * pi * radius * (length + radius))
    assert shape.centroid_mm == pytest.approx((1.0, 2.0, 0.0))
    across, along = volume * (3 * radius**2 + length**2) / 12, volume * radius**2 / 2
    # The rod is summed as 96 slices, which are points along it.
    assert np.diag(shape.inertia_mm5) == pytest.approx([across, across, along], rel=1e-3)


def test_bent_rod_has_the_volume_and_centroid_of_pappus() -> None:
    ring, radius, half = 20.0, 0.5, 1.2
    arc = Arc((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), ring, -half, half)
    shape = rod_shape([arc], radius)
    assert shape.volume_mm3 == pytest.approx(pi * radius**2 * ring * 2 * half)
    # Exact: (R + r^2/(4 R)) sin(a)/a; the line alone has R sin(a)/a.
    exact = (ring + radius**2 / (4 * ring)) * sin(half) / half
    assert shape.centroid_mm[0] == pytest.approx(exact, abs=radius**2 / (4 * ring) * 1.1 + 1e-3)
    assert shape.low_mm[0] == pytest.approx(ring * cos(half) - radius) and shape.high_mm[2] == pytest.approx(radius)


@pytest.mark.parametrize("design", ["mbcdm", "siso_spur"])
def test_cable_has_the_mass_that_the_kernel_finds(design: str) -> None:
    drive = load_design(PARAMS / f"{design}.yaml").drive
    parts = layout_of(drive).bill().parts
    spec = next(spec for name, spec in parts.items() if name.startswith(CABLE))
    line, solid = rod_shape(spec.part.pieces, spec.part.radius), measure(spec.part.solid())
    assert line.volume_mm3 == pytest.approx(solid.volume_mm3, rel=1e-5)
    assert line.centroid_mm == pytest.approx(solid.centroid_mm, abs=0.01)
    assert np.diag(line.inertia_mm5) == pytest.approx(np.diag(solid.inertia_mm5), rel=0.002)
    ends = drive.cable.diameter_mm / 2 + 0.01
    assert np.all(np.array(line.low_mm) <= np.array(solid.low_mm) + 0.02), "the box holds the cable"
    assert line.low_mm + line.high_mm == pytest.approx(solid.low_mm + solid.high_mm, abs=ends)


SCRIPT = """
from mbcdm_cad.workshop import kernel  # as everything of this room that draws does
from mbcdm_cad.parallel.forks import allow_processes, fork_map
import cadquery as cq

def drawn(size):
    return cq.Solid.makeBox(size, 1, 1).cut(cq.Solid.makeSphere(0.5, cq.Vector(0, 0, 0))).Volume()

allow_processes()
here = [drawn(size) for size in (1.0, 2.0)]
assert fork_map(drawn, [1.0, 2.0], 2) == here, here
print("the same", kernel.__name__)
"""


@pytest.mark.slow
def test_a_forked_process_draws_after_its_parent_has_drawn() -> None:
    done = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True, timeout=600, check=False)
    assert done.returncode == 0 and "the same" in done.stdout, done.stderr


# Pictures for the assembly: the section is where cables reach the drum, the exploded view separates the parts.


DRIVE = load_design(Path(__file__).parents[3] / "params" / "mbcdm.yaml").drive
METAL = Material(
    name="metal",
    density_g_cm3=1.0,
    youngs_modulus_GPa=70.0,
    poisson_ratio=0.3,
    yield_MPa=100.0,
    process="milled",
    min_wall_mm=0.5,
    min_internal_radius_mm=0.5,
    colour=(0.5, 0.5, 0.5),
    source="test",
)


def test_the_section_shows_the_plane_through_the_drum_s_axis_and_the_transfer_points() -> None:
    """Of miso_bevel: the plane x = 0, the points at (0, r_g, r_o)."""
    found = transfer_section(layout_of(DRIVE))
    assert found is not None
    centre, normal, half = found
    guide = [c.guide_radius_mm for c in DRIVE.cables]  # type: ignore[attr-defined]
    drum = [c.drum_radius_mm for c in DRIVE.cables]
    assert np.abs(normal) == pytest.approx([1.0, 0.0, 0.0], abs=1e-9)
    assert centre == pytest.approx([0.0, (min(guide) + max(guide)) / 2, (min(drum) + max(drum)) / 2], abs=1e-6)
    assert half > (max(drum) - min(drum)) / 2


def test_the_exploded_view_keeps_directions_and_multiplies_distances() -> None:
    cube = mesh_solid("cube", cq.Solid.makeBox(2, 2, 2, cq.Vector(-1, -1, -1)), 0.1)
    places = np.array([[-4.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 1.0, 3.0]])
    items = [
        Item(f"cube_{n}", "cube", METAL, "made", Placement.translation(*place), "fixed")
        for n, place in enumerate(places.tolist())
    ]
    moved = np.array([item.location.apply(np.zeros((1, 3)))[0] for item in exploded(items, {"cube": cube})])
    middle = (places.min(axis=0) + places.max(axis=0)) / 2
    assert moved - middle == pytest.approx((1.0 + EXPLODED) * (places - middle))


def test_each_cable_has_a_colour_of_its_own() -> None:
    items = layout_of(DRIVE).bill().items
    colours = [item.material.colour for item in items if item.name.startswith("cable_")]
    assert len(set(colours)) == len(colours) == 4


def test_cables_keep_their_colours_in_every_step(monkeypatch: pytest.MonkeyPatch) -> None:
    """What stood before is grey, what joins is blue, each cable stays as its own."""
    items = [
        Item(name, "cube", METAL, "made", Placement.identity(), "fixed") for name in ("cable_1", "cable_2", "a", "b")
    ]
    seen: dict[str, Vector] = {}

    def fake(shown: list[Item], *_: object, colour_of: Callable[[Item], Vector], cut: object) -> bytes:
        seen.update({item.name: colour_of(item) for item in shown})
        return b"png"

    monkeypatch.setattr("mbcdm_cad.workshop.export.picture.picture_png", fake)
    made = {"cube": SimpleNamespace(files=SimpleNamespace(mesh=None))}
    assert pictures._png(made, items, {"new": frozenset({"cable_2", "b"})}) == b"png"  # type: ignore[arg-type]
    assert seen == {"cable_1": METAL.colour, "cable_2": METAL.colour, "a": pictures.BEFORE, "b": pictures.NEW}
