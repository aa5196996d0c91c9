"""Run inside FreeCAD (see freecad.py in this folder): open the STEP file named in CHECKED_FILE and print the findings.

The last line printed is JSON: number of solids, validity, volume and names, as FreeCAD has them after its import.
"""

import json
import os
import sys
import traceback

import FreeCAD
import Import
import Part


def report(path):
    # Without this, FreeCAD numbers equal labels: the second "screw" would come in as "screw001".
    FreeCAD.ParamGet("User parameter:BaseApp/Preferences/Document").SetBool("DuplicateLabels", True)
    document = FreeCAD.newDocument("check")
    # With other arguments FreeCAD 0.20 crashes on two parts or more.
    Import.insert(path, document.Name, merge=False, useLinkGroup=False)
    bodies = [thing for thing in document.Objects if thing.isDerivedFrom("Part::Feature")]
    whole = Part.Shape()
    whole.read(path)
    return {
        "freecad": ".".join(FreeCAD.Version()[:2]),
        "solids": len(whole.Solids),
        "valid": whole.isValid(),
        "volume_mm3": whole.Volume,
        "assemblies": sorted(thing.Label for thing in document.Objects if thing.TypeId == "App::Part"),
        "parts": [
            {
                "name": body.Label,
                "solids": len(body.Shape.Solids),
                "valid": body.Shape.isValid(),
                "volume_mm3": body.Shape.Volume,
            }
            for body in bodies
        ],
    }


try:
    print("\n" + json.dumps(report(os.environ["CHECKED_FILE"])))
except Exception:
    traceback.print_exc()
sys.stdout.flush()
sys.stderr.flush()
os._exit(0)  # FreeCAD 0.20 does not end by itself after a script
