"""Effects that an experiment may switch on, one small file each; any number act together.

Each is a block of the experiment file with an ``effect`` that names it, and ``apply(bench)``, which changes the bench
and writes what it did into the truth.
"""

from __future__ import annotations
