"""Search the gains of a law on the ideal model."""
