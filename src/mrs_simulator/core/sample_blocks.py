"""Blocks of samples, so that evaluating a long run takes little memory."""

AT_ONCE = 1 << 15  # [-] robots, over all samples of a block: what a processor's cache holds


def blocks(samples, robots):
    """Yield slices of ``samples`` of so many ``robots``, in order, each of at least one sample."""
    size = max(1, AT_ONCE // max(robots, 1))
    for row in range(0, samples, size):
        yield slice(row, min(row + size, samples))
