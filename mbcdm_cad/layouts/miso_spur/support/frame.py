"""Frame: plate with boss, arms and yokes, milled from one block, with bores from behind for drum and inputs."""

from __future__ import annotations

import cadquery as cq

from mbcdm_cad.layouts.miso_spur.support.dims import StarDims
from mbcdm_cad.layouts.siso_spur.support.frame import centre_bodies, centre_tools, yoke_bodies, yoke_tools
from mbcdm_cad.parts.shapes import cut, fuse

_ORIGIN, _Y = cq.Vector(0.0, 0.0, 0.0), cq.Vector(0.0, 1.0, 0.0)


def create_star(dims: StarDims) -> cq.Solid:
    """Frame in its position in the assembly."""
    bodies, tools = centre_bodies(dims.arms[0]), centre_tools(dims.arms[0])
    for arm, angle in zip(dims.arms, dims.angles_deg, strict=True):
        bodies += [body.rotate(_ORIGIN, _Y, angle) for body in yoke_bodies(arm)]
        tools += [tool.rotate(_ORIGIN, _Y, angle) for tool in yoke_tools(arm)]
    return cut(fuse(bodies, "frame"), tools, "frame")
