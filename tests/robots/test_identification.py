"""Reading a robot from its MJCF: every number, and a message that names what was found for every fault."""

import re

import mujoco
import numpy as np
import pytest

from nhtrack.errors import RobotError
from nhtrack.robots.diff_drive import identify
from nhtrack.robots.diff_drive.identification import identify_parts
from tolerances import HAND

CART = """
<mujoco model="cart">
  <custom>
    <numeric name="motor_stall_torque" data="2"/>
    <numeric name="motor_no_load_speed" data="10"/>
  </custom>
  <worldbody>
    <body name="chassis">
      <freejoint name="root"/>
      <geom name="plate" type="box" size=".1 .08 .01" pos="-.02 .01 0" mass="2" contype="0" conaffinity="0"/>
      <geom name="caster" type="sphere" size=".02" pos="-.1 0 -.03" mass="0" condim="1"/>
      <geom name="bumper" type="capsule" size=".005 .05" pos=".1 0 .01" mass="0"/>
      <body name="left_wheel" pos="0 .1 0">
        <inertial mass=".1" pos="0 0 0" diaginertia="1e-4 2e-4 1e-4"/>
        <joint name="left_axle" axis="0 1 0"/>
        <geom name="left_tyre" type="sphere" size=".05"/>
      </body>
      <body name="right_wheel" pos="0 -.1 0">
        <inertial mass=".1" pos="0 0 0" diaginertia="1e-4 2e-4 1e-4"/>
        <joint name="right_axle" axis="0 1 0"/>
        <geom name="right_tyre" type="sphere" size=".05"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <motor name="left_motor" joint="left_axle" gear="2" ctrllimited="true" ctrlrange="-.5 .5"/>
    <motor name="right_motor" joint="right_axle" gear="2" ctrllimited="true" ctrlrange="-.5 .5"/>
  </actuator>
</mujoco>
"""


def cart(*changes: tuple[str, str]) -> mujoco.MjModel:
    """Returns the compiled cart with pieces of its MJCF replaced; each piece must occur exactly once."""
    text = CART
    for old, new in changes:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    return mujoco.MjModel.from_xml_string(text)


class TestNumbers:
    def test_every_number_of_the_cart(self) -> None:
        drive = identify(cart())
        assert drive.wheel_radius == pytest.approx(0.05, rel=HAND)
        assert drive.half_separation == pytest.approx(0.1, rel=HAND)
        assert drive.mass == pytest.approx(2.2, rel=HAND)
        assert drive.wheel_inertia == pytest.approx(2e-4, rel=HAND)
        # Plate m (a^2 + b^2)/12 + m d^2, wheels across their axle and 0.1 m from it.
        plate = 2 * (0.2**2 + 0.16**2) / 12 + 2 * (0.02**2 + 0.01**2)
        assert drive.axle_inertia == pytest.approx(plate + 2 * (1e-4 + 0.1 * 0.1**2), rel=HAND)
        assert drive.com == pytest.approx((-0.04 / 2.2, 0.02 / 2.2, 0.05), rel=HAND)
        np.testing.assert_allclose(drive.casters, [(-0.1, 0.0)], rtol=HAND)

    def test_the_motors_limit_is_at_the_wheel(self) -> None:
        motor = identify(cart()).motor
        assert (motor.torque_limit, motor.stall_torque, motor.no_load_speed) == pytest.approx((1, 2, 10), rel=HAND)

    def test_the_parts_by_name(self) -> None:
        parts = identify_parts(cart())
        assert parts.chassis == "chassis"
        assert parts.wheel_joints == ("left_axle", "right_axle")
        assert parts.motors == ("left_motor", "right_motor")
        assert parts.tyres == ("left_tyre", "right_tyre")
        assert parts.casters == ("caster",)
        assert set(parts.collision_geoms) == {"caster", "bumper", "left_tyre", "right_tyre"}

    def test_a_robot_placed_anywhere_reads_the_same(self) -> None:
        placed = cart(('<body name="chassis">', '<body name="chassis" pos="3 -2 1" euler="0 0 140">'))
        here, there = identify(cart()), identify(placed)
        # Positions a few metres off cost a few digits of the differences.
        assert there.com == pytest.approx(here.com, rel=1e3 * HAND)
        assert there.axle_inertia == pytest.approx(here.axle_inertia, rel=1e3 * HAND)
        assert there.half_separation == pytest.approx(here.half_separation, rel=1e3 * HAND)

    @pytest.mark.parametrize("swap", ["bodies", "motors"])
    def test_wheels_are_left_then_right_in_whatever_order_they_are_listed(self, swap: str) -> None:
        if swap == "motors":
            left, right = re.findall(r"<motor .*/>", CART)
            text = CART.replace(left, "@").replace(right, left).replace("@", right)
        else:
            left, right = re.findall(r'<body name="\w+_wheel".*?</body>', CART, re.DOTALL)
            text = CART.replace(left, "@").replace(right, left).replace("@", right)
        model = mujoco.MjModel.from_xml_string(text)
        assert text != CART
        assert identify_parts(model).tyres == ("left_tyre", "right_tyre")
        assert identify_parts(model).motors == ("left_motor", "right_motor")
        assert identify(model).half_separation > 0

    def test_armature_counts_as_spin_of_the_wheels(self) -> None:
        axles = [(f'<joint name="{side}_axle"', f'<joint name="{side}_axle" armature="3e-4"') for side in SIDES]
        assert identify(cart(*axles)).wheel_inertia == pytest.approx(5e-4, rel=HAND)


