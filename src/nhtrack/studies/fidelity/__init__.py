"""How close wheels come to the ideal robot: measurements with budgets, for every robot (docs/fidelity.md).

A check is a function from a `Bench`, a robot with what it takes to simulate it, to findings: a figure, its budget and
what it is made of. Budgets stand beside the checks that measure them.
"""
