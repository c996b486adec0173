"""Small robots with the habits and the faults of robots that other people wrote, made from one plain robot."""
