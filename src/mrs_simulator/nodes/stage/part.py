"""StagePart: what a stage does beside moving robots and publishing their odometry."""


class StagePart:
    """Topics, services or windows of some robots or things; the stage walks its list of them.

    Parts are called in the order of ``parts.py``, all by the main loop.
    """

    def follow_team(self, scenario):
        """Open the topics and services of the world's robots, of ``scenario``, instead of those before."""

    def taken(self, rows, commands):
        """Return what robots ``rows`` (m,) obey of the ``commands`` (m, a) that came."""
        return commands

    def before_step(self):
        """Take into the world, before its next step, what goes on outside of it."""

    def advance(self):
        """Command the world before its next step; not while another node simulates these robots."""

    def begin_run(self):
        """Publish what is known as a run begins, at the world's present step."""

    def after_step(self):
        """Publish what a step has made known, before any odometry of its time."""

    def idle(self):
        """Do what is due while simulated time stands still."""

    def publish(self, stamp):
        """Publish, before the odometry of this ``stamp``, what has subscribers."""

    def report(self, stamp, rows):
        """Publish, after the odometry of robots ``rows`` at ``stamp``, what else is known of them."""

    def repeat(self):
        """Publish the newest again: a node that simulated time waits for may have lost it."""

    def show(self):
        """Publish or draw what is due by wall time; called as often as the main loop goes round."""

    def reset(self):
        """Forget what robots were to do: they were put back to their initial poses."""
