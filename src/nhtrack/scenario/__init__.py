"""Scenario files: their schema, their faults, and the objects they become."""
