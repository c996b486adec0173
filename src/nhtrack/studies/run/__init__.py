"""Run a scenario: recording, summary, figures, film and report in a folder."""
