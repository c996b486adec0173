"""The pages: one module for each command that writes one, and one for what is common to pages with a time slider."""
