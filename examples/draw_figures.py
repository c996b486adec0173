"""Draws figures of a run, changes one, and writes them for print."""

import nhtrack

run = nhtrack.run("tour/hello", duration=4)
figures = nhtrack.plot(run, ["trajectories", "errors"])
figures["errors"].axes[0].axhline(0.05, color="0.6", linewidth=0.6)  # Matplotlib's
print([path.name for path in figures.save("figures", pdf=True)])
