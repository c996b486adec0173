"""Physical effects: what all of them keep to, and that a new one is a single file."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from nhtrack.config.physics import Physics
from nhtrack.effects import effect_kinds, effects_of
from nhtrack.effects.contract import Effect
from nhtrack.ground import Ground
from nhtrack.simulation.robot_models import read_robot
from nhtrack.simulation.scene import make_scene
from nhtrack.simulation.spec import SceneSpec

FLYWHEELS = '''
from dataclasses import dataclass
from typing import ClassVar

from pydantic import Field

from nhtrack.effects.contract import Effect


@dataclass(frozen=True)
class Flywheels(Effect):
    """A flywheel on each wheel."""

    inertia: float

    key: ClassVar = "flywheels"
    field: ClassVar = (float, Field(default=0.0, ge=0, description="inertia of each [kg m^2]"))
    weighs: ClassVar = True

    @classmethod
    def of(cls, value, length):
        return cls(value) if value else None

    def edit_robot(self, robot, parts, model):
        for name in parts.wheel_joints:
            robot.find("joint", name).armature = self.inertia

    def findings(self, setting):
        if setting.plant().wheel_inertia > 1:
            yield (), "they are heavier than the robot"
'''
USE = '''
import json, sys
import nhtrack.effects
nhtrack.effects.__path__.append(sys.argv[1])

from nhtrack.config.documentation import scenario_reference
from nhtrack.errors import ScenarioError
from nhtrack.experiment.build import build
from nhtrack.experiment.load import load
from nhtrack.simulation.scene import make_scene
from nhtrack.simulation.spec import SceneSpec

plain, heavy = (build(load("tour/hello", ["duration=1", f"physics.flywheels={x}"])) for x in (0, 1e-3))
try:
    load("tour/hello", ["physics.flywheels=2"])
except ScenarioError as error:
    told = str(error)
scene = make_scene(heavy.scene, heavy.robot)
print(json.dumps({
    "effects": [len(plain.scene.effects), len(heavy.scene.effects)],
    "inertia": [x.robot.plant.wheel_inertia for x in (plain, heavy)],
    "known": heavy.robot.drive.wheel_inertia,
    "compiled": scene.model.dof_armature[scene.addresses.wheel_qvel].tolist(),
    "kept": SceneSpec.from_json(heavy.scene.to_json()) == heavy.scene,
    "page": "| `flywheels` | number >= 0 |" in scenario_reference(),
    "told": told,
}))
'''


def test_a_scenario_that_says_nothing_of_them_is_without_any() -> None:
    assert effects_of(Physics(), 2.0) == ()
    assert set(effect_kinds()) <= set(Physics.model_fields)


@dataclass(frozen=True)
class Polish(Effect):
    """A floor that has lost half of its friction."""

    def ground(self, ground: Ground) -> Ground:
        """Returns the ground with half of its friction."""
        return replace(ground, friction=ground.friction / 2)


def test_tyres_have_the_friction_of_the_ground_that_effects_make() -> None:
    spec = SceneSpec(robot="nh_mini", robots=("leader", "follower"), friction=0.6, effects=(Polish(),))
    scene = make_scene(spec, read_robot(spec))
    np.testing.assert_array_equal(scene.model.geom_friction[scene.addresses.tyres, 0], 0.3)


@pytest.mark.slow
def test_a_new_one_is_one_file(tmp_path: Path) -> None:
    """Key, page, reduced model, scene, recording's account and check come of a module in the room."""
    (tmp_path / "flywheels.py").write_text(FLYWHEELS)
    done = subprocess.run([sys.executable, "-c", USE, str(tmp_path)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["effects"] == [0, 1]
    plain, heavy = found["inertia"]
    assert heavy > plain + 0.9e-3
    assert found["known"] == plain  # nominal: torques are computed for the robot of its file
    assert all(wheel == 1e-3 for pair in found["compiled"] for wheel in pair)
    assert found["kept"]
    assert found["page"]
    assert "physics.flywheels: they are heavier than the robot" in found["told"]
