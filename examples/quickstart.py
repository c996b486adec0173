"""Runs a scenario on wheels: how near its follower comes, and how far the wheels are from the ideal robot."""

import numpy as np

import nhtrack

run = nhtrack.run("tour/hello")
error = run["error"].sel(robot="follower")  # xarray, with units
distance = np.hypot(error.sel(pose_component="x"), error.sel(pose_component="y"))
gap = run["pose"] - run["ideal_pose"]
print(f"{float(distance[-1]):.4f} m from the leader, {float(abs(gap[..., :2]).max()):.1e} m from the ideal twin")
