"""Locates the scenarios that come with the package."""

import os


def shipped_scenarios():
    """Return the directory of the shipped scenarios."""
    import rospkg  # only who asks for them needs it

    return os.path.join(rospkg.RosPack().get_path("mrs_simulator"), "scenarios")


def scenario_path(name):
    """Return the path of the scenario file ``name``; one without a directory may be a shipped one."""
    if not os.path.exists(name) and os.path.basename(name) == name:
        shipped = os.path.join(shipped_scenarios(), name)
        return shipped if os.path.exists(shipped) else name
    return name
