"""What a motion asks of wheels and motors, and the time scale that fits."""
