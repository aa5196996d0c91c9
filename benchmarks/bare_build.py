"""The reference of the build's time: a process that imports the CAD library, loads solids and writes the same files.

No checks, no validation, no masses, no measured mesh error, no canonical bytes. speed.py calls it with a folder that
contains ``parts.json`` and one BREP file for each part, and with an output folder.
"""

import json
import sys
from pathlib import Path

import cadquery as cq


def main() -> None:
    source, target = Path(sys.argv[1]), Path(sys.argv[2])
    plan = json.loads((source / "parts.json").read_text())
    linear_mm, angular_rad = plan["linear_mm"], plan["angular_rad"]
    (target / "parts").mkdir(parents=True)
    solids = {name: cq.Shape.importBrep(str(source / f"{name}.brep")) for name in plan["parts"]}
    for name, solid in solids.items():
        part = cq.Assembly(solid, name=name, color=cq.Color(0.5, 0.5, 0.5), material=cq.Material("steel", density=7.85))
        part.export(str(target / "parts" / f"{name}.step"), write_pcurves=False)
        stl = str(target / "parts" / f"{name}.stl")
        solid.exportStl(stl, tolerance=linear_mm, angularTolerance=angular_rad, relative=False)
    assembly = cq.Assembly(name="assembly")
    for item in plan["items"]:
        place = cq.Location(cq.Plane(item["origin"], item["x"], item["z"]))
        assembly.add(solids[item["part"]], name=item["name"], loc=place, color=cq.Color(0.5, 0.5, 0.5))
    assembly.export(str(target / "assembly.step"), write_pcurves=False)
    assembly.export(str(target / "assembly.glb"), tolerance=linear_mm, angularTolerance=angular_rad)


if __name__ == "__main__":
    main()
