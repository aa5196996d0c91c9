"""URDF and MJCF files of a mechanism, with meshes in metres. Frames and joints: docs/robot-formats.md.

The same mechanism gives the same bytes.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mbcdm_cad.robot.elastic import ElasticDrive
from mbcdm_cad.robot.mechanism import MM, Link, Mechanism, document
from mbcdm_cad.robot.mjcf import mjcf
from mbcdm_cad.robot.urdf import UrdfOptions, urdf_files
from mbcdm_cad.workshop.export.stl import stl_bytes

FORMATS = ("urdf", "mjcf")


def robot_files(
    mechanism: Mechanism, form: str, *, elastic: ElasticDrive | None = None, options: UrdfOptions | None = None
) -> dict[str, bytes]:
    """All files of an export by path in its folder: the description and ``meshes/<link>.stl``.

    ``elastic`` (MJCF only): cables, parts and motors between inputs and drum instead of a rigid ratio; ``options``
    (URDF only). Raises ``ValueError`` for an unknown ``form``, or one that has not what is asked.
    """
    if form not in FORMATS or (elastic and form != "mjcf") or (options and form != "urdf"):
        raise ValueError(f"no such form: {form}{', elastic' if elastic else ''}; there are {', '.join(FORMATS)}")
    meshes = {f"meshes/{link.name}.stl": _stl(link) for link in (mechanism.base, *mechanism.links)}
    if form == "urdf":
        return {**urdf_files(mechanism, options or UrdfOptions()), **meshes}
    return {f"{mechanism.name}.xml": document(mjcf(mechanism, elastic), mechanism.note), **meshes}


def _stl(link: Link) -> bytes:
    """The link's mesh in metres, in the link's frame."""
    points = link.mesh.points_mm * MM - np.array(link.origin)
    return stl_bytes(link.name, replace(link.mesh, points_mm=points))
