"""The checks of this layout: those of siso_spur for each input with its cable and sector, and those of all together."""

from __future__ import annotations

from mbcdm_cad.checks.comparison import families
from mbcdm_cad.layouts.miso_spur.checks import room, sectors, sharing
from mbcdm_cad.layouts.siso_spur.checks import FAMILIES as OF_ONE_INPUT
from mbcdm_cad.layouts.siso_spur.checks import room as room_of_one
from mbcdm_cad.layouts.siso_spur.checks import support, winding

# The checks of several inputs stand before or after those of one: the shares behind the winding, the sectors before
# the support, the room of all in place of the room of one.
_WINDING, _SUPPORT, _ROOM, SHARING, SECTORS, ROOM = families(winding, support, room_of_one, sharing, sectors, room)
_PLACES = {_WINDING: (_WINDING, SHARING), _SUPPORT: (SECTORS, _SUPPORT), _ROOM: (ROOM,)}
FAMILIES = tuple(family for one in OF_ONE_INPUT for family in _PLACES.get(one, (one,)))
