"""Programs, vertex arrays and buffers of OpenGL."""

import ctypes

import numpy as np
from OpenGL import GL
from OpenGL.GL.shaders import compileProgram, compileShader


class Program:
    """A linked program, with its uniforms by name."""

    def __init__(self, name):
        self.name, self._places = name, {}

    def give(self, **values):
        """Set uniforms; vectors are tuples or arrays, matrices are given row by row."""
        setters = {0: GL.glUniform1f, 2: GL.glUniform2f, 3: GL.glUniform3f}
        for key, value in values.items():
            if key not in self._places:
                self._places[key] = GL.glGetUniformLocation(self.name, key)
            place, value = self._places[key], np.asarray(value, dtype=np.float32)
            if value.ndim == 2:
                setter = GL.glUniformMatrix4fv if len(value) == 4 else GL.glUniformMatrix3fv
                setter(place, 1, GL.GL_TRUE, np.ascontiguousarray(value))
            else:
                setters[value.size if value.ndim else 0](place, *np.atleast_1d(value).tolist())


def program(parts):
    """Return the ``Program`` of ``parts``: a text and the kind of shader each."""
    shaders = [compileShader(*part) for part in parts]
    return Program(int(compileProgram(*shaders, validate=False)))


def vertex_array(parts, width):
    """Return a vertex array and its buffer; ``parts``: (location, floats) of a row of ``width`` floats."""
    array, buffer = GL.glGenVertexArrays(1), GL.glGenBuffers(1)
    GL.glBindVertexArray(array)
    GL.glBindBuffer(GL.GL_ARRAY_BUFFER, buffer)
    describe(parts, width)
    return array, buffer


def describe(parts, width):
    """Tell the bound array how rows of ``width`` floats in the bound buffer are divided."""
    begin = 0
    for place, count in parts:
        GL.glEnableVertexAttribArray(place)
        where = ctypes.c_void_p(4 * begin)
        GL.glVertexAttribPointer(place, count, GL.GL_FLOAT, GL.GL_FALSE, 4 * width, where)
        begin += count


def upload(buffer, rows):
    """Have ``buffer`` hold ``rows`` of float32."""
    GL.glBindBuffer(GL.GL_ARRAY_BUFFER, buffer)
    GL.glBufferData(GL.GL_ARRAY_BUFFER, rows.nbytes, rows, GL.GL_STREAM_DRAW)
