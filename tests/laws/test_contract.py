"""Every law of the package, and the one to start from, keep the contract and what they claim."""

from __future__ import annotations

from pathlib import Path

from nhtrack.laws import Limits, law_in, law_named
from nhtrack.testing import LawContract

ROOT = Path(__file__).parents[2]
LIMITS = Limits(speed=1.5, yaw_rate=2.0, acceleration=3.0, yaw_acceleration=4.0)


class TestPublished(LawContract):
    law = law_named("published")(kp=11.0, kd=25.1, ke=6.0, k=3.2)


class TestFull(LawContract):
    law = law_named("published")(kp=11.0, kd=25.1, ke=6.0, k=3.2, variant=1)


class TestStabiliser(LawContract):
    law = law_named("stabiliser")(kp=4.0, kd=5.0, k=6.0)


class TestUniversal(LawContract):
    law = law_named("universal")()


class TestLimitedUniversal(LawContract):
    law = law_named("universal")(limits=LIMITS)


class TestAgile(LawContract):
    law = law_named("agile")()


class TestLimitedAgile(LawContract):
    law = law_named("agile")(limits=LIMITS)


class TestKanayama(LawContract):
    law = law_named("kanayama")()


class TestSamson(LawContract):
    law = law_named("samson")()


class TestJiangNijmeijer(LawContract):
    law = law_named("jiang_nijmeijer")()


class TestFeedbackLinearisation(LawContract):
    law = law_named("feedback_linearisation")()


class TestLookAhead(LawContract):
    law = law_named("look_ahead")()


class TestPanteley(LawContract):
    law = law_named("panteley")()


class TestVfo(LawContract):
    law = law_named("vfo")()


class TestGuidingField(LawContract):
    law = law_named("guiding_field")()


class TestPolarBackstepping(LawContract):
    law = law_named("polar_backstepping")()


class TestLawToStartFrom(LawContract):
    law = law_in(ROOT / "examples/write_a_law/my_law.py")(k_x=2.0)


class TestLimitedLawToStartFrom(LawContract):
    law = law_in(ROOT / "examples/write_a_law/my_law.py")(limits=LIMITS)
