"""The law of all trials: every robot drives straight on, so that whoever stands was stopped."""

from mrs_simulator import PioneerControl, make_twist


class Forward(PioneerControl):
    def calculateControlLaw(self, pos_map):
        return {number: make_twist(0.2, 0.0) for number in pos_map}
