"""Every block that a file of params offers in a comment, taken out of it, gives a design or a sentence."""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

import mbcdm_cad as mc

PARAMS = Path(__file__).parents[2] / "params"
# The block's name, lines of prose about it, and the lines of its fields.
BLOCK = re.compile(r"^( *)# (\w+):.*\n(?:\1 +#(?!   \w+:).*\n)*(?:\1#   +\S.*\n)+", re.MULTILINE)
# What the reference cannot have: a rope beside its own, or a stage or a torque that its frame or its loads exclude.
REFUSED = {"inline", "idlers", "mbcdm stage", "siso_bevel stage", "siso_bevel duty"}


def cases() -> Iterator[tuple[str, str, str]]:
    """File, block, and text with the block."""
    for path in sorted(PARAMS.rglob("*.yaml")):
        text = path.read_text("utf-8")
        for found in BLOCK.finditer(text):
            block = re.sub(rf"^{found[1]}# ", found[1], found[0], flags=re.MULTILINE)
            yield path.name, found[2], text[: found.start()] + block + text[found.end() :]


@pytest.mark.slow
@pytest.mark.parametrize(("file", "name", "text"), list(cases()), ids=lambda value: value if len(value) < 40 else "")
def test_a_block_out_of_its_comment_is_a_design_or_a_sentence(file: str, name: str, text: str, tmp_path: Path) -> None:
    path = tmp_path / file
    path.write_text(text)
    try:
        design = mc.load(path)
        assert len(design.check()) > 50
        design.analyse()
    except mc.MbcdmError:
        if not {name, f"{path.stem} {name}"} & REFUSED:
            raise
        return
    assert design.build(tmp_path / "out", force=True).folder is not None
