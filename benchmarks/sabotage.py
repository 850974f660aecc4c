#!/usr/bin/env python3
"""Physical sabotage of one robot on full dynamics: which faults a verdict finds, and what it says.

    python3 benchmarks/sabotage.py                 # all faults, on a march and on the paper's line
    python3 benchmarks/sabotage.py "slow wheel"    # one of them

Robot 3 gets a fault of its wheels, its floor or its surroundings from ``BEGIN`` on; law and commands stay
right.  Each run is to fail; where one does not, the table says what bounds it.  Exits with 1 where a fault
that ``BOUNDED`` does not explain goes unnoticed, or where a sound team fails.
"""

import argparse
import os
import sys
import tempfile

import numpy as np
import pybullet

from mrs_simulator import load_scenario, run_experiment
from mrs_simulator.world.motion import wheeled
from mrs_simulator.world.motion.dynamic import DynamicMotion

SCENARIOS = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "scenarios")
RUNS = {"marching": 30.0, "paper_dynamic": 60.0}  # [s]
ROBOT, BEGIN, LATE = 2, 2.0, 0.4  # row; [s]; [s]
BOUNDED = {  # what goes unnoticed, and why
    (
        "creeping",
        "marching",
    ): "at even speed a bias of 3 cm/s and a gain within the spread look alike",
    ("dead band", "marching"): "no wheel is commanded to less than the dead band",
}


class Sabotaged(DynamicMotion):
    """Full dynamics with a fault in robot ``ROBOT``."""

    wheels = force = part = None  # see FAULTS

    def _begin(self, poses):
        """Put the robots at rest at ``poses``; the fault begins anew."""
        self._now, self._past = 0.0, []
        super()._begin(poses)
        if self.part:
            self.part()

    def _drive(self, speeds):
        self._now += self.step
        self._past.append(speeds.copy())
        if self.wheels and self._now > BEGIN:
            speeds = speeds.copy()
            speeds[ROBOT] = self.wheels(speeds[ROBOT])
        super()._drive(speeds)

    def _before_substep(self):
        super()._before_substep()
        if not self.force or self._now <= BEGIN:
            return
        body, client = self._bodies[ROBOT], self._client
        place, _ = pybullet.getBasePositionAndOrientation(body, client)
        velocity, _ = pybullet.getBaseVelocity(body, client)
        force = [*self.force(np.array(velocity[:2])), 0.0]
        pybullet.applyExternalForce(body, -1, force, place, pybullet.WORLD_FRAME, client)

    def rub(self, links, friction):
        """Give the ``links`` of the robot, wheels or the others, this ``friction`` [-]."""
        body, wheels = self._bodies[ROBOT], self._wheels[ROBOT]
        for link in range(-1, pybullet.getNumJoints(body, self._client)):
            if (link in wheels) == (links == "wheels"):
                pybullet.changeDynamics(
                    body, link, lateralFriction=friction, physicsClientId=self._client
                )

    def late(self, speeds):
        """Return the speeds of ``LATE`` before."""
        return self._past[max(0, len(self._past) - 1 - int(LATE / self.step))][ROBOT]

    def weaken(self):
        """Leave the motors a hundredth of their torque."""
        self._torques[ROBOT] = [0.01 * torque for torque in self._torques[ROBOT]]


RIM = 1.0 / 0.09  # [rad/s] of a wheel for 1 m/s, of a Pioneer

FAULTS = {
    "slow wheel": {"wheels": lambda self, speeds: speeds * [0.9, 1.0]},
    "slow robot": {"wheels": lambda self, speeds: 0.9 * speeds},
    "fast wheel": {"wheels": lambda self, speeds: speeds * [1.0, 1.1]},
    "dead": {"wheels": lambda self, speeds: 0.0 * speeds},
    "stuck wheel": {"wheels": lambda self, speeds: speeds * [1.0, 0.0]},
    "reversed wheel": {"wheels": lambda self, speeds: speeds * [-1.0, 1.0]},
    "creeping": {"wheels": lambda self, speeds: speeds + 0.03 * RIM},
    "dead band": {"wheels": lambda self, speeds: np.where(abs(speeds) > 0.1 * RIM, speeds, 0.0)},
    "delay": {"wheels": lambda self, speeds: self.late(speeds)},
    "drag": {"force": lambda self, velocity: -400.0 * velocity},
    "push": {"force": lambda self, velocity: np.array([0.0, 60.0])},
    "stuck castor": {"part": lambda self: self.rub("others", 0.9)},
    "slippery floor": {"part": lambda self: self.rub("wheels", 0.05)},
    "weak motors": {"part": lambda self: self.weaken()},
}


def scenario_of(name, duration=None):
    """Return the scenario of a run on full dynamics."""
    scenario = load_scenario(os.path.join(SCENARIOS, name + ".yaml"))
    return scenario.changed(fidelity="dynamic", duration=duration or scenario.duration)


def verdict_of(scenario, fault=None):
    """Return the verdict on a run in which robot 3 has the ``fault`` of this name, None for none."""
    found = wheeled.MOTIONS["pybullet"]
    wheeled.MOTIONS["pybullet"] = type("Faulty", (Sabotaged,), FAULTS[fault] if fault else {})
    try:
        with tempfile.TemporaryDirectory() as out:
            return run_experiment(scenario, out, formats=())
    finally:
        wheeled.MOTIONS["pybullet"] = found


def line(fault, name, verdict):
    """Return a row of the table: what failed, or what was found."""
    failed = [check for check in verdict["checks"] if check["passed"] is False]
    said = [
        "{} {:.3g} ({})".format(c["name"], c["measured"] or 0.0, c["note"]) for c in failed[-2:]
    ]
    more = "; ".join(said) or BOUNDED.get((fault, name), "")
    row = "| {} | {} | {} | {} | {} |"
    return row.format(fault or "none", name, verdict["outcome"], len(failed), more)


def main():
    """Run the campaign, and print its table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("faults", nargs="*", help=", ".join(FAULTS))
    faults, wrong = parser.parse_args().faults or list(FAULTS), 0
    print("| fault | run | outcome | failed | of which |\n|---|---|---|---|---|")
    for fault in [None, *faults]:
        for name, duration in RUNS.items():
            verdict = verdict_of(scenario_of(name, duration), fault)
            print(line(fault, name, verdict), flush=True)
            unnoticed = verdict["outcome"] != "failed"
            wrong += unnoticed is (fault is not None) and (fault, name) not in BOUNDED
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
