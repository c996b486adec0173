"""The same scenario under several laws."""
