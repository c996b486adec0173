"""Campaigns: laws against references from many random starts, what became of each, and how often they arrive.

`draw` makes starts and random references, `cell` turns a law and a family into simulations, `figures` says what is
asked of them, `tables` sums the answers up, `run` plans the work, does it in processes and goes on where it was left.
"""
