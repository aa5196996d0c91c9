"""How far the drum of a design turns by its own strain, beside its cables, and the stress in its web.

The figures of the analytic model count the drum as rigid; these say what that leaves out.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.model.structure.drum_sector import Isotropic, sector_study
from mbcdm_cad.parts.drum_sector.structure import hub, land_pulls, sector_shape

if TYPE_CHECKING:
    from mbcdm_cad.layouts.sector import SectorLayout
    from mbcdm_cad.model import Analysis


@dataclass(frozen=True)
class DrumStructure:
    """Turn of the drum's cables against its payload face for a torque, by the part that strains, urad per N m.

    ``cables_urad_Nm``: turn of the drum by its cables at the test torque, over that torque. ``peak_stress_MPa``: the
    largest equivalent stress of web and rim at the peak torque of either sense, with the preload; ``yield_MPa``: that
    of the drum's material.
    """

    web_urad_Nm: float
    hub_to_screws_urad_Nm: float
    hub_to_face_urad_Nm: float
    cables_urad_Nm: float
    peak_stress_MPa: float
    yield_MPa: float

    @property
    def drum_urad_Nm(self) -> float:
        """Turn of the whole drum."""
        return self.web_urad_Nm + self.hub_to_screws_urad_Nm + self.hub_to_face_urad_Nm

    @property
    def over_cables(self) -> float:
        """Turn of the drum over that of the cables."""
        return self.drum_urad_Nm / self.cables_urad_Nm

    def to_dict(self) -> dict[str, Any]:
        """Everything, ready for JSON."""
        return asdict(self) | {"drum_urad_Nm": self.drum_urad_Nm, "drum_over_cables": self.over_cables}

    def lines(self, test_torque_Nm: float) -> Iterator[str]:
        """Sentences for the terminal."""
        turned = self.drum_urad_Nm * test_torque_Nm * 1e-3
        yield (
            f"The drum itself, which the figures above count as rigid: {self.drum_urad_Nm:.0f} urad/N m from its "
            f"cables to its payload face ({self.web_urad_Nm:.0f} web and rim, {self.hub_to_screws_urad_Nm:.0f} hub to "
            f"the set screws, {self.hub_to_face_urad_Nm:.0f} hub to the face), {turned:.3f} mrad at "
            f"{test_torque_Nm:g} N m: {self.over_cables:.1f} times the turn by the cables "
            f"({self.cables_urad_Nm:.0f} urad/N m)"
        )
        against = self.peak_stress_MPa / self.yield_MPa
        said = f"{against:.0%} of the yield stress" if against < 1.0 else "above the yield stress"
        yield (
            f"largest stress of web and rim at the peak torque {self.peak_stress_MPa:.0f} MPa, {said} of "
            f"{self.yield_MPa:g} MPa; corners as drawn, without a factor for notches or creep"
        )


def drum_structure(layout: SectorLayout, analysis: Analysis) -> DrumStructure:
    """The drum of one design, under the changes of tension that the model finds at the test torque.

    Raises ``NoFigureError`` without a geometry, ``MbcdmError`` for a drum whose windows leave no metal.
    """
    drive, case = layout.drive, analysis.test[0]
    material = drive.drum.material
    moments = {
        cable.name: abs(tension - cable.preload_N) * cable.drum_radius_mm
        for cable, tension in zip(drive.cables, case.tension_N, strict=True)
    }
    whole = sum(moments.values())
    shares = {name: moment / whole for name, moment in moments.items()}
    preloads = {cable.name: cable.preload_N for cable in drive.cables}
    dims = layout.drum
    names = {terminal.cable_name for terminal in dims.tensioners}
    # Sectors side by side on one shaft are equal, and each carries its own cables' share of the torque.
    own = sum(share for name, share in shares.items() if name in names)
    pulls = land_pulls(dims, {name: shares[name] / own for name in names}, preloads)
    elastic = Isotropic(material.youngs_modulus_GPa * 1e3, material.poisson_ratio)
    try:
        study = sector_study(sector_shape(dims), hub(dims, drive.screw(dims.set_screw).thread_mm), pulls, elastic)
    except ValueError as error:
        raise MbcdmError(str(error)) from None
    torque = drive.loads.peak_torque_Nm * own
    stress = max(float(study.von_mises_MPa(way * torque).max()) for way in (1.0, -1.0))
    return DrumStructure(
        web_urad_Nm=study.web_urad_Nm * own,
        hub_to_screws_urad_Nm=study.hub_to_screws_urad_Nm * own,
        hub_to_face_urad_Nm=study.hub_to_face_urad_Nm * own,
        cables_urad_Nm=abs(case.turn_mrad / case.load_Nm) * 1e3,
        peak_stress_MPa=stress,
        yield_MPa=material.yield_MPa,
    )
