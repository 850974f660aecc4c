"""A chain behind a leader that sways: string stability with delay."""

import math

import numpy as np

from mrs_simulator.core.claims import Claim, Condition, TooShort
from mrs_simulator.core.fields import POSITIVE, Parameter
from mrs_simulator.core.kinematics import phase_of
from mrs_simulator.protocols.common import attracting, below
from mrs_simulator.protocols.consensus.law import GAIN
from mrs_simulator.protocols.consensus.memory import TAU, Remembering
from mrs_simulator.protocols.curves import Curve
from mrs_simulator.protocols.marching.published import Chain
from mrs_simulator.protocols.marching.string_equations import (
    held_link,
    held_link_gain,
    phasors,
    worst_frequency,
)

WHOLE = 4  # [-] periods of the leader over which amplitudes are measured
SETTLING = 8.0  # [-] time constants of a link, for each link, after which the start is forgotten
LATE = 0.5  # [-] of tau by which a delay slows a link
AMPLIFIED = "amplification from robot to robot [-]"
LATER = "phase from robot to robot [rad]"
LED = "sway of the leader over its amplitude [-]"
TOLERANCE = {"point_mass": 1e-3, "kinematic": 0.02, "dynamic": 0.1}  # [-]


class Platoon(Remembering):
    """``u_i = gain (e_(i+1) - e_i)``, late by tau, behind a leader that sways: Seiler and others, 2004.

    Robot n leads: it sways along x by ``amplitude sin(frequency t)``.  Each other robot keeps the offset
    that it starts with from the next; ``e_i`` is how far robot i is from its start.

    Theorem: the sway grows from robot to robot by ``max |G|``, ``G = gain e^(-s tau)/(s + gain e^(-s
    tau))``, which is at most 1 at all frequencies if and only if ``2 gain tau <= 1``, and turns by the
    phase of G. Where only the neighbour's state is late, it never exceeds 1.
    """

    PARAMETERS = (
        GAIN._replace(default=1.0),
        TAU._replace(default=0.4, meaning="age of what is delayed, in whole command periods"),
        Parameter(
            "delayed",
            "difference",
            choices=("difference", "state"),
            meaning="what is late: the difference, or the next robot's state alone",
        ),
        Parameter("amplitude", 0.3, "m", low=0.0, high=10.0, meaning="of the leader"),
        Parameter("frequency", 1.0, "rad/s", **POSITIVE, high=100.0, meaning="of the leader"),
    )

    def published(self):
        steps, both = int(round(self.tau / self.period)), self.delayed == "difference"

        def sway(time):
            return self.amplitude * math.sin(self.frequency * time)

        return Chain(self.gain, steps, both, sway, self.period)

    @property
    def delay_steps(self):
        """Return tau in command periods."""
        return int(round(self.tau / self.period))

    def begin(self, hand):
        """Remember where the robots began, and that they stood there."""
        self._begun, self._first = self.time, np.array(hand)
        self._history = []

    def law(self, hand):
        errors = hand - self._first
        self._history = (self._history + [errors])[-self.delay_steps - 1 :]
        full = len(self._history) > self.delay_steps
        late = self._history[0] if full else np.zeros_like(errors)
        own = late if self.delayed == "difference" else errors
        u = np.zeros_like(hand)
        u[:-1] = self.gain * (late[1:] - own[:-1])
        now, then = (self._sway(self.time - self._begun + dt) for dt in (0.0, self.period))
        u[-1, 0] = (then - now) / self.period
        return u

    def _sway(self, time):
        return self.amplitude * np.sin(self.frequency * np.asarray(time))

    def claims(self, start):
        """Return by how much each robot passes on the leader's sway, above or below 1, and how late."""
        conditions = [
            Condition("two robots", len(start) > 1, "none follows"),
            attracting(self.gain),
        ]
        late = self.delay_steps if self.delayed == "difference" else 0
        # Levin and May, 1976: gain tau < pi/2 as Tc -> 0
        most = 2.0 * np.sin(0.5 * np.pi / (2 * late + 1))
        name = "gain Tc < 2 sin(pi/(4 tau/Tc + 2))" if late else "gain Tc < 2"
        conditions.append(below(name, self.gain * self.period, most, necessary=True))
        if not all(condition.holds for condition in conditions) or self.amplitude == 0.0:
            return conditions
        links = len(start) - 1
        held, tolerance = self._held(), TOLERANCE[self.fidelity]
        phase = float(phase_of(held))

        def passed_on(run):
            found = np.abs(self._measured(run))
            return float((found[0] / found[-1]) ** (1.0 / links))

        def turned(run):
            found = self._measured(run)
            return phase + float(np.mean(phase_of(found[:-1] / found[1:] * np.exp(-1j * phase))))

        def led(run):
            return float(np.abs(self._measured(run)[-1])) / self.amplitude

        return [
            *conditions,
            Claim(AMPLIFIED, float(np.abs(held)), tolerance, passed_on, free=True),
            Claim(LATER, phase, tolerance, turned, free=True),
            Claim(LED, 1.0, tolerance, led, free=True),
        ]

    def _held(self):
        """Return G of one robot at the leader's frequency, complex."""
        args = self.frequency, self.gain, self.period, self.delay_steps, self.delayed
        return held_link(*args)

    def _measured(self, run):
        """Return the sways (n,) complex [m] over the last whole periods of the leader."""
        time = run.time - run.time[0]
        begin = time[-1] - WHOLE * 2.0 * np.pi / self.frequency
        constant = 1.0 / self.gain + LATE * self.tau
        wanted = SETTLING * constant + (len(run.robots) - 1) * (constant + self.tau)
        if begin < wanted:
            text = "the run is too short for amplitudes: wanted {:.0f} s"
            raise TooShort(text.format(wanted + time[-1] - begin))
        late = time >= begin
        return phasors(time[late], run.hand[late, :, 0] - run.hand[0, :, 0], self.frequency)

    def measures(self, run):
        """Return ``string_margin``, ``1 - 2 gain tau``, and the worst frequency's amplification."""
        omega, worst = worst_frequency(self.gain, self.tau, self.delayed)
        margin = 1.0 - 2.0 * self.gain * self.tau if self.delayed == "difference" else 1.0
        return {"string_margin": margin, "worst_frequency": omega, "worst_amplification": worst}

    def curves(self, run):
        """Return the peaks by robot, and the amplification at all frequencies with the leader's marked."""
        try:
            found = np.abs(self._measured(run))
        except TooShort:
            return []
        links = np.arange(len(found) - 1, -1, -1)
        robots = np.asarray(run.robots)
        predicted = self.amplitude * np.abs(self._held()) ** links
        peaks = Curve("amplitude [m]", robots, found, predicted, across="Robot", points=True)
        omega = np.linspace(0.02, 4.0, 400) * max(self.gain, self.frequency / 3.0)
        theory = held_link_gain(omega, self.gain, self.period, self.delay_steps, self.delayed)
        ratio = (found[0] / found[-1]) ** (1.0 / max(len(found) - 1, 1))
        gains = Curve(
            "$|G|$ of one robot [-]",
            [self.frequency],
            [ratio],
            theory,
            bound=1.0,
            across="frequency [rad/s]",
            points=True,
            predicted_at=omega,
        )
        return [peaks, gains]
