"""What is found in a recording or in an ideal run: figures, events, demands on wheels and motors."""