SIDES = ("left", "right")
LEFT_TYRE = '<geom name="left_tyre" type="sphere" size=".05"/>'
CASTER = '<geom name="caster" type="sphere" size=".02" pos="-.1 0 -.03" mass="0" condim="1"/>'
RIGHT_MOTOR = '<motor name="right_motor" joint="right_axle" gear="2" ctrllimited="true" ctrlrange="-.5 .5"/>'
LEFT_MOTOR = RIGHT_MOTOR.replace("right", "left")
ARM = '<body name="arm" pos="0 0 .1"><inertial mass=".1" pos="0 0 0" diaginertia="1e-4 1e-4 1e-4"/>{}</body>'

FAULTS = {
    "no free joint": (
        [('<freejoint name="root"/>', "")],
        "expected one body with a free joint, the chassis; found 0",
    ),
    "two free joints": (
        [("<worldbody>", "<worldbody>" + ARM.format("<freejoint/>"))],
        "expected one body with a free joint, the chassis; found 2",
    ),
    "three motors": (
        [
            (CASTER, CASTER + ARM.format('<joint name="third" axis="0 1 0"/>')),
            (RIGHT_MOTOR, RIGHT_MOTOR + '<motor name="third_motor" joint="third"/>'),
        ],
        "found 3 among the actuators: left_motor, right_motor, third_motor",
    ),
    "one wheel": ([(RIGHT_MOTOR, "")], "found 1 among the actuators: left_motor"),
    "no actuators": ([(LEFT_MOTOR, ""), (RIGHT_MOTOR, "")], "found 0 among the actuators: none"),
    "unnamed position actuators": (
        [(motor, f'<position joint="{side}_axle"/>') for side, motor in (("left", LEFT_MOTOR), ("right", RIGHT_MOTOR))],
        "expected two driven wheels (torque motors on hinge joints with axis 0 1 0), "
        "found 0 among the actuators: #0, #1",
    ),
    "velocity actuators": (
        [
            (motor, f'<velocity name="{side}" joint="{side}_axle"/>')
            for side, motor in (("left", LEFT_MOTOR), ("right", RIGHT_MOTOR))
        ],
        "found 0 among the actuators: left, right",
    ),
    "an axle along x": (
        [('<joint name="left_axle" axis="0 1 0"/>', '<joint name="left_axle" axis="1 0 0"/>')],
        "found 1 among the actuators: left_motor, right_motor",
    ),
    "a cylinder for a tyre": (
        [(LEFT_TYRE, '<geom name="left_tyre" type="cylinder" size=".05 .01" euler="90 0 0"/>')],
        "wheel 'left_wheel': its collision geom is a cylinder, which touches the floor in more than one",
    ),
    "torsional friction": (
        [(LEFT_TYRE, LEFT_TYRE.replace("/>", ' condim="4"/>'))],
        "wheel 'left_wheel': expected condim 3 (sliding friction only), got 4",
    ),
    "a wheel of air": (
        [(LEFT_TYRE, LEFT_TYRE.replace("/>", ' contype="0" conaffinity="0"/>'))],
        "wheel 'left_wheel': expected one collision geom, found 0",
    ),
    "a twin tyre": (
        [(LEFT_TYRE, LEFT_TYRE + LEFT_TYRE.replace("left_tyre", "spare"))],
        "wheel 'left_wheel': expected one collision geom, found 2",
    ),
    "unequal radii": (
        [
            (LEFT_TYRE, LEFT_TYRE.replace(".05", ".045")),
            ('size=".02" pos="-.1 0 -.03"', 'size=".02" pos="-.1 0 -.025"'),
        ],
        "the wheels' radii differ: 0.045 m and 0.05 m",
    ),
    "an origin off the axle": (
        [('pos="0 .1 0"', 'pos=".01 .1 0"'), ('pos="0 -.1 0"', 'pos=".01 -.1 0"')],
        "the chassis' origin must be the axle midpoint, with the axle along y; it is at (0.01, 0, 0) m",
    ),
    "an oblique axle": (
        [('pos="0 .1 0"', 'pos=".01 .1 0"'), ('pos="0 -.1 0"', 'pos="-.01 -.1 0"')],
        "the chassis' origin must be the axle midpoint, with the axle along y",
    ),
    "wheels of unequal spin": (
        [('<joint name="left_axle"', '<joint name="left_axle" armature="1e-4"')],
        "the wheels' spin inertias differ: 0.0003 and 0.0002 kg m^2",
    ),
    "no caster": ([(CASTER, "")], "no caster: expected a sphere among the chassis' collision geoms"),
    "a caster in the air": ([("-.1 0 -.03", "-.1 0 -.02")], "no caster: expected a sphere"),
    "a caster of cheese": (
        [(CASTER, CASTER.replace('type="sphere" size=".02"', 'type="box" size=".02 .02 .02"'))],
        "no caster: expected a sphere",
    ),
    "a tyre without a name": (
        [('name="left_tyre" ', "")],
        "a geom the robot drives or stands on has no name",
    ),
    "a chassis without a name": (
        [('<body name="chassis">', "<body>")],
        "a body the robot drives or stands on has no name",
    ),
    "no torque limit": (
        [(LEFT_MOTOR, '<motor name="left_motor" joint="left_axle" gear="2"/>')],
        "motor 'left_motor': expected a ctrlrange, the torque its driver allows",
    ),
    "unequal torque limits": (
        [(LEFT_MOTOR, LEFT_MOTOR.replace(".5", ".4"))],
        "the motors' torque limits must be equal and positive, got 0.8 and 1 N m",
    ),
    "no stall torque": (
        [('<numeric name="motor_stall_torque" data="2"/>', "")],
        'expected <custom><numeric name="motor_stall_torque" data="..."/></custom>, the motor\'s datasheet',
    ),
    "no no-load speed": (
        [('<numeric name="motor_no_load_speed" data="10"/>', "")],
        'expected <custom><numeric name="motor_no_load_speed"',
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_what_cannot_be_driven_is_refused_by_name(fault: str) -> None:
    changes, message = FAULTS[fault]
    with pytest.raises(RobotError, match=re.escape(message)):
        identify(cart(*changes))
