"""What all kinds of robots are read with: files, elements, shapes, and the standard form they are written in."""
