"""Commands of laws by sensors against the published law, on what the sensors should have read."""

from mrs_simulator.core.claims import NothingDecays
from mrs_simulator.protocols.published.sensors import Record

UNREAD = "poses at which sensors read were not recorded"
IN_TURNS = "transducers that fire in turns are not stated a second time"


def sensed_pairs(control, robots, law, run, known, rows):
    """Yield ``(wanted, recorded)`` commands (n, a) at samples of ``run``, and let ``robots`` be there.

    ``known``: the run with the poses that the law knew; ``rows``: samples that fall on commands.  Raises
    ``NothingDecays`` where none of the readings follows from the record.
    """
    record, found = Record(control, run, known, rows), False
    if not all(map(record.is_stated, control.SENSORS)):
        raise NothingDecays(IN_TURNS)
    frame = run if control.LOCAL_FRAMES else known
    for row, u in law.answers(record):
        robots.be_as(frame, row)
        found = True
        yield robots.commands(u), run.command[row]
    if not found:
        raise NothingDecays(UNREAD)
