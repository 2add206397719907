"""A farm: submitting jobs, watching them, taking their pictures."""

from __future__ import annotations

import getpass
import os
import re
import tempfile
import uuid
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType

from tessera import _job
from tessera._program import repeat_warnings, run_program
from tessera._wire import (
    MAX_FIND_MISSING,
    Connection,
    JobFailed,
    NotFound,
    TesseraError,
    Unreachable,
)
from tessera.results import Assembler, Floats, Picture, Rect, decode_tile, pixel_values
from tessera.scene import Blob, Scene
from tessera.v1 import blob_pb2, farm_pb2, job_pb2

_OVER = (job_pb2.DONE, job_pb2.FAILED, job_pb2.CANCELLED, job_pb2.INCOMPLETE)


@dataclass(frozen=True)
class Progress:
    """How far a job is. `state`: queued, running, done, failed, cancelled or incomplete."""

    job_id: str
    state: str
    fraction: float  # of its units, 0 to 1
    seconds: float  # since it was submitted, until its end
    seconds_left: float | None  # by the pace of the last minutes; None: not known
    workers: int  # that hold units of it
    waiting_for: str  # why nobody works on it; empty when somebody does
    error: str
    status: job_pb2.JobStatus  # all that the coordinator tells

    @property
    def is_over(self) -> bool:
        return self.status.state in _OVER

    @staticmethod
    def of(status: job_pb2.JobStatus) -> Progress:
        return Progress(
            status.job_id,
            job_pb2.JobState.Name(status.state).lower(),
            status.units_done / max(status.units_total, 1),
            status.elapsed_ms / 1e3,
            status.left_ms / 1e3 if status.left_ms else None,
            status.workers,
            status.waiting_for,
            status.error,
            status,
        )


@dataclass(frozen=True)
class TileUpdate:
    """Some pixels of a picture as they are now, with `samples` samples at most."""

    pixels: Rect
    samples: int
    channels: dict[str, Floats]  # (height, width)


@dataclass(frozen=True)
class Restart:
    """Results turned out to be wrong: what came before is void."""


def _view_of(unit: job_pb2.WorkUnit) -> int:
    """-1 for units that are not of the picture."""
    if unit.HasField("tile"):
        return unit.tile.view
    unit_of_pass: job_pb2.PassUnit = getattr(unit, "pass")
    return unit_of_pass.view if unit.HasField("pass") else -1


