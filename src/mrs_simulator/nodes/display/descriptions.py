"""Each robot's description as a parameter, for programs that show robots by their model."""

import contextlib
import http.client
from xmlrpc.client import Fault

import rospy

from mrs_simulator.vehicles.visuals import description

NAME = "robot{}/robot_description"
FAILURES = (rospy.ROSException, OSError, Fault, http.client.HTTPException, KeyError)


class Descriptions:
    """Keeps ``/robotN/robot_description`` as the robots are; what others have set stays theirs."""

    def __init__(self):
        self._published = {}  # by the name of the parameter
        rospy.on_shutdown(self.clear)

    def follow(self, kinds):
        """Set the descriptions of robots 1 to n of ``kinds``; take back those of robots that are gone."""
        texts = {each: description(each) for each in dict.fromkeys(kinds)}
        wanted = {NAME.format(number): texts[each] for number, each in enumerate(kinds, 1)}
        with contextlib.suppress(*FAILURES):  # a master on its way out
            for name in set(self._published).difference(wanted):
                self._forget(name)
            for name, text in wanted.items():
                if self._published.get(name) != text and (
                    name in self._published or not rospy.has_param(name)
                ):
                    rospy.set_param(name, text)
                    self._published[name] = text

    def clear(self):
        """Take all of them back."""
        for name in list(self._published):
            with contextlib.suppress(*FAILURES):
                self._forget(name)

    def _forget(self, name):
        # Another one may have been set since.
        if rospy.get_param(name, "") == self._published.pop(name):
            rospy.delete_param(name)
