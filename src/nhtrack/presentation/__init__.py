"""What figures, films and pages agree on."""
