"""Makes ``paper_case`` and the support modules importable (the suite's importlib mode leaves folders off the path) and
lifts the deadline: the first example of a series test compiles its loops, which takes seconds once and then a
millisecond."""

import sys
from pathlib import Path

from hypothesis import settings

sys.path.insert(0, str(Path(__file__).parent))
settings.register_profile("model", deadline=None)
settings.load_profile("model")
