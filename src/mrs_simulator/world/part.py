"""Part: what acts in each step of a world, beside the motion."""


class Part:
    """Something that changes commands before the robots move, or looks at them afterwards.

    ``before_step(command)`` returns what robots obey instead of the ``command`` (n, a) of the parts before
    it; ``after_step()`` follows the motion.  Either is None in a part that has nothing to do then.
    """

    can_fuse = False  # whether there is nothing to do in steps made at once
    before_step = after_step = None

    def columns(self):
        """Return what it adds to the state now: values by the names of ``state.columns``."""
        return {}

    def reset(self):
        """Begin the run: forget what was before, such as a take-off; the clock is at 0."""