class Job:
    """A job of a farm, by its id."""

    def __init__(self, farm: Farm, job_id: str) -> None:
        self._farm = farm
        self.id = job_id

    def __repr__(self) -> str:
        return f"Job({self.id!r})"

    def _get(self) -> farm_pb2.GetJobResponse:
        request = farm_pb2.GetJobRequest(job_id=self.id)
        answer: farm_pb2.GetJobResponse = self._farm._connection.call("FarmService", "GetJob", request)
        return answer

    @property
    def spec(self) -> job_pb2.JobSpec:
        return self._get().spec

    @property
    def progress(self) -> Progress:
        return Progress.of(self._get().status)

    def _watch(self, status_only: bool) -> Iterator[farm_pb2.WatchJobResponse | Restart]:
        """The coordinator's news until the job is over, each result once; a break is bridged."""
        after, revision, ended = 0, 0, False
        while not ended:
            request = farm_pb2.WatchJobRequest(job_id=self.id, after=after, status_only=status_only)
            stream = self._farm._connection.retried_stream("FarmService", "WatchJob", request)
            for response in stream:
                if after and response.status.revision != revision:
                    after = 0
                    yield Restart()
                    break
                revision = response.status.revision
                fresh = [result for result in response.results if result.sequence > after]
                del response.results[:]
                response.results.extend(fresh)
                if fresh:
                    after = fresh[-1].sequence
                ended = response.status.state in _OVER
                yield response
            else:
                if not ended:
                    raise Unreachable("WatchJob: the stream ended before the job")

    def watch(self) -> Iterator[Progress]:
        """The job's progress, at least every second, until it is over."""
        for response in self._watch(status_only=True):
            if not isinstance(response, Restart):
                yield Progress.of(response.status)

    def wait(self) -> Progress:
        """Until the job is over. JobFailed where it has not all of its picture."""
        last = None
        for last in self.watch():
            pass
        assert last is not None
        if last.state != "done":
            raise JobFailed(f"job {self.id} is {last.state}: {last.error}")
        return last

    def updates(self, view: int = 0) -> Iterator[TileUpdate | Progress | Restart]:
        """Tiles of a view as they come, in the order of the journal, with progress between them, until the job
        is over. A tile comes several times, each time with more samples."""
        spec = self.spec
        assembler = Assembler(spec)
        for response in self._watch(status_only=False):
            if isinstance(response, Restart):
                assembler = Assembler(spec)
                yield response
                continue
            for result in response.results:
                if _view_of(result.unit) != view:
                    continue
                node = assembler.add(decode_tile(result.payload))
                values = pixel_values(node)
                channels = {channel.name: values[c] for c, channel in enumerate(node.channels)}
                yield TileUpdate(node.pixels, node.end - node.begin, channels)
            yield Progress.of(response.status)

    def fetch(self, partial: bool = False, view: int = 0) -> Picture:
        """The job's picture, once it is over, with the bits of `tessera fetch`: of jobs with several views, that
        of one. With `partial`, what there is now. JobFailed where not all of it is there, unless `partial`;
        ValueError where the job has no such view."""
        answer = self._get()
        if not 0 <= view < max(answer.spec.cut.views, 1):
            raise ValueError(f"job {self.id} has no view {view}")
        assembler, units = Assembler(answer.spec), 0
        last = answer.status
        for response in self._watch(status_only=False):
            if isinstance(response, Restart):
                assembler, units = Assembler(answer.spec), 0
                continue
            for result in response.results:
                if _view_of(result.unit) == view:
                    assembler.add(decode_tile(result.payload))
                units += 1
            last = response.status
            if partial and (units >= answer.status.units_done or not response.results):
                break
        if last.state != job_pb2.DONE and not partial:
            state = job_pb2.JobState.Name(last.state).lower()
            raise JobFailed(f"job {self.id} is {state}: {last.error}; partial=True takes what there is")
        return assembler.picture()

    def _changed(self, name: str, request: object) -> Progress:
        return Progress.of(self._farm._connection.call("FarmService", name, request).status)

    def cancel(self) -> Progress:
        return self._changed("CancelJob", farm_pb2.CancelJobRequest(job_id=self.id))

    def pause(self) -> Progress:
        return self._changed("AdjustJob", farm_pb2.AdjustJobRequest(job_id=self.id, paused=True))

    def resume(self) -> Progress:
        return self._changed("AdjustJob", farm_pb2.AdjustJobRequest(job_id=self.id, paused=False))

    def set_priority(self, priority: int) -> Progress:
        """Higher goes first."""
        request = farm_pb2.AdjustJobRequest(job_id=self.id, priority=priority)
        return self._changed("AdjustJob", request)

    def retry(self) -> Progress:
        """Puts units that were set aside back, with a clean record."""
        return self._changed("RetryJob", farm_pb2.RetryJobRequest(job_id=self.id))

    def delete(self) -> None:
        """Forgets a job that is over, and its results."""
        request = farm_pb2.DeleteJobRequest(job_id=self.id)
        self._farm._connection.call("FarmService", "DeleteJob", request)


