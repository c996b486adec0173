"""What a robot is to its controller: reduced models and motors."""
