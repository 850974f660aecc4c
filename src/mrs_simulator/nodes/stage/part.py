"""StagePart: topics and services of the stage, beside those that every team has."""


class StagePart:
    """Topics and services for some robots or things of the world, such as arms, a load or drivers."""

    def follow_team(self):
        """Open the topics and services of the world's robots, instead of those before."""

    def advance(self):
        """Command the world before its next step; not while another node simulates these robots."""

    def publish(self, stamp):
        """Publish, before the odometry of this ``stamp``, what has subscribers."""

    def reset(self):
        """Forget what robots were to do: they were put back to their initial poses."""
