"""Which of pybullet's renderers makes pictures: the graphics card where there is one, else software."""

import glob
import importlib.util
import logging

import pybullet

LOG = logging.getLogger("rosout.mrs_simulator.cameras")  # of ROS, and standard error without it
DEVICES = ("/dev/dri/renderD*", "/dev/nvidia[0-9]*")
CARD, SOFTWARE = pybullet.ER_BULLET_HARDWARE_OPENGL, pybullet.ER_TINY_RENDERER
NO_CARD = "pictures by pybullet's software renderer: there is no graphics card (%s)"
FAILED = "pictures by pybullet's software renderer: the graphics card %s is there, but %s"


def chosen_renderer(client):
    """Return the renderer for pictures of the bodies of ``client``, and log which it is, and why.

    Where there is a graphics card it is used through EGL, which needs no display.
    """
    cards = [device for pattern in DEVICES for device in sorted(glob.glob(pattern))]
    if not cards:
        LOG.info(NO_CARD, ", ".join(DEVICES))
        return SOFTWARE
    # comes with pybullet, where it was built for it
    plugin = importlib.util.find_spec("eglRenderer")
    if plugin is None:
        LOG.warning(FAILED, cards[0], "pybullet was built without EGL")
        return SOFTWARE
    loaded = pybullet.loadPlugin(plugin.origin, "_eglRendererPlugin", physicsClientId=client)
    if loaded < 0:
        LOG.warning(FAILED, cards[0], "EGL does not open it")
        return SOFTWARE
    LOG.info("pictures by the graphics card %s", cards[0])
    return CARD
