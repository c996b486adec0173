"""Files and results folders that are whole or not there."""
