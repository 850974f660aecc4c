"""Long runs are evaluated some samples at a time, so that what is made of them takes little memory."""

AT_ONCE = 1 << 15  # [-] robots, over all samples of a block: what a processor's cache holds


def blocks(samples, robots):
    """Yield the slices of so many ``samples`` of ``robots``, in order: at least one sample each."""
    size = max(1, AT_ONCE // max(robots, 1))
    for row in range(0, samples, size):
        yield slice(row, min(row + size, samples))
