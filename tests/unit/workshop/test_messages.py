"""Messages of a build during the work and for a part that cannot be drawn; messages that must not appear."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from mbcdm_cad.cli.group import progress
from mbcdm_cad.errors import GeometryError
from mbcdm_cad.jobs import build as job
from mbcdm_cad.jobs.build import build
from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.storage.cache import Cache

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
