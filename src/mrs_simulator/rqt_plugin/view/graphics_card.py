"""Draws a scene's bodies, ground and sky by OpenGL into a picture, where PyOpenGL and a driver are there.

It draws off the screen: no widget has to become an OpenGL one, which would make its window anew.
"""

from typing import NamedTuple

import numpy as np

from mrs_simulator.pictures.camera import FIELD_OF_VIEW
from mrs_simulator.pictures.ground import ON_WATER, STRENGTH, step
from mrs_simulator.pictures.instances import instances, land, triangles
from mrs_simulator.pictures.scene import BEAM, PATH_SHOWN
from mrs_simulator.pictures.trails import shown_trails
from mrs_simulator.pictures.view import View
from mrs_simulator.rqt_plugin.qt.QtCore import QSize
from mrs_simulator.rqt_plugin.qt.QtGui import (
    QOffscreenSurface,
    QOpenGLContext,
    QOpenGLFramebufferObject,
    QOpenGLFramebufferObjectFormat,
    QSurfaceFormat,
)
from mrs_simulator.rqt_plugin.view.shaders import BODY, LIT, RAY, SURROUNDINGS
from mrs_simulator.rqt_plugin.widgets.guard import LOG

try:
    from OpenGL import GL

    from mrs_simulator.rqt_plugin.view.gl_lines import GlLines
    from mrs_simulator.rqt_plugin.view.gl_parts import describe, program, upload, vertex_array
except Exception:  # it may be missing, or fail to find the driver's library
    GL = None

VERSION = 3, 3  # of OpenGL
# of renderers without a card
SOFTWARE = "llvmpipe", "softpipe", "swrast", "software", "swiftshader"
MOST_BY_SOFTWARE = 100  # [-] robots that those draw as soon as the painter
SAMPLES = 4  # [-] of a pixel
CORNER, INSTANCE = 10, 15  # [-] floats
CORNER_PARTS = (3, 3, 3, 1)
INSTANCE_PARTS = (4, 4, 4, 3)
NEAREST, FARTHEST = 0.01, 300.0  # [-] of the camera's distance
LINE = 2.0  # [px] of trails
LIGHT_FROM = (-0.8, -0.3, 1.0)  # right, ahead over the ground, up
LIFT = 0.01  # [m] of trails over the ground


def graphics_card():
    """Return a ``GraphicsCard``, None where there is no PyOpenGL, or no driver for OpenGL 3.3."""
    if GL is None:
        return None
    try:
        return GraphicsCard()
    except Exception as error:  # whatever drivers do, the painter is there
        LOG.debug("3D without OpenGL: %s", error)
        return None


