"""Searches the gains of a law on the ideal model, and writes a copy of its scenario with them."""

import nhtrack

tuning = nhtrack.tune("tour/hello", objective="late=1,settling=0.5", budget=32, out="tuned.yaml", overwrite=True)
print(f"cost {tuning.cost_before:.3g} -> {tuning.cost:.3g}")
print(nhtrack.load("tuned.yaml").law)
