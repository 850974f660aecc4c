"""Registers a node again with a ROS master that was restarted, which rospy itself does not do."""

import threading
import time

import rosgraph
import rospy
from rospy.impl.registration import (
    Registration,
    get_registration_listeners,
    get_service_manager,
    get_topic_manager,
)

LOOK_PERIOD = 2.0  # [s] of wall time between two looks at the master
SIMULATED_TIME = "/use_sim_time"


def keep_registered():
    """Look in a thread, as long as the node lives, whether the master is another one now.

    Without it the topics that are connected go on, so that all looks well, and no service can be
    reached: ``stop`` among them.
    """
    simulated = rospy.get_param(SIMULATED_TIME, False)
    threading.Thread(target=_look, args=(simulated,), daemon=True).start()


def _look(simulated):
    master, known = rosgraph.Master(rospy.get_name()), None
    while not rospy.is_shutdown():
        try:
            pid = master.getPid()
            if known is not None and pid != known:
                register_again()
                if simulated and not rospy.has_param(SIMULATED_TIME):
                    # or new nodes would go by the wall's time
                    rospy.set_param(SIMULATED_TIME, True)
                rospy.logwarn(
                    "%s: the ROS master was restarted, registered again", master.caller_id
                )
            known = pid
        except Exception as error:  # a master that is out of reach, or on its way out
            rospy.logdebug("looking at the master: %s", error)
        time.sleep(LOOK_PERIOD)


def register_again():
    """Register all topics and services of this node with the master."""
    topics, services = get_topic_manager(), get_service_manager()
    notify = get_registration_listeners().notify_added
    for name, kind in topics.get_publications():
        notify(name, kind, Registration.PUB)
    for name, kind in topics.get_subscriptions():
        notify(name, kind, Registration.SUB)
    for name, uri in services.get_services():
        notify(name, uri, Registration.SRV)
