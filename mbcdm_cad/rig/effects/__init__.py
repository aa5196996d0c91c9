"""The effects that an experiment can contain; any number can act together.

Each effect is a block of the experiment file whose field ``effect`` names it. Its method ``apply(bench)`` changes the
bench and adds an entry to the truth.
"""

from __future__ import annotations
