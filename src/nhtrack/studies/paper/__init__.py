"""The paper's examples run again, with their figures."""
