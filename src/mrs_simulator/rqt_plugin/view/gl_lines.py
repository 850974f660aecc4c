"""Lines in space, drawn by OpenGL, as wide as is wanted."""

import numpy as np
from OpenGL import GL

from mrs_simulator.rqt_plugin.view.gl_parts import program, upload, vertex_array
from mrs_simulator.rqt_plugin.view.shaders import PATH, PLAIN, WIDEN

ROW = 7  # [-] floats: place, colour


class GlLines:
    """Draws lines through several points each, all by one call."""

    def __init__(self):
        shaders = (PATH, GL.GL_VERTEX_SHADER), (WIDEN, GL.GL_GEOMETRY_SHADER)
        self._program = program([*shaders, (PLAIN, GL.GL_FRAGMENT_SHADER)])
        self._array, self._buffer = vertex_array(((0, 3), (1, 4)), ROW)

    def draw(self, lines, matrix, view, wide):
        """Draw ``lines``, (k, 3) [m] and a colour (4,) each, ``wide`` [px], as ``matrix`` has them."""
        lines = [(points, colour) for points, colour in lines if len(points) > 1]
        if not lines:
            return
        counts = np.array([len(points) for points, _ in lines], dtype=np.int32)
        rows = np.empty((counts.sum(), ROW), dtype=np.float32)
        rows[:, :3] = np.concatenate([points for points, _ in lines])
        rows[:, 3:] = np.repeat(np.array([colour for _, colour in lines]), counts, axis=0)
        GL.glUseProgram(self._program.name)
        pixel = 2.0 / view.width, 2.0 / view.height
        self._program.give(camera=matrix, pixel=pixel, wide=wide)
        GL.glBindVertexArray(self._array)
        upload(self._buffer, rows)
        begins = np.cumsum(counts, dtype=np.int32) - counts
        GL.glMultiDrawArrays(GL.GL_LINE_STRIP, begins, counts, len(counts))
