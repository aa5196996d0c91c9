"""The preview of a design under `mbcdm watch`: the order of its work, and a part without a mesh."""

from __future__ import annotations

from pathlib import Path

import cadquery as cq

from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.live.preview import Previewer
from mbcdm_cad.storage.cache import Cache
from mbcdm_cad.workshop.makefiles import make_part_files
from mbcdm_cad.workshop.store import StoredPart

REFERENCE = Path(__file__).parents[3] / "params" / "mbcdm.yaml"


def test_pulleys_come_first_and_then_the_most_work(tmp_path: Path) -> None:
    previewer = Previewer(tmp_path, Cache(None), lambda: None)
    previewer._lengths = {"drum": 900, "frame": 500, "guide": 20, "input_pulley": 90, "dowel": 4}
    names = ["dowel", "frame", "drum", "input_pulley", "guide"]
    assert previewer._in_order(names, {"guide", "input_pulley"}) == ["input_pulley", "guide", "drum", "frame", "dowel"]
    assert previewer._in_order(["collar"], {"guide"}) == ["collar"] and previewer._in_order([], set()) == []


def test_step_is_there_before_the_mesh_and_no_stl_of_an_older_state_stays(tmp_path: Path) -> None:
    previewer, metal = Previewer(tmp_path, Cache(None), lambda: None), load_design(REFERENCE).drive.guide_material
    solid = cq.Solid.makeBox(1, 2, 3)
    meshed = make_part_files("rope", solid, metal, 0.01, on_step=previewer._write_step)
    assert [path.name for path in (tmp_path / "parts").iterdir()] == ["rope.step"]
    previewer._write({"rope": StoredPart("key", meshed)})
    assert sorted(path.name for path in (tmp_path / "parts").iterdir()) == ["rope.step", "rope.stl"]
    bare = make_part_files("rope", solid, metal, None)
    previewer._write({"rope": StoredPart("other key", bare)})
    assert [path.name for path in (tmp_path / "parts").iterdir()] == ["rope.step"]
    assert bare.step == meshed.step and bare.shape == meshed.shape and bare.mesh.is_empty
