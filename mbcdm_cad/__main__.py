"""``python -m mbcdm_cad`` and the ``mbcdm`` command."""

from mbcdm_cad.cli import main

if __name__ == "__main__":
    main()
