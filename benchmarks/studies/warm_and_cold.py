"""What the cache gives is what drawing gives: after each random edit a build has the same bytes with and without it.

    python -m benchmarks.studies.warm_and_cold 300

It prints the edits that could be built, and fails at the first with another byte.
"""

import os
import random
import re
import sys
import tempfile
from pathlib import Path

from mbcdm_cad import cli
from mbcdm_cad.storage.cache import ENVIRONMENT_VARIABLE

ROOT = Path(__file__).parents[2]
FILES = [ROOT / "params" / name for name in ("mbcdm.yaml", "siso_bevel.yaml", "siso_spur.yaml", "miso_spur.yaml")]
NUMBER = re.compile(r"^( +\w+: )(\d+\.\d+)(?= )", re.MULTILINE)


def edited(text: str, rng: random.Random) -> str:
    """The text with one to three of its numbers up to a tenth larger or smaller."""
    for place in sorted(rng.sample(list(NUMBER.finditer(text)), rng.randint(1, 3)), key=lambda one: -one.start()):
        new = f"{place[1]}{float(place[2]) * rng.uniform(0.9, 1.1):.4g}"
        text = text[: place.start()] + new + text[place.end() :]
    return text


def build(design: Path, out: Path, *more: str) -> int:
    """Exit code of a build in a process of its own, which nothing that was drawn before is in."""
    if child := os.fork():
        return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    code = 70
    try:
        code = cli.run(["build", str(design), "--force", "--jobs", "1", "--out", str(out), *more])
    finally:
        os._exit(code)


def same_after_edits(folder: Path, seeds: range) -> int:
    """How many edits could be built; each into the folder of the build before, from the cache of all before."""
    built = 0
    for seed in seeds:
        base = FILES[seed % len(FILES)]
        design, warm, cold = folder / base.name, folder / "warm", folder / f"cold-{seed}"
        design.write_text(edited(base.read_text("utf-8"), random.Random(seed)))
        codes = build(design, warm), build(design, cold, "--no-cache")
        assert codes[0] == codes[1] != 70, (seed, codes)
        if codes[0] == 2:
            continue
        files = [path.relative_to(cold) for path in sorted(cold.rglob("*")) if path.is_file()]
        there = warm / files[0].parts[0]
        assert [path.relative_to(warm) for path in sorted(there.rglob("*")) if path.is_file()] == files, seed
        other = [str(name) for name in files if (warm / name).read_bytes() != (cold / name).read_bytes()]
        assert not other and len(files) > 40, (seed, other)
        built += 1
    return built


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        os.environ[ENVIRONMENT_VARIABLE] = str(Path(folder) / "cache")
        print(f"{same_after_edits(Path(folder), range(int(sys.argv[1])))} of {sys.argv[1]} edits built: the same bytes")
