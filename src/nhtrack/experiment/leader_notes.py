"""How well the leader's accelerations take it along the path that a scenario gives."""

from nhtrack.config.scenario import Scenario
from nhtrack.experiment.build import instants_of
from nhtrack.references import Motion


def leader_notes(scenario: Scenario) -> tuple[str, ...]:
    """Returns how far the ideal leader is from its path at the ends of control periods; needs a time scale."""
    motion = scenario.leader.input.reference()
    if not isinstance(motion, Motion) or not motion.tracked:
        return ()
    rms, largest, heading = motion.departure(instants_of(scenario))
    length = 1e6 * scenario.similarity.length
    far = f"{length * largest:.3g} µm (rms {length * rms:.3g} µm) and {heading:.2g} rad"
    return (f"{scenario.leader.name}: on the ideal model it is within {far} of its path",)
