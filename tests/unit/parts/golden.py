"""Volumes of the reference design's parts as last reviewed.

After an intended change of geometry ``python tests/unit/parts/golden.py`` writes golden_volumes.json again; read the
diff before you commit it.
"""

import json
from pathlib import Path

FILE = Path(__file__).with_name("golden_volumes.json")


def golden_volumes() -> dict[str, float]:
    """Part name to volume, mm^3."""
    volumes: dict[str, float] = json.loads(FILE.read_text("utf-8"))
    return volumes


def _write() -> None:
    from mbcdm_cad.layouts.loader import load_design
    from mbcdm_cad.layouts.miso_bevel.bill import bill
    from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout

    drive = load_design(Path(__file__).parents[3] / "params" / "mbcdm.yaml").drive
    parts = bill(BevelLayout(drive)).parts
    volumes = {name: round(spec.part.solid().Volume(), 6) for name, spec in sorted(parts.items())}
    FILE.write_text(json.dumps(volumes, indent=1) + "\n", "utf-8")


if __name__ == "__main__":
    _write()