class Farm:
    """A connection to a coordinator. Several threads may use it."""

    def __init__(
        self,
        address: str | None = None,
        *,
        tls: str | Path | None = None,
        allow_insecure: bool = False,
        user: str | None = None,
        patience: float = 30,
        program: str | Path | None = None,
    ) -> None:
        """`address`: HOST:PORT, by default $TESSERA_SERVER or 127.0.0.1:7070. `tls`: a folder with a client's
        certificates, by default $TESSERA_TLS. `patience`: seconds for which a coordinator that does not answer
        is tried. `program`: the command line `tessera`, for scene files; by default that of the PATH."""
        self.address = address or os.environ.get("TESSERA_SERVER") or "127.0.0.1:7070"
        self._tls = tls or os.environ.get("TESSERA_TLS") or None
        self._allow_insecure = allow_insecure
        self.user = user or _user_name()
        self.program = str(program) if program else None
        self._connection = Connection(self.address, self._tls, allow_insecure, patience)

    def close(self) -> None:
        self._connection.close()

    def __enter__(self) -> Farm:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    # ---- looking

    def jobs(self) -> list[Progress]:
        answer = self._connection.call("FarmService", "ListJobs", farm_pb2.ListJobsRequest())
        return [Progress.of(status) for status in answer.jobs]

    def workers(self) -> list[farm_pb2.WorkerStatus]:
        answer = self._connection.call("FarmService", "ListWorkers", farm_pb2.ListWorkersRequest())
        return list(answer.workers)

    def job(self, job_id: str) -> Job:
        """A job by its id, or by a beginning of it that no other has. NotFound where there is none."""
        found = [job.job_id for job in self.jobs() if job.job_id.startswith(job_id)]
        if len(found) != 1 and job_id not in found:
            what = "there is no job" if not found else f"{len(found)} jobs begin with"
            raise NotFound(f"{what} {job_id}")
        return Job(self, job_id if job_id in found else found[0])

    # ---- submitting

    def submit(
        self,
        scene: Scene,
        *,
        name: str | None = None,
        comment: str = "",
        priority: int = 0,
        after: Sequence[Job | str] = (),
        required_tags: Sequence[str] = (),
        max_workers: int = 0,
        webhook: str = "",
        aovs: Sequence[str] = (),
        crop: tuple[int, int, int, int] | None = None,
        resolution: tuple[int, int] | None = None,
        fresh: bool = False,
    ) -> Job:
        """Uploads what the coordinator lacks of the scene, and submits a job that renders it as
        `scene.settings` has it. `after`: jobs that have to be done first. `aovs`: further channels (variance,
        albedo, normal, depth, samples, alpha, id). `fresh`: nothing is taken over from other jobs.

        Scenes for other integrators than path, volpath and direct go through the program `tessera`."""
        ids = [job.id if isinstance(job, Job) else job for job in after]
        if (scene.message.settings.integrator or "path") not in _job.DIRECT:
            words = _words(name, comment, priority, ids, required_tags, max_workers, webhook, aovs, crop)
            if resolution:
                words += ["--resolution", f"{resolution[0]}x{resolution[1]}"]
            with tempfile.TemporaryDirectory(prefix="tessera-") as folder:
                path = Path(folder) / "scene.textproto"
                scene.save(path)
                return self.submit_file(path, *words, *(["--fresh"] if fresh else []))
        spec, blobs = _job.make_spec(scene, self.user, aovs=aovs, crop=crop, resolution=resolution)
        farm = spec.farm
        farm.name = name or farm.name
        farm.comment, farm.priority, farm.max_workers = comment, priority, max_workers
        farm.webhook = webhook
        farm.after.extend(ids)
        farm.required_tags.extend(required_tags)
        self._upload(blobs)
        request = farm_pb2.SubmitJobRequest(request_id=uuid.uuid4().hex, spec=spec, fresh=fresh)
        answer = self._connection.call("FarmService", "SubmitJob", request, timeout=120)
        return Job(self, answer.job_id)

    def submit_file(self, scene: str | Path, *options: str) -> Job:
        """Submits a scene file (pbrt, Mitsuba, Tessera's own ...) by the program `tessera`, whose importers
        read it; `options` are those of `tessera submit`. The program's warnings become Python's."""
        words = ["submit", str(scene), "--detach", *self.options(), "--user", self.user, *options]
        ran = run_program(self.program, words)
        found = re.search(r"^job ([0-9a-f]+)$", ran.stdout, re.MULTILINE)
        if ran.returncode or not found:
            raise TesseraError(ran.stderr.strip() or f"tessera submit ended with {ran.returncode}")
        repeat_warnings(ran.stderr, stacklevel=3)
        return Job(self, found[1])

    def options(self) -> list[str]:
        """The options by which the program `tessera` finds this farm."""
        words = ["--server", self.address]
        words += ["--tls", str(self._tls)] if self._tls else []
        return words + (["--allow-insecure"] if self._allow_insecure else [])

    def _upload(self, blobs: Sequence[Blob]) -> None:
        by_digest = {blob.digest: blob for blob in blobs}
        refs = [blob.ref() for blob in by_digest.values()]
        for begin in range(0, len(refs), MAX_FIND_MISSING):
            request = blob_pb2.FindMissingRequest(blobs=refs[begin : begin + MAX_FIND_MISSING])
            answer = self._connection.call("BlobService", "FindMissing", request)
            for ref in answer.missing:
                self._connection.upload(by_digest[ref.digest])


def _user_name() -> str:
    try:
        return getpass.getuser()
    except (ImportError, KeyError, OSError):  # no such user, as in a container: another one by version
        return f"uid-{os.geteuid()}"


def _words(
    name: str | None,
    comment: str,
    priority: int,
    after: Sequence[str],
    required_tags: Sequence[str],
    max_workers: int,
    webhook: str,
    aovs: Sequence[str],
    crop: tuple[int, int, int, int] | None,
) -> list[str]:
    """The options of `tessera submit`; a job has its scene's name there."""
    if name:
        raise ValueError("a scene for this integrator gives its job its own name: Scene(name)")
    words = [f"--comment={comment}", f"--priority={priority}", f"--max-workers={max_workers}"]
    lists = {"after": after, "require": required_tags, "aov": aovs}
    words += [f"--{option}={','.join(values)}" for option, values in lists.items() if values]
    words += [f"--webhook={webhook}"] if webhook else []
    words += [f"--crop={','.join(str(edge) for edge in crop)}"] if crop else []
    return words
