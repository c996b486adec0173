"""What moves the robots, as arrays: the ideal integrator and MuJoCo behind one contract."""
