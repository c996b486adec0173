"""Runs the scenario with another gain, and says how near the follower comes."""

from pathlib import Path

import numpy as np

import nhtrack

scenario = nhtrack.load(Path(__file__).with_name("my_scenario.yaml"), ["law.k_x=2"])
run = nhtrack.run(scenario)
error = run["error"].sel(robot="follower")
distance = np.hypot(error.sel(pose_component="x"), error.sel(pose_component="y"))
print(f"{1000 * float(distance[-1]):.2f} mm from the leader at {float(distance.time[-1]):g} s")
