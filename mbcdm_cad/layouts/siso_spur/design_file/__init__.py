"""The design file of siso_spur: what the loader needs to read it, and a short file to start from."""

from mbcdm_cad.design.loader import DesignFile, LazySizing
from mbcdm_cad.layouts.siso_spur.design_file.resolve import broken_rules, drive, named_entries
from mbcdm_cad.layouts.siso_spur.design_file.schema import REFERENCE, SpurDesign

# Places in capitals are filled in for each layout with inputs beside the drum.
_TEXT = """\
# Requirements of a cable drive; every other field follows from them by a rule ('mbcdm explain FILE' says how).
# Lengths in mm, angles in degrees. Any field of docs/design-file.md may be given too: it then stays as it is.
name: {name}
configuration: CONFIGURATION
travel:
  half_angle_deg: 35.0      # deg: travel from the centre to each side
transmission:
  input_to_drum: 5.0        # drum radius over input radius: the smaller, the longer the rope lasts; left out: what a
                            # stated motor needs, else that of the lightest drive
  drum_radius_mm: 60.0      # mm: drum pitch radius; left out: as small as the rope allows
  # cables: two_anchored    # two cables with a stop each in the input; left out: one, held there by friction
loads:
  peak_torque_Nm: TORQUE       # N m: torque to hold both ways
  # structure_share: 0.5    # turn of the payload by all other parts over that by the cables, at most; left out: that
                            # where 1 % of mass buys 1 % less turn of the payload
limits:
  losses: counted           # the torque counts what gearheads, cables and bearings lose; paper: no losses
# drive: {{motor: tmotor-u8-100kv}}  # a motor with a shaft of its own needs no gearhead
# rope: {{type: FF-081}}      # left out: the thinnest 7x7 wire rope that holds
# drum: {{material: pla}}     # left out: aluminium; so for support
"""


def starting(configuration: str, torque_Nm: float, more: str = "") -> str:
    """The text with a place for the design's ``name``, ``more`` lines behind it."""
    return _TEXT.replace("CONFIGURATION", configuration).replace("TORQUE", f"{torque_Nm:.1f}") + more


STARTING = starting("siso_spur", 2.0)
DESIGN_FILE = DesignFile(
    SpurDesign,
    REFERENCE.values,
    broken_rules,
    named_entries,
    drive,
    LazySizing("mbcdm_cad.layouts.siso_spur.sizing"),
    STARTING,
)
