"""The loader finds the configuration of a design file by its ``configuration``; a new one needs no change of it."""

from collections.abc import Iterator, Mapping
from importlib.metadata import EntryPoint
from types import SimpleNamespace
from typing import Any, ClassVar, Literal, cast

import pytest
import yaml

from mbcdm_cad.design.blocks import Cable, Design, Input, SpanLimits, WoundRope
from mbcdm_cad.design.describe import Given, editor_schema
from mbcdm_cad.design.fields import Block, Number, choice, quantity
from mbcdm_cad.design.loader import DesignFile
from mbcdm_cad.design.rules import Broken, NamedEntry
from mbcdm_cad.design.template import reference_page
from mbcdm_cad.errors import InputError, MbcdmError
from mbcdm_cad.layouts import registry
from mbcdm_cad.layouts.base import Layout
from mbcdm_cad.layouts.loader import design_file, load_text, new_design_text, reference_data

BEVEL = design_file()


class Belt(Block):
    """What only this configuration has."""

    pitch_mm: Number = quantity("pitch", uncertain=True, source="a test", reference=2.0, ge=1.0, le=5.0)
    pulley_material: str = choice("material of the pulley", source="a test", reference="steel")


class BeltDesign(Design):
    """A drive of a test."""

    ORDER: ClassVar[tuple[str, ...]] = (
        "schema_version",
        "name",
        "configuration",
        "travel",
        "belt",
        "inputs",
        "cables",
        "rope",
        "drive",
        "loads",
        "limits",
        "making",
        "printing",
        "targets",
        "export",
        "waivers",
        "as_built",
        "catalogue",
    )

    configuration: Literal["belt"] = choice("layout", source="a test", reference="belt")
    inputs: tuple[Input, ...] = choice("one input", reference=[{"name": "motor"}], min_length=1, max_length=1)
    cables: tuple[Cable, ...] = choice(
        "two cables", reference=[{"name": "a", "input": "motor"}, {"name": "b", "input": "motor"}]
    )
    rope: WoundRope
    limits: SpanLimits
    belt: Belt


def broken(design: BeltDesign) -> Iterator[Broken]:
    """A rule that only this configuration has."""
    if design.belt.pitch_mm > design.travel.half_angle_deg:
        yield Broken(("belt", "pitch_mm"), "too long", f"{design.belt.pitch_mm:g}", "the travel", "shorten it")


def named(design: BeltDesign) -> Iterator[NamedEntry]:
    """The one entry of the catalogue that its own block names."""
    yield NamedEntry(("belt", "pulley_material"), "materials", design.belt.pulley_material)


class DriveError(Exception):
    """Raised in place of making a drive, with what the loader handed over."""


def drive(design: BeltDesign, _catalogue: Any, sigmas: Mapping[Any, float]) -> Any:
    """No drive: tells what the loader called it with."""
    raise DriveError(design, dict(sigmas))


@pytest.fixture
def belt(monkeypatch: pytest.MonkeyPatch) -> DesignFile:
    """The design file of a configuration that a program adds to the registry."""
    monkeypatch.setattr(registry, "_added", dict(registry._added))
    own = ("inputs", "cables", "clearances", "drum", "input_pulleys")
    shared = {place: given for place, given in BEVEL.reference.items() if place.partition(".")[0] not in own}
    file = DesignFile(BeltDesign, {**shared, "travel.half_angle_deg": Given(20.0, "a test")}, broken, named, drive)
    registry.add(cast("Any", SimpleNamespace(name="belt", design_file=lambda: file)))
    return file


def refusal(text: str) -> str:
    with pytest.raises(InputError) as caught:
        load_text(text, "f.yaml")
    return str(caught.value)


@pytest.mark.parametrize("name", ["miso_bevl", "2", "[miso_bevel]", "{a: 1}", "~", "miso-bevel"])
def test_an_unknown_configuration_is_one_sentence_with_those_known_and_a_remedy(name: str) -> None:
    text = new_design_text("trial").replace("configuration: miso_bevel", f"configuration: {name}")
    line = next(k for k, row in enumerate(text.split("\n"), 1) if row.startswith("configuration"))
    said = refusal(text)
    assert said.startswith(f"f.yaml:{line}: configuration: not a known word (value "), said
    assert "limit one of miso_bevel" in said and "miso_bevel" in said.split(";")[1] and "\n" not in said, said


