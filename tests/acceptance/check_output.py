"""Compare the figures of an output folder's report with limits: ``python tests/acceptance/check_output.py FOLDER``.

The limits are stated here as well as in the design file, so that a design file with weaker targets does not pass.
"""

import json
import sys
from pathlib import Path

MASS_G, MASS_TOLERANCE_G = 350.0, 10.0
BOX_MM, BOX_TOLERANCE_MM = (126.0, 97.0, 34.8), 0.5  # X, Z, Y
LEAST_POSES = 9
LEAST_TRAVEL_DEG = 35.0


def faults(report: dict, files: list[str]) -> list[str]:  # type: ignore[type-arg]
    """What is wrong, a sentence each; prints the figures on the way."""
    found = []
    mass = report["mass"]["mass_g"]
    print(f"mass {mass:.2f} g +- {report['mass']['sigma_g']:.2f}, target {MASS_G:g} +- {MASS_TOLERANCE_G:g}")
    if abs(mass - MASS_G) > MASS_TOLERANCE_G:
        found.append(f"mass {mass:.2f} g is outside {MASS_G:g} +- {MASS_TOLERANCE_G:g} g")
    for axis, size, target in zip("XZY", report["envelope"]["size_mm"], BOX_MM, strict=True):
        print(f"box {axis} {size:.3f} mm, target {target:g} +- {BOX_TOLERANCE_MM:g}")
        if abs(size - target) > BOX_TOLERANCE_MM:
            found.append(f"box {axis} {size:.3f} mm is outside {target:g} +- {BOX_TOLERANCE_MM:g} mm")
    poses = report["interference"]["poses_deg"]
    clashes = report["interference"]["clashes"]
    print(f"{len(clashes)} clashes at {len(poses)} poses from {min(poses):g} to {max(poses):g} deg")
    if len(poses) < LEAST_POSES or min(poses) > -LEAST_TRAVEL_DEG or max(poses) < LEAST_TRAVEL_DEG:
        found.append(f"only {len(poses)} poses from {min(poses):g} to {max(poses):g} deg")
    found += [f"clash: {c['first']} and {c['second']} at {c['drum_angle_deg']:g} deg" for c in clashes]
    found += [f"check {name} fails" for name in report["failed_checks"]]
    for part in report["parts"]:
        found += [f"no {part}.{kind}" for kind in ("step", "stl") if f"parts/{part}.{kind}" not in files]
    return found


def main() -> int:
    """0 if all holds."""
    folder = Path(sys.argv[1])
    report = json.loads((folder / "report.json").read_text("utf-8"))
    files = [p.relative_to(folder).as_posix() for p in folder.rglob("*")]
    found = faults(report, files)
    for fault in found:
        print(f"FAULT: {fault}", file=sys.stderr)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
