"""How often a run is painted, so that the GUI leaves the processor to the simulation.

Shares are of one core, by the processor time that a picture took: on a busy machine it lasts longer, and
costs no more.
"""

FEW, GROWTH = 7, 0.18  # [-] robots up to which shares are as below, and how they grow beyond
# Together, with what else there is to do, 15 % for 7 robots, 25 % for 100, 40 % for 1,000.
MAP_ALONE, MAP, VIEW, CURVES = 0.085, 0.045, 0.035, 0.02


def pause(cost, share, robots):
    """Return the time [s] from one picture to the next that ``robots`` move on.

    ``cost`` [s] of processor time of the last one, of which it may take a ``share`` for few robots.
    """
    return cost / (share * (max(FEW, robots) / FEW) ** GROWTH)
