"""The gallery: drives from short files with a picture and their key figures. ``python -m`` this writes the page.

    python -m mbcdm_cad.report.gallery_page params/gallery docs

writes ``docs/gallery.md`` and a picture of each drive below ``docs/pictures/gallery``. Parts are drawn, but only a
build tests them for interference.
"""

import re
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mbcdm_cad.design.loader import LoadedDesign
from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.layouts.turns import turns_of
from mbcdm_cad.report.data import Tested, report_data
from mbcdm_cad.report.table import ReportTable
from mbcdm_cad.storage.cache import Cache, cache_folder
from mbcdm_cad.storage.folders import write_whole
from mbcdm_cad.workshop.store import drawn

_PICTURE_PX = (560, 440)
_COLUMNS = (
    "drive",
    "lines",
    "ratio",
    "travel, deg",
    "torque, N m",
    "rope",
    "preload, N",
    "mass, g",
    "box X x Z x Y, mm",
    "swing of the payload, mrad",
    "by the cables, at N m",
    "lowest mode, Hz",
)
_HEAD = """# Gallery

Drives from short files in `params/gallery/`: a file states the requirements and the fixed values, and sizing rules
compute all others (`mbcdm explain`). All drives pass every check. `make gallery` draws the pictures and writes this
page; `mbcdm page params/gallery/wrist.yaml` writes the page with the wrist in 3D. A study shows
[which short files give a drive](reach.md).

Torque: in the weaker direction, with all losses counted. Swing: at a reversal of the test torque, of the
payload by cables and structure, and by the cables alone. Lowest mode: with the inputs held, cables and structure.
"""
# The end of a file's first line that is the same in all files.
_HINT = re.compile(r"\.\s+(Everything else|mbcdm explain).*")


@dataclass(frozen=True)
class GalleryDrive:
    """A drive of the gallery: file, first sentence, picture, and its report without the results of a whole build."""

    loaded: LoadedDesign
    report: dict[str, Any]
    png: bytes

    @property
    def words(self) -> str:
        """The first sentence of the file."""
        first = self.loaded.text.splitlines()[0].removeprefix("#").strip()
        return _HINT.sub("", first).rstrip(".") + "."

    @property
    def lines(self) -> int:
        """Lines of the file that are not comments."""
        return sum(bool(line.split("#")[0].strip()) for line in self.loaded.text.splitlines())

    def row(self) -> tuple[Any, ...]:
        """Its line of the table."""
        drive, r = self.loaded.drive, self.report
        cable = drive.cables[0]
        torque = min(r["torque"]["peak_positive_Nm"], r["torque"]["peak_negative_Nm"])
        a = r["analysis"]
        return (
            drive.name,
            self.lines,
            cable.drum_radius_mm / cable.input_radius_mm,
            drive.travel_words,
            torque,
            f"{drive.cable.diameter_mm:g} mm",
            cable.preload_N,
            f"{r['mass']['mass_g']:.0f}",
            " x ".join(f"{side:.0f}" for side in r["envelope"]["size_mm"]),
            f"{turns_of(layout_of(drive)).felt.swing_mrad:.3g}",
            f"{a['reversal_swing_mrad']:.3g} at {drive.loads.test_torque_Nm:g}",
            f"{r['torsion']['lowest_inputs_held_Hz']:.0f}",
        )


def gallery_drive(path: Path, cache: Cache) -> GalleryDrive:
    """One drive, drawn. Raises as :func:`~mbcdm_cad.layouts.loader.load_design` and ``drawn`` do."""
    from mbcdm_cad.workshop.export.picture import picture_png  # loads the drawing library

    loaded = load_design(path)
    items, parts = drawn(loaded.drive, 0.0, cache, lambda name: None)
    layout = layout_of(loaded.drive)
    data = report_data(layout, layout.bill(), parts, Tested(), drum_angle_deg=0.0, design_sha256=loaded.sha256)
    png = picture_png(items, {name: part.files.mesh for name, part in parts.items()}, "output", _PICTURE_PX)
    return GalleryDrive(loaded, data, png)


def gallery_markdown(drives: Sequence[GalleryDrive], folder: str) -> Iterator[str]:
    """Lines of the page; ``folder``: that of the pictures, relative to the page."""
    yield _HEAD
    yield from ReportTable(_COLUMNS, tuple(one.row() for one in drives)).markdown()
    for one in drives:
        name = one.loaded.drive.name
        yield f"\n## {name}\n"
        yield f"`params/gallery/{one.loaded.path.name}`: {one.words}\n"
        yield f"![{name}, drum centred, seen from its output side]({folder}/{name}.png)"


def main(designs: Path, docs: Path) -> None:
    """Write page and pictures."""
    cache = Cache(cache_folder())
    drives = []
    for path in sorted(designs.glob("*.yaml")):
        print(f"drawing {path.stem}", file=sys.stderr, flush=True)
        drives.append(gallery_drive(path, cache))
    folder = Path("pictures", "gallery")
    files = {docs / folder / f"{one.loaded.drive.name}.png": one.png for one in drives}
    page = "\n".join(gallery_markdown(drives, folder.as_posix())) + "\n"
    write_whole({docs / "gallery.md": page.encode(), **files})


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
