"""Runs one scenario under three laws, and says which of them is best at what."""

from pathlib import Path

import nhtrack

laws = ["samson", {"name": "kanayama", "k_x": 2.0}]
comparison = nhtrack.compare("tour/hello", laws, backend="ideal", duration=16)
for law in comparison.standings:
    print(f"{law.label}: {1000 * law.late_position_error:.2g} mm late, RMS u_x {law.effort_x:.2g} m/s^2")

own = Path(__file__).with_name("write_a_law") / "my_law.py"
tuned = nhtrack.compare("tour/hello", own, tune=16, backend="ideal", duration=16)
print(tuned.tunings["my_law"].gains)
