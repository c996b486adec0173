"""Where laws and simulations meet: the loop, and what keeps what comes out of it."""
