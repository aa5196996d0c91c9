"""Dimensions of bought parts that no catalogue entry holds."""

from __future__ import annotations

# Width across the ring encoder's two flats over its diameter.
RING_ENCODER_FLATS = 22.0 / 24.0
