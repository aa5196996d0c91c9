"""STEP files: the same bytes for the same model, and the same model after reading."""

from __future__ import annotations

import hashlib
import random
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import cadquery as cq
import pytest
from export_samples import STEEL
from OCP.Quantity import Quantity_TypeOfColor

from mbcdm_cad.errors import GeometryError
from mbcdm_cad.parts.bill import Item
from mbcdm_cad.storage.cache import Cache
from mbcdm_cad.workshop.export.files import canonical_step, with_description
from mbcdm_cad.workshop.export.step import assembly_step, part_step
from mbcdm_cad.workshop.kernel import brep_bytes, measure, shape_from_brep
from mbcdm_cad.workshop.makefiles import make_part_files
from mbcdm_cad.workshop.mass import PartFiles

# Another process: other addresses, another order of items, other exports before.
_ELSEWHERE = """
import hashlib, random, sys
sys.path[:0] = sys.argv[2:]
from export_samples import STEEL, make_items, make_solids
from mbcdm_cad.workshop.export.step import assembly_step, part_step
chance = random.Random(int(sys.argv[1]))
waste = [bytearray(chance.randrange(10, 5000)) for _ in range(chance.randrange(3000))]
solids, items = make_solids(), make_items()
chance.shuffle(items)
for part in chance.sample(sorted(solids), chance.randrange(4)):
    part_step(part, solids[part], STEEL)
print(hashlib.sha256(assembly_step("model", items, solids)).hexdigest())
print(hashlib.sha256(part_step("plate", solids["plate"], STEEL)).hexdigest())
"""


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (1, 2))])
def test_same_bytes_in_another_process(seed: int, items: list[Item], solids: dict[str, cq.Solid]) -> None:
    here = [_digest(assembly_step("model", items, solids)), _digest(part_step("plate", solids["plate"], STEEL))]
    paths = [str(Path(__file__).parents[4]), str(Path(__file__).parent)]
    command = [sys.executable, "-c", _ELSEWHERE, str(seed), *paths]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout.split() == here, f"process {seed} wrote other bytes: {done.stdout.split()} against {here}"


def test_same_bytes_whatever_came_before(items: list[Item], solids: dict[str, cq.Solid]) -> None:
    chance = random.Random(4)
    first = assembly_step("model", items, solids)
    for turn in range(10):
        chance.shuffle(items)
        part_step("plate", solids["plate"], STEEL)
        again = assembly_step("model", items, solids)
        assert again == first, f"turn {turn}: {_digest(again)} against {_digest(first)}"


def test_same_bytes_from_stored_solids(items: list[Item], solids: dict[str, cq.Solid]) -> None:
    stored = {part: shape_from_brep(brep_bytes(solid)) for part, solid in solids.items()}
    assert assembly_step("model", items, stored) == assembly_step("model", items, solids)


def test_another_model_gives_other_bytes(items: list[Item], solids: dict[str, cq.Solid]) -> None:
    moved = [replace(items[0], location=items[1].location @ items[0].location), *items[1:]]
    assert assembly_step("model", moved, solids) != assembly_step("model", items, solids)


def test_assembly_comes_back_equal(items: list[Item], solids: dict[str, cq.Solid], tmp_path: Path) -> None:
    path = tmp_path / "model.step"
    path.write_bytes(assembly_step("model", items, solids))
    back = cq.Assembly.importStep(str(path))
    assert back.name == "model"
    found = {name: node for name, node in back.traverse() if node.obj is not None}
    assert set(found) == {item.name for item in items}
    for item in items:
        node = found[item.name]
        volume, expected = node.obj.Volume(), solids[item.part].Volume()
        assert abs(volume / expected - 1.0) < 1e-6, f"{item.name}: volume {volume} against {expected}"
        shift = node.loc.toTuple()[0]
        assert shift == pytest.approx(tuple(item.location.shift_mm), abs=1e-9), f"{item.name} is at {shift}"
        linear = tuple(node.color.wrapped.GetRGB().Values(Quantity_TypeOfColor.Quantity_TOC_RGB))
        assert linear == pytest.approx(item.material.colour, abs=1e-5), f"{item.name} has colour {linear}"
        assert node.material.name == item.material.name
        assert node.material.density == pytest.approx(item.material.density_g_cm3, rel=1e-12)
        assert node.parent.name == item.group