def test_a_file_without_a_configuration_is_told_of_everything_that_is_wrong() -> None:
    said = refusal("configuratoin: miso_bevel\nname: trial\n").split("\n")
    assert any("configuration: missing" in line and "for example configuration: miso_bevel" in line for line in said)
    assert any("configuratoin: unknown field; did you mean configuration?" in line for line in said), "\n".join(said)


def test_another_configuration_is_read_by_its_own_schema_and_rules(belt: DesignFile) -> None:
    data = reference_data("belt")
    assert data["travel"]["half_angle_deg"] == 20.0 and data["belt"] == {"pitch_mm": 2.0, "pulley_material": "steel"}
    assert list(data) == list(BeltDesign.ORDER)
    data["belt"]["pitch_mm"] = {"value": 3.0, "sigma": 0.5}
    with pytest.raises(DriveError) as made:
        load_text(yaml.safe_dump(data))
    design, sigmas = made.value.args
    assert design.belt.pitch_mm == 3.0 and sigmas == {("belt", "pitch_mm"): 0.5}


@pytest.mark.parametrize(
    ("block", "field", "value", "said"),
    [
        ("belt", "pitch_mm", 9.0, "belt.pitch_mm: out of bounds (value 9.0, limit 1 to 5 mm)"),
        ("travel", "half_angle_deg", 1.5, "belt.pitch_mm: too long (value 2, limit the travel); shorten it"),
        ("belt", "pulley_material", "stel", "belt.pulley_material: not in the catalogue of materials (value 'stel')"),
        ("drive", "motor", "none", "drive.motor: not in the catalogue of motors"),
        ("travel", "guide", 1.0, "travel.guide: unknown field"),
    ],
)
def test_its_problems_are_told_as_any_other(belt: DesignFile, block: str, field: str, value: Any, said: str) -> None:
    data = reference_data("belt")
    data[block][field] = value
    assert said in refusal(yaml.safe_dump(data)), refusal(yaml.safe_dump(data))


def test_its_pages_are_written_from_its_schema(belt: DesignFile) -> None:
    text = new_design_text("trial", "belt")
    assert "half_angle_deg: 20.0" in text and "# mm: pitch [a test]" in text and "guide" not in text
    assert yaml.safe_load(text) == {**reference_data("belt"), "name": "trial"}
    assert "## belt" in reference_page(belt.nodes) and "## guide" not in reference_page(belt.nodes)
    assert "BeltDesign" not in editor_schema(belt.nodes)["title"]


def test_a_reference_value_for_no_field_is_refused() -> None:
    with pytest.raises(KeyError, match="no_such"):
        _ = DesignFile(BeltDesign, {"travel.no_such": Given(1.0)}, broken, named, drive).nodes


def test_no_pages_of_an_unknown_configuration() -> None:
    with pytest.raises(MbcdmError, match=r"no such configuration \(value none, limit one of miso_bevel"):
        new_design_text("trial", "none")


# The registry: finds the layouts of the package, accepts one from outside, and names an unknown one.


class Outside(Layout):
    """A layout of another package."""

    name, title = "outside", "from a test"


def test_every_folder_is_found_under_its_own_name() -> None:
    assert "miso_bevel" in registry.names()
    for name in registry.names():
        assert registry.layout_named(name).name == name
        assert registry.layout_named(name).title


def test_one_from_outside_is_found_once_it_is_added(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(registry, "_added", {})
    with pytest.raises(MbcdmError, match="outside"):
        registry.layout_named("outside")
    registry.add(Outside)
    assert registry.layout_named("outside").title == "from a test"
    assert registry.names()[-1] == "outside"


def test_a_plug_in_names_its_class(monkeypatch: pytest.MonkeyPatch) -> None:
    entry = EntryPoint("outside", f"{__name__}:Outside", registry.ENTRY_POINTS)
    monkeypatch.setattr(registry, "_added", {})
    monkeypatch.setattr(registry, "_plug_ins", lambda: {"outside": entry})
    assert registry.layout_named("outside").title == "from a test"
    assert registry.names()[-1] == "outside"


def test_an_unknown_name_is_refused_with_the_names_there_are() -> None:
    with pytest.raises(MbcdmError, match=r"miso_bevl.*miso_bevel"):
        registry.layout_named("miso_bevl")
