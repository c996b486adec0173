"""Studies: scenarios into recordings, figures and tables."""
