"""Answers of earlier interference tests, stored in one cache entry for all designs."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping

from mbcdm_cad.build.pairs import Found
from mbcdm_cad.storage.cache import Cache
from mbcdm_cad.storage.keys import content_key
from mbcdm_cad.storage.manifest import versions

# A design has about a thousand tests; beyond this number the answers that were not used for longest are removed.
MOST_ANSWERS = 30_000
_KEY_DIGITS = 32
# What a test's answer depends on besides the bodies: drawing of the rods, booleans and proofs.
TEST_MODULES = ("mbcdm_cad.build.pairs",)


class KnownTests(Mapping[str, Found]):
    """Answers by the key of the test.

    Almost all tests find no overlap: of these only the keys are stored. If two processes write at the same time, the
    answers of one are lost and are computed again later. ``source`` is the hash of ``TEST_MODULES``.
    """

    def __init__(self, cache: Cache, source: str) -> None:
        self._cache = cache
        self._key = content_key("interference answers", (), source, versions())
        self._found = self._stored()

    def __getitem__(self, key: str) -> Found:
        return self._found[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self._found)

    def __len__(self) -> int:
        return len(self._found)

    def add(self, answers: Mapping[str, Found], used: Iterable[str]) -> None:
        """Add new answers and store all; ``used`` are the keys of this run, which are removed last."""
        self._found |= answers
        if not answers:
            return
        # Answers that other processes stored since this run began are kept too, in the order of the last use.
        latest = {**self._stored(), **self._found}
        for key in used:
            latest[key] = latest.pop(key)
        kept = dict(list(latest.items())[-MOST_ANSWERS:])
        hits = {key: found for key, found in kept.items() if found}
        self._cache.put(self._key, {"keys": "".join(kept).encode(), "found": json.dumps(hits).encode()})

    def _stored(self) -> dict[str, Found]:
        blobs = self._cache.get(self._key)
        if blobs is None:
            return {}
        keys, found = blobs["keys"].decode(), json.loads(blobs["found"])
        every = (keys[start : start + _KEY_DIGITS] for start in range(0, len(keys), _KEY_DIGITS))
        return {key: found.get(key, []) for key in every}
