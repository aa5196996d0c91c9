"""``python -m mbcdm_cad`` and the ``mbcdm`` command."""

from __future__ import annotations

from mbcdm_cad.cli import main

if __name__ == "__main__":
    main()
