"""What moves the robots: the ideal integrator and MuJoCo, behind one contract."""