def test_part_is_named(solids: dict[str, cq.Solid], tmp_path: Path) -> None:
    path = tmp_path / "plate.step"
    path.write_bytes(part_step("plate", solids["plate"], STEEL, description="it's 30 µm off"))
    text = path.read_text("ascii")
    assert text.count("=PRODUCT('plate','plate',") == 1, "the product is not named"
    assert "('it''s 30 \\X4\\000000B5\\X0\\m off')" in text
    back = cq.importers.importStep(str(path)).val()
    assert back.Volume() == pytest.approx(solids["plate"].Volume(), rel=1e-9)


def test_density_has_a_density_unit(solids: dict[str, cq.Solid]) -> None:
    text = part_step("plate", solids["plate"], STEEL).decode()
    exponents = sorted(line.split(",")[1] for line in text.splitlines() if "DERIVED_UNIT_ELEMENT(" in line)
    assert exponents == ["-3.);", "1.);"], f"unit of density is not g cm^-3: {exponents}"


def test_description_can_be_set_later(solids: dict[str, cq.Solid]) -> None:
    late = with_description(part_step("plate", solids["plate"], STEEL).decode(), "forced")
    assert late.encode() == part_step("plate", solids["plate"], STEEL, description="forced")


def test_text_that_is_no_step_is_refused() -> None:
    with pytest.raises(ValueError, match="no STEP data section"):
        canonical_step("hello", "x", "")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"name": "plate_1"}, "two items are named"),
        ({"name": "../x"}, "must match"),
        ({"part": "gone"}, "has no solid"),
        ({"mass_g": 3.0}, "differ in material, kind or mass"),
    ],
)
def test_bad_items_are_refused(
    items: list[Item], solids: dict[str, cq.Solid], change: dict[str, str], message: str
) -> None:
    index = next(k for k, item in enumerate(items) if item.name == "plate_0")
    items[index] = replace(items[index], **change)
    with pytest.raises(ValueError, match=message):
        assembly_step("model", items, solids)


# The stored files of a part contain everything that a build needs of it.


KEY = "5" * 64


def test_part_survives_the_cache(solids: dict[str, cq.Solid], tmp_path: Path) -> None:
    made = make_part_files("plate", solids["plate"], STEEL, 0.02)
    Cache(tmp_path).put(KEY, made.to_blobs())
    blobs = Cache(tmp_path).get(KEY)
    assert blobs is not None
    found = PartFiles.from_blobs("plate", blobs)
    assert (found.brep, found.step, found.stl, found.shape) == (made.brep, made.step, made.stl, made.shape)
    assert abs(found.mesh_volume_error) < 1e-3, f"mesh volume off by {found.mesh_volume_error:.1e}"
    solid = shape_from_brep(found.brep)
    assert measure(solid).volume_mm3 == pytest.approx(made.shape.volume_mm3, rel=1e-12)
    assert part_step("plate", solid, STEEL) == made.step


def test_stored_part_is_read_without_the_kernel(solids: dict[str, cq.Solid], tmp_path: Path) -> None:
    Cache(tmp_path).put(KEY, make_part_files("disc", solids["disc"], STEEL, 0.02).to_blobs())
    code = f"""
import sys
from pathlib import Path
from mbcdm_cad.storage.cache import Cache
from mbcdm_cad.workshop.export.files import glb_bytes
from mbcdm_cad.workshop.mass import item_mass
from mbcdm_cad.workshop.mass import PartFiles
part = PartFiles.from_blobs("disc", Cache(Path({str(tmp_path)!r})).get({KEY!r}))
print(len(part.stl), round(part.shape.volume_mm3), [n for n in ("cadquery", "OCP", "vtkmodules") if n in sys.modules])
"""
    root = Path(__file__).parents[4]
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=root)
    size, volume, imported = done.stdout.split(maxsplit=2)
    assert int(size) > 84
    assert int(volume) == 51472  # pi 64^2 4
    assert imported == "[]\n"


def test_unsound_part_is_not_made() -> None:
    with pytest.raises(GeometryError, match="drum: a Compound of 2 solids"):
        make_part_files("drum", cq.Workplane().box(9, 1, 1).cut(cq.Workplane().box(3, 3, 3)).val(), STEEL, 0.02)
