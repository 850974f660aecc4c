"""What a person does to the obstacles on the map, one drag or key at a time.  No Qt, no painting."""

import math

import numpy as np

from mrs_simulator.rqt_plugin.map import obstacle_shapes as shapes

FINE, COARSE = math.radians(1.0), math.radians(15.0)  # [rad] of a turn
SIZE = 1.0  # [m] of an obstacle that a key places
SPIRAL = 400  # [-] places that are tried for it


class ObstacleEditor:
    """Those obstacles that may be edited, the one selected, and what a drag makes of it.

    ``edited`` is called with all of them after each edit; whether they are taken up is for others to
    decide by showing them or others.
    """

    def __init__(self, edited, changed):
        """``changed()`` is called when something else is to be drawn."""
        self._edited, self._changed = edited, changed
        self.own, self._names = (), frozenset()
        self.shape, self.selected, self.draft = "box", "", None  # draft: as the drag has it so far
        self._drag = None

    def show(self, obstacles, own):
        """Take ``obstacles``, the first ``own`` of which may be edited."""
        self.own = tuple(obstacles[:own])
        self._names = frozenset(each.name for each in obstacles)
        self._drag = self.draft = None
        if self.current is None:
            self.selected = ""
        self._changed()

    @property
    def current(self):
        """Return the obstacle that is selected, as the drag has it; None for none."""
        if self.draft is not None:
            return self.draft
        return next((each for each in self.own if each.name == self.selected), None)

    @property
    def is_dragging(self):
        """Return whether a drag is under way."""
        return self._drag is not None

    def select(self, name):
        """Select the obstacle called ``name``, "" for none."""
        self.selected = name
        self._changed()

    def select_next(self, step):
        """Select the next obstacle, with -1 the one before."""
        names = [each.name for each in self.own]
        if names:
            before = names.index(self.selected) if self.selected in names else min(0, -step)
            self.select(names[(before + step) % len(names)])

    # A drag --------------------------------------------------------------------------------------

    def handle_at(self, point, reach):
        """Return the name of the selected obstacle's handle within ``reach`` [m] of ``point``, or ""."""
        if self.current is None:
            return ""
        places = shapes.handles(self.current, reach)
        away = {name: np.hypot(*(place - point)) for name, place in places.items()}
        nearest = min(away, key=away.get, default="")
        return nearest if nearest and away[nearest] <= reach else ""

    def at(self, point, reach):
        """Return the obstacle within ``reach`` [m] of ``point``, None for none."""
        place = shapes.obstacle_at(self.own, point, reach)
        return self.own[place] if place >= 0 else None

    def press(self, point, reach, other=False):
        """Begin a drag at ``point``; ``other``: one on free floor draws the shape that is not chosen."""
        grip, found = self.handle_at(point, reach), self.at(point, 0.5 * reach)
        if grip:
            self._drag = grip, point, self.current
        elif found is not None:
            self._drag = "move", point, found
            self.selected = found.name
        else:
            self._drag = "draw", point, self._other_shape() if other else self.shape
            self.selected = ""
        self._changed()

    def _other_shape(self):
        return "cylinder" if self.shape == "box" else "box"

    def drag(self, point, step, coarse=False):
        """Move the handle to ``point``, in multiples of ``step`` [m], or of 1 or 15 degrees."""
        if self._drag is None:
            return
        what, begin, of = self._drag
        if what == "draw":
            self.draft = shapes.spanned(of, shapes.free_name(of, self._names), begin, point, step)
        elif what == "move":
            self.draft = shapes.moved(of, np.add([of.x, of.y], np.subtract(point, begin)), step)
        else:
            angle = COARSE if coarse else FINE
            self.draft = shapes.dragged(of, what, point, step, angle) or self.draft
        self._changed()

    def release(self):
        """End the drag: what it has made is the edit."""
        draft, self.draft, self._drag = self.draft, None, None
        if draft is not None:
            self._put(draft)
        self._changed()

    def cancel(self):
        """Give the drag up."""
        self.draft = self._drag = None
        self._changed()

    # Edits ---------------------------------------------------------------------------------------

    def _put(self, obstacle):
        """Have ``obstacle`` in place of the one of its name, or as another one."""
        self.selected = obstacle.name
        names = [each.name for each in self.own]
        if obstacle.name not in names:
            self._edited((*self.own, obstacle))
        elif obstacle not in self.own:
            place = names.index(obstacle.name)
            self._edited((*self.own[:place], obstacle, *self.own[place + 1 :]))

    def change(self, **values):
        """Give the selected obstacle other ``values``."""
        if self.current is not None:
            self._put(self.current._replace(**values))

    def move_by(self, shift):
        """Move the selected obstacle by ``shift`` (2,) [m]."""
        if self.current is not None:
            place = np.round(np.add([self.current.x, self.current.y], shift), 9).tolist()
            self.change(x=place[0], y=place[1])

    def turn_by(self, angle):
        """Turn the selected obstacle by ``angle`` [rad]."""
        if self.current is not None:
            self._put(shapes.turned(self.current, angle))

    def grow_by(self, change):
        """Lengthen the sides of the selected obstacle by ``change`` [m]."""
        larger = self.current and shapes.scaled(self.current, change)
        if larger:
            self._put(larger)

    def delete(self):
        """Delete the selected obstacle."""
        kept = tuple(each for each in self.own if each.name != self.selected)
        if len(kept) < len(self.own):
            self._edited(kept)

    def duplicate(self):
        """Place another obstacle like the selected one beside it."""
        if self.current is not None:
            kind = "cylinder" if hasattr(self.current, "radius") else "box"
            name = shapes.free_name(kind, self._names)
            x = self.current.x + 0.5
            self._put(self.current._replace(name=name, x=round(x, 9)))

    def place(self, shape, centre, is_free):
        """Place a new ``shape`` about ``centre`` (2,) [m], or as near to it as ``is_free`` allows."""
        name, half = shapes.free_name(shape, self._names), 0.5 * SIZE
        for number in range(SPIRAL):
            away, angle = 0.25 * math.sqrt(number), 2.4 * number  # [rad] the golden angle
            middle = np.add(centre, [away * math.cos(angle), away * math.sin(angle)])
            begin = middle if shape == "cylinder" else middle - half
            end = middle + (half, 0.0 if shape == "cylinder" else half)
            found = shapes.spanned(shape, name, begin, end, 0.1)
            if found is not None and is_free(found):
                break
        self._put(found)
