"""Say what is read from a robot's file."""
