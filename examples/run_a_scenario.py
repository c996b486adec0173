"""Runs a scenario with changes, and once more into a folder with all that `nhtrack run` writes."""

import nhtrack

slower = {"similarity.time": 2, "physics.friction": 0.6}
scenario = nhtrack.load("tour/hello", law={"name": "kanayama", "k_x": 1.5}, duration=6, set=slower)
run = nhtrack.run(scenario, robot="pioneer")
print(f"friction used: {run.summary['robots']['follower']['peak_utilisation']:.1%}")
for warning in run.warnings:
    print(warning)

saved = nhtrack.run(scenario, out="runs/pioneer", robot="pioneer", video=False, report=False)
again = nhtrack.Recording.load(saved.folder / "recording.nc")
print(f"the same run: {bool((again['pose'] == run['pose']).all())}")

try:
    nhtrack.run("tour/hello", set={"law.kp": "much"})
except nhtrack.ScenarioError as error:
    print(error)