class GraphicsCard:
    """A context of OpenGL 3.3 off the screen, with the meshes of what it has drawn."""

    def __init__(self):
        """Raise ``RuntimeError``, or what the driver raises, where it cannot draw."""
        wanted = QSurfaceFormat()
        wanted.setVersion(*VERSION)
        wanted.setProfile(QSurfaceFormat.CoreProfile)
        self._context, self._surface = QOpenGLContext(), QOffscreenSurface()
        self._context.setFormat(wanted)
        if not self._context.create() or self._context.format().version() < VERSION:
            raise RuntimeError("no context of OpenGL {}.{}".format(*VERSION))
        self._surface.setFormat(self._context.format())
        self._surface.create()
        self._begin()
        self.renderer = GL.glGetString(GL.GL_RENDERER).decode()
        self.is_software = any(word in self.renderer.lower() for word in SOFTWARE)
        self._empty = GL.glGenVertexArrays(1)
        GL.glBindVertexArray(self._empty)
        ends = GL.GL_VERTEX_SHADER, GL.GL_FRAGMENT_SHADER
        self._bodies = program(zip((BODY, LIT), ends))
        self._surroundings = program(zip((RAY, SURROUNDINGS), ends))
        self._lines = GlLines()
        self._meshes, self._targets = {}, {}
        self._end()

    def _begin(self):
        if not self._context.makeCurrent(self._surface):
            raise RuntimeError("the context of OpenGL cannot be made current")

    def _end(self):
        self._context.doneCurrent()

    def suits(self, scene):
        """Return whether it draws the ``scene`` as soon as the painter would."""
        return not self.is_software or len(scene.kinds) <= MOST_BY_SOFTWARE

    def picture(self, scene, camera, size, palette, is_fine=True):
        """Return a ``QImage`` of ``size`` (width, height) [pixels] of a ``Scene`` as ``camera`` has it.

        ``is_fine``: with smooth edges.
        """
        view = View(camera, *size, palette)
        self._begin()
        try:
            if self.is_software and not self._targets:
                # It compiles for each way, a tenth of a second: for both as the view opens.
                self._drawn(scene, view, size, 0 if is_fine else SAMPLES)
            return self._drawn(scene, view, size, SAMPLES if is_fine else 0).toImage()
        finally:
            self._end()

    def _drawn(self, scene, view, size, samples):
        """Return the framebuffer with the picture."""
        target = self._take_target(size, samples)
        self._draw(scene, view)
        target.release()
        return target

    def _take_target(self, size, samples):
        """Return the framebuffer, bound, of ``size`` and so many ``samples`` of a pixel."""
        target = self._targets.get(samples)
        if target is None or target.size() != QSize(*size):
            form = QOpenGLFramebufferObjectFormat()
            form.setSamples(samples)
            form.setAttachment(QOpenGLFramebufferObject.CombinedDepthStencil)
            target = self._targets[samples] = QOpenGLFramebufferObject(QSize(*size), form)
        if not target.bind():
            raise RuntimeError("no picture of {} x {} pixels".format(*size))
        GL.glViewport(0, 0, *size)
        return target

    def _draw(self, scene, view):
        GL.glClear(GL.GL_COLOR_BUFFER_BIT | GL.GL_DEPTH_BUFFER_BIT | GL.GL_STENCIL_BUFFER_BIT)
        matrix, palette = _matrix(view), view.palette
        GL.glDisable(GL.GL_DEPTH_TEST)
        if scene.on_water:
            self._draw_surroundings(view, palette.water, ON_WATER)
            self._draw_land(scene, view, matrix)
        else:
            self._draw_surroundings(view, palette.ground, STRENGTH)
        GL.glEnable(GL.GL_DEPTH_TEST)
        groups = self._uploaded(instances(scene, palette.obstacle))
        solid = [each for each in groups if each.opacity == 1.0]
        GL.glUseProgram(self._bodies.name)
        self._bodies.give(camera=matrix, light=_light(view), eye=view.eye, dark=view.palette.shadow)
        self._draw_shadows([each for each in groups if each.casts])
        self._bodies.give(flat_share=0.0, opacity=1.0)
        _draw_groups(solid)
        self._draw_lines(scene, view, matrix)
        self._draw_sheer([each for each in groups if each.opacity < 1.0])
        GL.glDisable(GL.GL_DEPTH_TEST)
        GL.glBindVertexArray(0)
        GL.glUseProgram(0)

    def _draw_lines(self, scene, view, matrix):
        pairs = zip(shown_trails(scene, view), np.asarray(scene.shades))
        lines = [(trail + (0.0, 0.0, LIFT), (*shade, 1.0)) for trail, shade in pairs]
        for ghosts in scene.ghosts:
            pairs = zip(ghosts.paths, ghosts.path_shades)
            lines += [(path + (0.0, 0.0, LIFT), (*shade, PATH_SHOWN)) for path, shade in pairs]
        rays = [
            (ends, (*each.shade, opacity))
            for each in scene.beams
            for ends, opacity in zip(each.segments, each.opacity)
        ]
        _blend(True)
        self._lines.draw(lines, matrix, view, LINE)
        self._lines.draw(rays, matrix, view, BEAM)
        _blend(False)

    def _draw_sheer(self, groups):
        """Draw what is seen through: of each such body the surfaces in front alone."""
        GL.glUseProgram(self._bodies.name)
        GL.glColorMask(*[GL.GL_FALSE] * 4)
        _draw_groups(groups)
        GL.glColorMask(*[GL.GL_TRUE] * 4)
        GL.glDepthFunc(GL.GL_LEQUAL)
        _blend(True)
        for each in groups:
            self._bodies.give(opacity=each.opacity)
            _draw_groups([each])
        _blend(False)
        GL.glDepthFunc(GL.GL_LESS)

    def _draw_land(self, scene, view, matrix):
        """Draw the ground anew where there is land in the water."""
        groups = self._uploaded(land(scene))
        GL.glUseProgram(self._bodies.name)
        self._bodies.give(camera=matrix, flat_share=0.0)
        GL.glEnable(GL.GL_STENCIL_TEST)
        GL.glEnable(GL.GL_DEPTH_CLAMP)  # a coast goes on beyond what is seen of bodies
        GL.glStencilFunc(GL.GL_ALWAYS, 1, 255)
        GL.glStencilOp(GL.GL_KEEP, GL.GL_KEEP, GL.GL_REPLACE)
        GL.glColorMask(*[GL.GL_FALSE] * 4)
        _draw_groups(groups)
        GL.glColorMask(*[GL.GL_TRUE] * 4)
        GL.glDisable(GL.GL_DEPTH_CLAMP)
        GL.glStencilFunc(GL.GL_EQUAL, 1, 255)
        GL.glStencilOp(GL.GL_KEEP, GL.GL_KEEP, GL.GL_KEEP)
        self._draw_surroundings(view, view.palette.ground, STRENGTH)
        GL.glDisable(GL.GL_STENCIL_TEST)
        GL.glClear(GL.GL_STENCIL_BUFFER_BIT)

    def _draw_surroundings(self, view, ground, strength):
        """Draw a ``ground`` of that colour, with lines of some ``strength``, and the sky."""
        palette, half = view.palette, np.tan(np.radians(0.5 * FIELD_OF_VIEW))
        GL.glUseProgram(self._surroundings.name)
        self._surroundings.give(
            axes=view.camera.axes.T, slope=(half * view.width / view.height, half), eye=view.eye,
            ground=ground, sky=palette.sky, lines=palette.lines, strength=strength,
            wide=step(view), reach=3.0 * view.camera.distance,
        )  # fmt: skip
        GL.glBindVertexArray(self._empty)
        GL.glDrawArrays(GL.GL_TRIANGLES, 0, 3)

    def _draw_shadows(self, groups):
        """Darken the ground once, however many bodies shade it."""
        _blend(True)
        GL.glEnable(GL.GL_STENCIL_TEST)
        GL.glStencilFunc(GL.GL_EQUAL, 0, 255)
        GL.glStencilOp(GL.GL_KEEP, GL.GL_KEEP, GL.GL_INCR)
        GL.glDepthMask(GL.GL_FALSE)
        self._bodies.give(flat_share=1.0)
        _draw_groups(groups)
        GL.glDepthMask(GL.GL_TRUE)
        GL.glDisable(GL.GL_STENCIL_TEST)
        _blend(False)

    def _uploaded(self, things):
        """Return the ``_Group`` of each of ``things``, with their places of today."""
        groups = []
        for each in things:
            array, buffer, corners = self._mesh(each)
            m = len(each.place)
            rows = np.empty((m, INSTANCE), dtype=np.float32)
            rows[:, :12].reshape(m, 3, 4)[:, :, :3] = each.turn
            rows[:, :12].reshape(m, 3, 4)[:, :, 3] = each.place
            rows[:, 12:] = each.shades
            upload(buffer, rows)
            groups.append(_Group(array, corners, m, each.opacity, each.casts))
        return groups

    def _mesh(self, thing):
        """Return the vertex array, the buffer of places, and the number of corners of a thing's model."""
        key = id(thing.model), thing.has_nose, thing.opacity, thing.casts
        if key not in self._meshes:
            rows = triangles(thing.model, thing.has_nose)
            array, corners = vertex_array(tuple(enumerate(CORNER_PARTS)), CORNER)
            upload(corners, rows)
            buffer = GL.glGenBuffers(1)
            GL.glBindBuffer(GL.GL_ARRAY_BUFFER, buffer)
            first = len(CORNER_PARTS)
            describe(tuple(enumerate(INSTANCE_PARTS, first)), INSTANCE)
            for place in range(first, first + len(INSTANCE_PARTS)):
                GL.glVertexAttribDivisor(place, 1)
            self._meshes[key] = thing.model, array, buffer, len(rows)  # the model keeps its id
        return self._meshes[key][1:]


