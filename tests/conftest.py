"""Hypothesis profiles: `ci` draws the same examples on every machine, `explore` looks for new ones.

`pytest --hypothesis-profile=explore` overrides the default.
"""

import os

# Before numpy is imported: threads for matrices of 4 x 4 only wait for each other, most of all beside other tests.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from hypothesis import HealthCheck, settings

settings.register_profile("ci", derandomize=True, deadline=None, max_examples=100, database=None)
settings.register_profile(
    "explore", deadline=None, max_examples=2000, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("ci")
