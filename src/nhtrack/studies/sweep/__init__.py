"""One scenario run many times, with other values of some of its keys."""
