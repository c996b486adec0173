"""Hypothesis profiles: `ci` draws the same examples on every machine, `explore` looks for new ones.

`pytest --hypothesis-profile=explore` overrides the default.
"""

from hypothesis import HealthCheck, settings

settings.register_profile("ci", derandomize=True, deadline=None, max_examples=100, database=None)
settings.register_profile(
    "explore", deadline=None, max_examples=2000, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("ci")
