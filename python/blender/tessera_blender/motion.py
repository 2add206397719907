"""Motion blur: where things are while the shutter is open, and how it opens, closes and rolls."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from tessera._values import matrix_message
from tessera.v1 import camera_pb2, light_pb2, shape_pb2

# Sets the frame, with a part of it below 1, and evaluates the dependency graph for it.
SetFrame = Callable[[int, float], Any]

_CURVE_VALUES = 64  # Cycles samples the curve, too
_MOST_STEPS = 6  # 2^6 + 1 placings


def array_of(matrix: Any) -> Any:
    return np.array([list(row) for row in matrix], dtype=np.float64)


def _steps_of(thing: Any) -> int:
    """Cycles' motion steps, of which each doubles the placings; 0 for what it keeps still."""
    settings = getattr(thing, "cycles", None)
    if settings is None:
        return 1
    if not getattr(settings, "use_motion_blur", True):
        return 0
    return min(max(int(getattr(settings, "motion_steps", 1)), 1), _MOST_STEPS)


class Shutter:
    """The shutter of a scene of Blender's that has motion blur."""

    def __init__(self, blender: Any) -> None:
        render, cycles = blender.render, getattr(blender, "cycles", None)
        holder = render if hasattr(render, "motion_blur_position") else cycles  # Cycles' before Blender 4.2
        position = getattr(holder, "motion_blur_position", "CENTER")
        self.frames = float(render.motion_blur_shutter)
        before = {"START": 0.0, "CENTER": 0.5, "END": 1.0}[position] * self.frames
        self.open = blender.frame_current + blender.frame_subframe - before
        self._curve = render.motion_blur_shutter_curve
        self._rolls = getattr(cycles, "rolling_shutter_type", "NONE") == "TOP"
        self._row = float(getattr(cycles, "rolling_shutter_duration", 1.0))

    def write(self, camera: camera_pb2.Camera) -> None:
        values = self._values()
        if max(values) > 0 and not np.allclose(values, values[0], rtol=1e-3):
            camera.shutter.sampled.values[:] = values
        if self._rolls:
            # A row that is exposed for a moment alone would have light of that moment alone.
            camera.shutter.rolling.duration = min(max(self._row, 1e-3), 1.0)

    def _values(self) -> list[float]:
        if hasattr(self._curve, "initialize"):
            self._curve.initialize()
        curve = self._curve.curves[0]
        times = np.linspace(0, 1, _CURVE_VALUES)
        return [max(0.0, float(self._curve.evaluate(curve, t))) for t in times]


class Motions:
    """World from object of all that is shown, and the shapes of what deforms, at evenly spaced times. `places`
    walks over all things as the graph has them: a key, the evaluated object, and the matrix. `shape_of` gives what
    is to be kept of an object's shape, None where it does not change."""

    def __init__(
        self,
        shutter: Shutter,
        set_frame: SetFrame,
        now: tuple[int, float],
        places: Any,
        shape_of: Callable[[Any], Any],
    ) -> None:
        steps = {key: _steps_of(thing) for key, thing, _ in places()}
        intervals = 2 ** max(steps.values(), default=0)
        self._placings: dict[Any, list[tuple[float, Any]]] = {}
        self._shapes: dict[Any, list[Any]] = {}
        try:
            for i in range(intervals + 1):
                frame = shutter.open + shutter.frames * i / intervals
                whole = math.floor(frame)
                set_frame(whole, frame - whole)
                for key, thing, matrix in places():
                    if i % (intervals // 2 ** steps.get(key, 0)) != 0:
                        continue
                    self._placings.setdefault(key, []).append((i / intervals, array_of(matrix)))
                    shape = shape_of(thing) if steps.get(key, 0) > 0 else None
                    if shape is not None:
                        self._shapes.setdefault(key, []).append(shape)
        finally:
            set_frame(*now)
        self._steps = steps

    def of(self, key: Any) -> list[tuple[float, Any]]:
        """Times and matrices from 0 on; one alone where it stands still, or was not there all the time."""
        placings = self._placings.get(key, [])
        steps = self._steps.get(key, 0)
        whole = steps > 0 and len(placings) == 2**steps + 1
        if not whole or all(np.allclose(matrix, placings[0][1], atol=1e-9) for _, matrix in placings):
            return placings[:1]
        return placings


    def shapes_of(self, key: Any) -> list[Any]:
        """The shapes of what deforms, at evenly spaced times from 0 to 1; none where it was not there all the time."""
        shapes = self._shapes.get(key, [])
        return shapes if len(shapes) == 2 ** self._steps.get(key, 0) + 1 else []


def write_keys(
    placings: list[tuple[float, Any]], element: shape_pb2.Shape | camera_pb2.Camera | light_pb2.Light
) -> None:
    """The placings after the first, which is the place of the element itself."""
    for time, matrix in placings[1:]:
        element.motion.add(time=time, place=matrix_message(matrix))
