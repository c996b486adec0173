"""What the law claims; run with `pytest test_my_law.py`."""

from pathlib import Path

from nhtrack.laws import law_in
from nhtrack.testing import LawContract


class TestMyLaw(LawContract):
    """Every claim holds: it looks at nothing but how follower and leader are to each other."""

    law = law_in(Path(__file__).with_name("my_law.py"))(k_x=2.0)
