"""What is done with scenarios, one folder each: command, work, result, figures, report."""
