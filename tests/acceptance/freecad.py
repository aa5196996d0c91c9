"""Open a STEP file in FreeCAD, an independent program with its own reader, and compare the result.

Used by the acceptance tests, and by hand: ``python tests/acceptance/freecad.py FILE.step`` prints the findings and
compares them with those of the CAD library for the same file.
"""

import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Any

VOLUME_LIMIT = 1e-6  # relative
_TIMEOUT_S = 600
_PROGRAMS = ("freecadcmd", "FreeCADCmd", "freecad.cmd")


def freecad_program() -> str | None:
    """FreeCAD's console program; None if it is not installed."""
    return next((found for found in map(shutil.which, _PROGRAMS) if found), None)


def freecad_findings(path: Path) -> dict[str, Any]:
    """What FreeCAD finds in a STEP file (see freecad_check.py). Raises ``RuntimeError`` if it cannot say."""
    return run_in_freecad(Path(__file__).with_name("freecad_check.py"), path)


def run_in_freecad(script: Path, checked: Path) -> dict[str, Any]:
    """The last JSON object that a script prints in FreeCAD; it finds the file to read in the variable CHECKED_FILE.

    Raises ``RuntimeError`` if FreeCAD is missing or prints none.
    """
    program = freecad_program()
    if program is None:
        raise RuntimeError("FreeCAD is not installed (Debian: apt-get install freecad-python3)")
    with tempfile.TemporaryDirectory() as home:
        # A virtual environment or a plain C locale makes FreeCAD 0.20 fail at its start; a home of its own keeps
        # settings of this machine out.
        environment = {key: value for key, value in os.environ.items() if key not in ("VIRTUAL_ENV", "PYTHONPATH")}
        environment |= {"LC_ALL": "C.UTF-8", "FREECAD_USER_HOME": home, "CHECKED_FILE": str(checked.resolve())}
        done = subprocess.run(
            [program, str(script)], env=environment, capture_output=True, text=True, timeout=_TIMEOUT_S, check=False
        )
    last = next((line for line in reversed(done.stdout.splitlines()) if line.startswith("{")), None)
    if last is None:
        said = f"{done.stdout[-500:]}{done.stderr[-2000:]}"
        raise RuntimeError(f"FreeCAD printed no findings (exit {done.returncode}): {said}")
    findings: dict[str, Any] = json.loads(last)
    return findings


def differences(findings: dict[str, Any], expected: Iterable[tuple[str, float]]) -> list[str]:
    """Where FreeCAD's findings differ from the ``expected`` part name and volume (mm^3) of every instance."""
    expected = list(expected)
    found: list[str] = []
    if findings["solids"] != len(expected):
        found.append(f"{findings['solids']} solids, expected {len(expected)}")
    if not findings["valid"]:
        found.append("the whole is not valid")
    found += [f"{part['name']} is not valid" for part in findings["parts"] if not part["valid"]]
    found += [f"{part['name']} has {part['solids']} solids" for part in findings["parts"] if part["solids"] != 1]
    names, wanted = Counter(part["name"] for part in findings["parts"]), Counter(name for name, _ in expected)
    if names != wanted:
        found.append(f"names differ: missing {sorted(wanted - names)}, unknown {sorted(names - wanted)}")
    volumes = dict(expected)
    for part in findings["parts"]:
        volume = volumes.get(part["name"])
        if volume is not None and abs(part["volume_mm3"] / volume - 1.0) > VOLUME_LIMIT:
            found.append(f"{part['name']}: volume {part['volume_mm3']:.9g} mm^3, expected {volume:.9g}")
    total = sum(volume for _, volume in expected)
    if abs(findings["volume_mm3"] / total - 1.0) > VOLUME_LIMIT:
        found.append(f"volume of all {findings['volume_mm3']:.9g} mm^3, expected {total:.9g}")
    return found


def read_parts(path: Path) -> list[tuple[str, float]]:
    """Part name and volume of every instance in a STEP file, as the CAD library reads it."""
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps
    from OCP.STEPCAFControl import STEPCAFControl_Reader
    from OCP.TCollection import TCollection_ExtendedString
    from OCP.TDataStd import TDataStd_Name
    from OCP.TDF import TDF_Label, TDF_LabelSequence
    from OCP.TDocStd import TDocStd_Document
    from OCP.XCAFDoc import XCAFDoc_DocumentTool, XCAFDoc_ShapeTool

    document = TDocStd_Document(TCollection_ExtendedString("BinXCAF"))
    reader = STEPCAFControl_Reader()
    reader.SetNameMode(True)
    reader.ReadFile(str(path))
    reader.Transfer(document)
    parts: list[tuple[str, float]] = []

    def walk(label: TDF_Label) -> None:
        if XCAFDoc_ShapeTool.IsReference_s(label):
            target = TDF_Label()
            XCAFDoc_ShapeTool.GetReferredShape_s(label, target)
            walk(target)
        elif XCAFDoc_ShapeTool.IsAssembly_s(label):
            for child in _components(label):
                walk(child)
        else:
            name, properties = TDataStd_Name(), GProp_GProps()
            label.FindAttribute(TDataStd_Name.GetID_s(), name)
            BRepGProp.VolumeProperties_s(XCAFDoc_ShapeTool.GetShape_s(label), properties)
            parts.append((name.Get().ToExtString(), properties.Mass()))

    def _components(label: TDF_Label) -> list[TDF_Label]:
        sequence = TDF_LabelSequence()
        XCAFDoc_ShapeTool.GetComponents_s(label, sequence)
        return [sequence.Value(k) for k in range(1, sequence.Length() + 1)]

    roots = TDF_LabelSequence()
    XCAFDoc_DocumentTool.ShapeTool_s(document.Main()).GetFreeShapes(roots)
    for k in range(1, roots.Length() + 1):
        walk(roots.Value(k))
    return parts


def main() -> int:
    """Exit code 0 if FreeCAD and the CAD library agree on the file in ``sys.argv[1]``, 1 if not."""
    path = Path(sys.argv[1])
    findings = freecad_findings(path)
    found = differences(findings, read_parts(path))
    print(
        f"{path}: FreeCAD {findings['freecad']} reads {findings['solids']} solids, valid {findings['valid']}, "
        f"{findings['volume_mm3']:.6f} mm^3, {len({part['name'] for part in findings['parts']})} part names"
    )
    for line in found:
        print(f"  differs: {line}")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
