"""Searches the gains of a law on the ideal model, and writes a copy of its scenario with them."""

import nhtrack

tuning = nhtrack.tune("tour/hello", budget=128, out="tuned.yaml", overwrite=True)
print(f"cost {tuning.cost_before:.3g} -> {tuning.cost:.3g}")
print(nhtrack.load("tuned.yaml").law)
