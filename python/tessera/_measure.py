"""Measured light: meters of a scene, by the program `tessera measure`, and their figures as numbers and arrays."""

from __future__ import annotations

import json
import math
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Tuple

import numpy as np
import numpy.typing as npt
from google.protobuf import text_format

from tessera._program import repeat_warnings, run_program
from tessera._wire import TesseraError
from tessera.farm import Farm
from tessera.scene import Scene
from tessera.v1 import meter_pb2

Doubles = npt.NDArray[np.float64]
Triple = Tuple[float, float, float]

_DONE, _INCOMPLETE = 0, 6  # exit codes


@dataclass(frozen=True)
class Figure:
    """A number with its error, in the unit of its meter."""

    meter: str
    quantity: str  # "illuminance"
    cell: str  # tells the figures of one meter apart: "2 3" is a plane's column and row, "7" a triangle
    position: Triple | None  # world space
    normal: Triple | None
    value: float  # NaN: there is none
    unit: str
    standard_error: float
    interval: tuple[float, float]  # of 95 %
    samples: int
    degrees_of_freedom: float  # of the standard error; 0: the value is exact
    integrator: str


@dataclass(frozen=True)
class Grid:
    """The cells of a plane. Rows run along edge_v, columns along edge_u, from the corner."""

    corner: Triple
    edge_u: Triple
    edge_v: Triple
    values: Doubles  # (rows, columns)
    standard_errors: Doubles
    low: Doubles  # ends of 95 % intervals
    high: Doubles
    positions: Doubles  # (rows, columns, 3), of the cells' middles
    mean: float
    mean_error: float


@dataclass(frozen=True)
class Surface:
    """The triangles of a shape."""

    shape: str
    vertices: Doubles  # (vertices, 3), world space
    triangles: npt.NDArray[np.int64]  # (triangles, 3)
    values: Doubles  # (triangles,)
    standard_errors: Doubles
    low: Doubles
    high: Doubles
    mean: float  # over the area
    mean_error: float


@dataclass(frozen=True)
class Meter:
    """The figures of one meter."""

    name: str
    quantity: str
    unit: str
    integrator: str
    warnings: list[str]
    figures: list[Figure]  # all, also those of grids and surfaces
    grids: list[Grid]
    surfaces: list[Surface]

    @property
    def figure(self) -> Figure:
        """The only figure. ValueError where there are none or several."""
        if len(self.figures) != 1:
            raise ValueError(f"meter {self.name!r} has {len(self.figures)} figures")
        return self.figures[0]

    @property
    def value(self) -> float:
        """That of the only figure."""
        return self.figure.value


@dataclass(frozen=True)
class Measured:
    """What all meters have found."""

    meters: list[Meter]
    complete: bool  # False: the time was up before all figures were as sure as they were wanted
    wanted_error: float  # relative, of 95 % intervals; 0: none was asked for
    worst_error: float  # that was reached
    worst_meter: str
    metres_per_unit: float  # of the scene; 0: not said
    seed: int
    cpu_seconds: float

    @property
    def figures(self) -> list[Figure]:
        return [figure for meter in self.meters for figure in meter.figures]

    def __getitem__(self, name: str) -> Meter:
        """The meter of a name. KeyError where there is none."""
        for meter in self.meters:
            if meter.name == name:
                return meter
        raise KeyError(f"there is no meter {name!r}; there are {[meter.name for meter in self.meters]}")


def meters(text: str) -> meter_pb2.MeterList:
    """Meters as a file of them has them. ValueError, with line and column, for text that is none."""
    parsed = meter_pb2.MeterList()
    try:
        text_format.Parse(text, parsed)
    except text_format.ParseError as error:
        raise ValueError(str(error)) from None
    return parsed


def measure(
    scene: Scene | str | Path,
    meters: meter_pb2.MeterList | str | Path,
    *,
    error: float | None = None,
    samples: int | None = None,
    seconds: float | None = None,
    seed: int = 0,
    server: Farm | str | None = None,
    program: str | Path | None = None,
    options: Sequence[str] = (),
) -> Measured:
    """Measures a scene, in code or a file, by meters: a message (proto/tessera/v1/meter.proto, `meters(text)`)
    or a file of them. `error`: goes on until all 95 % intervals are within this part of their figures;
    `samples`: of each figure, where no error is asked for; `seconds`: ends then with what there is.
    `server`: on this farm (HOST:PORT, or a Farm), by default on this machine. `program`: the command line
    `tessera`, by default the farm's, or that of the PATH; `options` are its further ones, such as
    "--integrator=light".

    Warnings become Python's. TesseraError says what is wrong with scene or meters."""
    words = [f"--seed={seed}"]
    words += [f"--error={float(error)}"] if error is not None else []
    words += [f"--samples={samples}"] if samples is not None else []
    words += [f"--time={float(seconds)}"] if seconds is not None else []
    if isinstance(server, Farm):
        words += ["--farm", *server.options()]
        program = program or server.program
    elif server is not None:
        words += ["--farm", "--server", server]
    with tempfile.TemporaryDirectory(prefix="tessera-") as name:
        folder = Path(name)
        output = folder / "figures.json"
        if isinstance(meters, meter_pb2.MeterList) and meters.HasField("series"):
            raise TesseraError("a series is measured by the command line; here, measure a scene for each sky")
        files = [_scene_file(scene, folder), _meter_file(meters, folder)]
        command = ["measure", *map(str, files), "-o", str(output), *words, *options]
        ran = run_program(str(program) if program else None, command)
        if ran.returncode not in (_DONE, _INCOMPLETE) or not output.exists():
            raise TesseraError(_error_of(ran.stderr) or f"tessera measure ended with {ran.returncode}")
        read = json.loads(output.read_text(encoding="utf-8"))
    if "steps" in read:
        raise TesseraError("a series is measured by the command line; here, measure a scene for each sky")
    repeat_warnings(ran.stderr, stacklevel=3)
    return _measured_of(read, ran.returncode == _DONE)