class _Group(NamedTuple):
    """Things of one mesh that are drawn by one call."""

    array: int
    corners: int
    count: int
    opacity: float
    casts: bool  # a shadow


def _blend(on):
    if not on:
        GL.glDisable(GL.GL_BLEND)
        return
    GL.glEnable(GL.GL_BLEND)
    mixed = GL.GL_SRC_ALPHA, GL.GL_ONE_MINUS_SRC_ALPHA
    GL.glBlendFuncSeparate(*mixed, GL.GL_ZERO, GL.GL_ONE)  # the picture stays opaque


def _draw_groups(groups):
    for each in groups:
        GL.glBindVertexArray(each.array)
        GL.glDrawArraysInstanced(GL.GL_TRIANGLES, 0, each.corners, each.count)


def _light(view):
    """Return the direction (3,) that the light comes from: shadows fall to the right in the picture."""
    right = view.camera.axes[0]
    ahead = np.array([-right[1], right[0], 0.0])
    light = LIGHT_FROM[0] * right + LIGHT_FROM[1] * ahead + (0.0, 0.0, LIGHT_FROM[2])
    return light / np.linalg.norm(light)


def _matrix(view):
    """Return the matrix (4, 4) from the common frame to the clip space of OpenGL."""
    axes, half = view.camera.axes * [[1.0], [1.0], [-1.0]], np.tan(np.radians(0.5 * FIELD_OF_VIEW))
    seen = np.eye(4)
    seen[:3, :3], seen[:3, 3] = axes, -axes @ view.eye
    near, far = (share * max(view.camera.distance, 1.0) for share in (NEAREST, FARTHEST))
    clip = np.zeros((4, 4))
    clip[0, 0], clip[1, 1] = view.height / (half * view.width), 1.0 / half
    clip[2, 2:] = -(far + near) / (far - near), -2.0 * far * near / (far - near)
    clip[3, 2] = -1.0
    return clip @ seen
