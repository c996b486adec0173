"""What the courier keeps, and the cart; run with `pytest test_my_robot.py`."""

from pathlib import Path

from nhtrack.robots.contract import Hints
from nhtrack.testing import RobotContract


class TestCourier(RobotContract):
    """With its arm as it carries a box."""

    robot = Path(__file__).with_name("courier.xml")
    hints = Hints(pose="carry")


class TestCart(RobotContract):
    """A URDF names no motors."""

    robot = Path(__file__).with_name("cart.urdf")
    hints = Hints(wheels=("left_wheel_joint", "right_wheel_joint"))