def _scene_file(scene: Scene | str | Path, folder: Path) -> Path:
    if not isinstance(scene, Scene):
        return Path(scene)
    path = folder / "scene.textproto"
    scene.save(path)
    return path


def _meter_file(meters: meter_pb2.MeterList | str | Path, folder: Path) -> Path:
    if not isinstance(meters, meter_pb2.MeterList):
        return Path(meters)
    written = meter_pb2.MeterList()
    written.CopyFrom(meters)
    for meter in written.meters:
        # Weather files are relative to the file of meters, which is another folder's here.
        if meter.HasField("annual_daylight"):
            meter.annual_daylight.weather_file = str(Path(meter.annual_daylight.weather_file).absolute())
    path = folder / "meters.textproto"
    path.write_text(text_format.MessageToString(written), encoding="utf-8")
    return path


def _error_of(text: str) -> str:
    """The program's message, without what it told on the way."""
    at = text.find("tessera: ")
    return text[at:].removeprefix("tessera: ").strip() if at >= 0 else text.strip()


def _number(value: float | None) -> float:
    return math.nan if value is None else value


def _triple(values: list[float] | None) -> Triple | None:
    return None if values is None else (_number(values[0]), _number(values[1]), _number(values[2]))


def _some_triple(values: list[float]) -> Triple:
    return (_number(values[0]), _number(values[1]), _number(values[2]))


def _array(values: Sequence[float], shape: Sequence[int]) -> Doubles:
    return np.array(values, np.float64).reshape(shape)


def _columns(figures: Sequence[Figure], shape: Sequence[int]) -> dict[str, Doubles]:
    return {
        "values": _array([figure.value for figure in figures], shape),
        "standard_errors": _array([figure.standard_error for figure in figures], shape),
        "low": _array([figure.interval[0] for figure in figures], shape),
        "high": _array([figure.interval[1] for figure in figures], shape),
    }


def _figure_of(meter: dict[str, Any], reading: dict[str, Any]) -> Figure:
    return Figure(
        meter["name"],
        meter["quantity"],
        reading["label"],
        _triple(reading["position"]),
        _triple(reading["normal"]),
        _number(reading["value"]),
        meter["unit"],
        _number(reading["standard_error"]),
        (_number(reading["low95"]), _number(reading["high95"])),
        reading["samples"],
        _number(reading["degrees_of_freedom"]),
        meter["integrator"],
    )


def _grid_of(plane: dict[str, Any], figures: Sequence[Figure]) -> Grid:
    shape = (plane["rows"], plane["columns"])
    first: int = plane["first_reading"]
    cells = figures[first : first + shape[0] * shape[1]]
    places = [figure.position or (math.nan,) * 3 for figure in cells]
    return Grid(
        _some_triple(plane["corner"]),
        _some_triple(plane["edge_u"]),
        _some_triple(plane["edge_v"]),
        positions=np.array(places, np.float64).reshape(*shape, 3),
        mean=_number(plane["mean"]["value"]),
        mean_error=_number(plane["mean"]["standard_error"]),
        **_columns(cells, shape),
    )


def _surface_of(mesh: dict[str, Any], figures: Sequence[Figure]) -> Surface:
    triangles = np.array(mesh["triangles"], np.int64).reshape(-1, 3)
    first: int = mesh["first_reading"]
    cells = figures[first : first + len(triangles)]
    return Surface(
        mesh["shape"],
        np.array(mesh["vertices"], np.float64).reshape(-1, 3),
        triangles,
        mean=_number(mesh["mean"]["value"]),
        mean_error=_number(mesh["mean"]["standard_error"]),
        **_columns(cells, (len(triangles),)),
    )


def _meter_of(meter: dict[str, Any]) -> Meter:
    figures = [_figure_of(meter, reading) for reading in meter["readings"]]
    return Meter(
        meter["name"],
        meter["quantity"],
        meter["unit"],
        meter["integrator"],
        meter["warnings"],
        figures,
        [_grid_of(plane, figures) for plane in meter["planes"]],
        [_surface_of(mesh, figures) for mesh in meter["meshes"]],
    )


def _measured_of(read: dict[str, Any], complete: bool) -> Measured:
    return Measured(
        [_meter_of(meter) for meter in read["meters"]],
        complete,
        _number(read["wanted_error"]),
        _number(read["worst_error"]),
        read["worst_meter"],
        _number(read["metres_per_unit"]),
        read["seed"],
        _number(read["cpu_seconds"]),
    )
