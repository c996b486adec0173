"""The habits, by what they are about; `HABITS` has them by name."""

from odd_robots import bodies, files, motors, wheels  # noqa: F401 - they enter their habits
from odd_robots.habit import HABITS, Habit, expected

__all__ = ["HABITS", "Habit", "expected"]
