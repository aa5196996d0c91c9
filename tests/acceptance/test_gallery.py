"""The drives of params/gallery: each file has at most ten lines, and its design passes every check."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mbcdm_cad.checks.remedies import Budget
from mbcdm_cad.checks.run import run_check
from mbcdm_cad.layouts.check_design import checks_of
from mbcdm_cad.layouts.loader import load_design

GALLERY = sorted((Path(__file__).parents[2] / "params" / "gallery").glob("*.yaml"))


def test_there_is_a_gallery() -> None:
    assert len(GALLERY) >= 12


@pytest.mark.parametrize("path", GALLERY, ids=lambda path: path.stem)
def test_a_short_file_gives_a_drive_that_passes(path: Path) -> None:
    lines = [line for line in path.read_text("utf-8").splitlines() if line and not line.startswith("#")]
    assert len(lines) <= 10, lines
    drive = load_design(path).drive
    subject = drive.layout
    with np.errstate(all="ignore"):
        found = [run_check(check, subject, Budget(0)) for check in checks_of(drive)]
    assert {check.id: check.message for check in found if check.status == "fail"} == {}
