"""Random edits of a file, for the tests of readers."""

import random
from collections.abc import Sequence


def mutate(content: bytes, spice: Sequence[bytes], rng: random.Random) -> bytes:
    """One to eight random edits: flips, cuts, insertions, repeats, swaps of lines, other words, truncation."""
    data = bytearray(content)
    for _ in range(rng.choice((1, 1, 1, 2, 3, 8))):
        at = rng.randrange(len(data) + 1)
        end = min(len(data), at + rng.choice((1, 1, 2, 5, 20, 200)))
        action = rng.randrange(8)
        if action == 0 and at < len(data):
            data[at] = rng.randrange(256)
        elif action == 1:
            del data[at:end]
        elif action == 2:
            data[at:at] = rng.choice(spice)
        elif action == 3:
            data[at:at] = data[at:end] * rng.choice((1, 2, 50))
        elif action == 4:
            lines = bytes(data).split(b"\n")
            i, j = rng.randrange(len(lines)), rng.randrange(len(lines))
            lines[i], lines[j] = lines[j], lines[i]
            data = bytearray(b"\n".join(lines))
        elif action == 5:
            data[at:end] = bytes(rng.randrange(256) for _ in range(end - at))
        elif action == 6:
            old, new = rng.choice(spice), rng.choice(spice)
            data = bytearray(bytes(data).replace(old, new, rng.choice((1, 5, -1))))
        elif action == 7 and rng.random() < 0.2:
            del data[at:]
    return bytes(data)
