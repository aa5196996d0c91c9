"""The design file of miso_bevel: what the loader needs to read it, and a short file to start from."""

from mbcdm_cad.design.loader import DesignFile, LazySizing
from mbcdm_cad.layouts.miso_bevel.design_file.resolve import broken_rules, drive, named_entries
from mbcdm_cad.layouts.miso_bevel.design_file.schema import REFERENCE, BevelDesign

STARTING = """\
# Requirements of a cable drive; every other field follows from them by a rule ('mbcdm explain FILE' says how).
# Lengths in mm, angles in degrees. Any field of docs/design-file.md may be given too: it then stays as it is.
name: {name}
configuration: miso_bevel
travel:
  half_angle_deg: 35.0      # deg: travel from the centre to each side
transmission:
  ratio: 6.2                # drum radius over input radius: the smaller, the longer the rope lasts
  drum_radius_mm: 54.0      # mm: drum pitch radius of step 1; three more steps follow
  # centre_distance_mm: 34.6  # mm: input pulley axis to guide axis; left out: as short as the fleet angle allows
loads:
  peak_torque_Nm: 3.15      # N m: torque to hold both ways
  # structure_share: 0.5    # turn of the payload by all other parts over that by the cables, at most; left out: that
                            # where 1 % of mass buys 1 % less turn of the payload
limits:
  losses: counted           # the torque counts what gearheads, cables and bearings lose; paper: no losses
# rope: {{type: FF-081}}      # left out: the thinnest 7x7 wire rope that holds
# drum: {{material: pa12}}    # left out: aluminium; so for guide and support
"""


DESIGN_FILE = DesignFile(
    BevelDesign,
    REFERENCE.values,
    broken_rules,
    named_entries,
    drive,
    LazySizing("mbcdm_cad.layouts.miso_bevel.sizing"),
    STARTING,
)
