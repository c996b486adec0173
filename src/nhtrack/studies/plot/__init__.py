"""Draw the figures of a recording."""
