"""Make a film of a recording."""
