"""The recipes of docs/CONTRIBUTING.md, done by their own text in a copy of the package; counts the files they touch.

A line ``# FILE`` in their code begins what stands at the file's end, ``# FILE, after LINE`` what stands there.
"""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

TREE = Path(__file__).resolve().parents[2]
SHORT = """configuration: siso_bevel
travel: {half_angle_deg: 35.0}
transmission: {drum_radius_mm: 60.0}
loads: {peak_torque_Nm: 0.9}
"""
_PLACED = re.compile(r"^# (mbcdm_cad/\S+?)(?:, after (.+))?\n((?:(?!# mbcdm_cad/|```).*\n)*)", re.MULTILINE)


class Copy:
    """A copy of the package in which the blocks of some recipes stand."""

    def __init__(self, folder: Path, *recipes: str) -> None:
        shutil.copytree(TREE / "mbcdm_cad", folder / "mbcdm_cad", ignore=shutil.ignore_patterns("__pycache__"))
        self.folder, self.touched = folder, set[str]()
        text = (TREE / "docs" / "CONTRIBUTING.md").read_text("utf-8")
        for recipe in recipes:
            section = text.split(f"## {recipe}\n")[1].split("\n## ")[0]
            for file, line, code in _PLACED.findall(section):
                path, self.touched = folder / file, self.touched | {file}
                before, after = path.read_text("utf-8"), f"\n\n{code}"
                if line:
                    assert before.count(f"{line}\n") == 1, f"{recipe}: {file} has not one line {line!r}"
                    before, after = before.split(f"{line}\n")[0] + f"{line}\n" + code, before.split(f"{line}\n")[1]
                path.write_text(before + after, "utf-8")

    def says(self, *command: str) -> str:
        """What Python prints with the package of the copy."""
        env = os.environ | {"PYTHONPATH": str(self.folder), "MBCDM_CACHE_DIR": str(self.folder / "cache")}
        done = subprocess.run([sys.executable, *command], cwd=self.folder, env=env, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return done.stdout


@pytest.fixture
def short(tmp_path: Path) -> str:
    path = tmp_path / "short.yaml"
    path.write_text(SHORT, "utf-8")
    return str(path)


def test_a_check_is_one_file(tmp_path: Path) -> None:
    copy, file = Copy(tmp_path, "A check"), str(TREE / "params" / "mbcdm.yaml")
    assert len(copy.touched) == 1
    found = {one["id"]: one for one in json.loads(copy.says("-m", "mbcdm_cad", "check", file, "--json"))["checks"]}
    assert found["web_of_sheet"]["status"] == "pass"
    assert "`web_of_sheet`" in copy.says("-m", "mbcdm_cad.report.checks_page", file)


def test_a_field_is_one_file_and_its_rule_another(tmp_path: Path, short: str) -> None:
    copy = Copy(tmp_path, "A field of the design file")
    assert len(copy.touched) == 1
    assert "glue_gap_mm" in copy.says("-m", "mbcdm_cad", "schema")
    assert "its default" in copy.says("-m", "mbcdm_cad", "explain", short, "making.glue_gap_mm")
    both = Copy(tmp_path / "both", "A field of the design file", "A sizing rule")
    assert len(both.touched - copy.touched) == 1
    told = json.loads(both.says("-m", "mbcdm_cad", "explain", short, "making.glue_gap_mm", "--json"))
    assert told["value"] == 0.05 and told["driver"] == "loads.peak_torque_Nm"


def test_a_part_is_two_files(tmp_path: Path) -> None:
    copy, file = Copy(tmp_path, "A part"), TREE / "params" / "siso_bevel.yaml"
    code = (
        "import sys\nfrom pathlib import Path\nfrom mbcdm_cad.layouts.loader import load_design\n"
        "from mbcdm_cad.layouts.registry import layout_of\nlayout = layout_of(load_design(Path(sys.argv[1])).drive)\n"
        "print(sum('shim' in step.items for step in layout.assembly_order), layout.bill().volumes_mm3['shim'])"
    )
    joins, volume = copy.says("-c", code, str(file)).split()
    assert len(copy.touched) == 2 and int(joins) == 1 and float(volume) > 0.0
