"""What a scenario file says: its schema, how it is read, checked, explained and edited. Knows no simulation."""
