"""Asks the ideal run what a scenario would demand of wheels and motors, and how slow it has to be on less friction."""

import nhtrack

print(nhtrack.feasibility("tour/hello").verdict)
icy = nhtrack.feasibility("tour/hello", set={"physics.friction": 0.05})
print(icy.verdict)
run = nhtrack.run("tour/hello", set={"physics.friction": 0.05, "similarity.time": icy.fitting_time}, duration=3)
print(f"friction used: {run.summary['robots']['follower']['peak_utilisation']:.1%}")
