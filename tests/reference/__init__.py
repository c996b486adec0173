"""Laws, physics and loop as arrays: a second, independent implementation that the compiled one is tested against."""
