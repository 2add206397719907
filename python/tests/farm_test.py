"""Jobs of a real farm from Python."""

from __future__ import annotations

import hashlib
import hmac
import http.server
import json
import queue
import tempfile
import threading
import unittest
import unittest.mock
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import tessera
from farm_under_test import FarmUnderTest, read_exr, small_scene
from tessera import _job
from tessera.results import Assembler, decode_tile
from tessera.v1 import blob_pb2, job_pb2, settings_pb2


class FarmTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls) -> None:
        cls.under_test = FarmUnderTest()
        cls.farm = cls.under_test.connect()

    @classmethod
    def tearDownClass(cls) -> None:
        cls.farm.close()
        cls.under_test.__exit__(None, None, None)

    def assert_same_bits(self, picture: tessera.Picture, file: Path) -> None:
        planes = read_exr(file)
        self.assertEqual(sorted(planes), sorted(picture.channels))
        for name, plane in planes.items():
            self.assertEqual(plane.tobytes(), picture.channels[name].tobytes(), name)

    def test_a_picture_has_the_bits_of_fetch_and_of_render(self) -> None:
        scene = small_scene(spp=24)  # no power of two
        job = self.farm.submit(scene, aovs=["variance", "samples", "albedo", "id"], comment="for a test")
        states = [progress.state for progress in job.watch()]
        self.assertEqual(states[-1], "done")
        self.assertEqual(job.wait().status.comment, "for a test")
        picture = job.fetch()
        self.assertIsNone(picture.missing)
        self.assertEqual(picture.rgb.shape, (40, 48, 3))
        self.assertEqual(picture["albedo"].shape, (40, 48, 3))
        fetched = self.under_test.path / "fetched.exr"
        self.under_test.run("fetch", job.id, "-o", str(fetched), "--quiet")
        self.assert_same_bits(picture, fetched)
        # The same scene from a file, rendered by the program from a spec of its own.
        file = self.under_test.path / "scene.textproto"
        scene.save(file)
        words = ("--aov=variance,samples,albedo,id", "--fresh")
        with self.assertWarnsRegex(UserWarning, "^pixels do not share .* because of --aov variance"):
            other = self.farm.submit_file(file, *words)
        other.wait()
        self.assertEqual(other.fetch().rgb.tobytes(), picture.rgb.tobytes())

    def test_specs_are_those_of_the_program(self) -> None:
        for change in (
            lambda settings, film: None,
            lambda settings, film: setattr(settings, "spp", 100),
            lambda settings, film: (setattr(settings, "noise", 0.1), setattr(settings, "spp", 64)),
            lambda settings, film: setattr(film.filter, "kind", 2),
            lambda settings, film: (setattr(settings, "sampler", 3), setattr(settings, "integrator", "volpath")),
            lambda settings, film: (setattr(settings, "seed", 7), setattr(settings, "max_depth", 0)),
        ):
            scene = small_scene()
            change(scene.settings, scene.message.film)
            if not scene.settings.noise:
                scene.message.views.add().CopyFrom(scene.message.camera)
            own, _ = _job.make_spec(scene, "tester", aovs=["depth"], crop=(3, 5, 41, 40))
            file = self.under_test.path / "spec.textproto"
            scene.save(file)
            job = self.farm.submit_file(file, "--aov=depth", "--crop=3,5,41,40")
            theirs = job.spec
            job.cancel()
            for part in ("view", "samples", "cut"):
                self.assertEqual(getattr(own, part), getattr(theirs, part))
            self.assertEqual(own.content.algorithms, theirs.content.algorithms)

    def test_bands_are_an_array(self) -> None:
        scene = small_scene(spp=4)
        scene.settings.color = settings_pb2.COLOR_SPECTRAL
        scene.settings.film = "spectral:5:400-700"
        job = self.farm.submit(scene)
        job.wait()
        picture = job.fetch()
        self.assertEqual(picture.bands.shape, (40, 48, 5))
        self.assertEqual(picture.band_centres.tolist(), [430, 490, 550, 610, 670])
        self.assertTrue((picture.bands.mean(axis=(0, 1)) > 0).all())
        np.testing.assert_array_equal(picture.bands[..., 2], picture["S0.550,000000nm"])
        fetched = self.under_test.path / "bands.exr"
        self.under_test.run("fetch", job.id, "-o", str(fetched), "--quiet")
        self.assert_same_bits(picture, fetched)

    def test_tiles_come_and_make_the_picture(self) -> None:
        job = self.farm.submit(small_scene(), crop=(8, 4, 44, 40), fresh=True)
        seen = np.zeros((40, 48, 3), np.float32)
        for update in job.updates():
            if isinstance(update, tessera.TileUpdate):
                pixels = update.pixels
                tile = np.stack([update.channels[name] for name in "RGB"], axis=-1)
                seen[pixels.y0 : pixels.y1, pixels.x0 : pixels.x1] = tile
        picture = job.fetch()
        self.assertEqual((picture.data.x0, picture.data.y1), (8, 40))
        np.testing.assert_array_equal(seen[4:40, 8:44], picture.rgb)

    def test_views_come_one_by_one(self) -> None:
        scene = small_scene(spp=4)
        other = scene.message.views.add()
        other.CopyFrom(scene.message.camera)
        other.perspective.fov_degrees *= 2
        job = self.farm.submit(scene)
        self.assertEqual(job.wait().status.units_total, 2 * len(list(self._tiles_of(job))))
        pictures = [job.fetch(view=view) for view in (0, 1)]
        self.assertNotEqual(pictures[0].rgb.tobytes(), pictures[1].rgb.tobytes())
        fetched = self.under_test.path / "views.exr"
        self.under_test.run("fetch", job.id, "-o", str(fetched), "--quiet")
        self.assert_same_bits(pictures[0], fetched)
        self.assert_same_bits(pictures[1], fetched.with_suffix(".v1.exr"))
        with self.assertRaisesRegex(ValueError, "no view 2"):
            job.fetch(view=2)

    @staticmethod
    def _tiles_of(job: tessera.Job) -> Iterator[tessera.TileUpdate]:
        return (update for update in job.updates(view=1) if isinstance(update, tessera.TileUpdate))

    def test_other_integrators_go_through_the_program(self) -> None:
        scene = small_scene(spp=2)
        scene.settings.integrator = "bdpt"
        job = self.farm.submit(scene, comment="two ways")
        self.assertEqual(job.wait().status.comment, "two ways")
        self.assertEqual(job.spec.content.algorithms.integrator, "bdpt")
        self.assertTrue(np.isfinite(job.fetch().rgb).all())

    def test_jobs_are_held_and_given_up(self) -> None:
        scene = small_scene()
        scene.settings.seed = 1
        first = self.farm.submit(scene, priority=3)
        first.pause()
        scene.settings.seed = 2
        second = self.farm.submit(scene, after=[first])
        waits = second.progress
        self.assertEqual((waits.state, list(waits.status.after)), ("queued", [first.id]))
        self.assertIn(first.id, waits.waiting_for)
        self.assertIn(first.id, [job.job_id for job in self.farm.jobs()])
        self.assertEqual(self.farm.job(first.id).id, first.id)
        first.cancel()
        with self.assertRaisesRegex(tessera.JobFailed, f"job {first.id}, .* was cancelled"):
            second.wait()
        with self.assertRaises(tessera.Refused):
            self.farm.submit(scene, after=[first])
        first.delete()
        with self.assertRaises(tessera.NotFound):
            first.progress
        with self.assertRaises(tessera.NotFound):
            self.farm.job("no such job")

    def test_one_scene_may_be_submitted_by_many_at_once(self) -> None:
        """One client has begun to send the scene's blobs, and holds the rest back until the other has been told
        three times that they are being uploaded."""
        scene = small_scene()
        scene.settings.seed = 77
        _, blobs = _job.make_spec(scene, "tester")
        own = blobs[-1]
        others_waits = threading.Semaphore(0)

        def held_back() -> Iterator[blob_pb2.UploadRequest]:
            yield blob_pb2.UploadRequest(blob=own.ref(), data=own.data[:1])
            for _ in range(3):
                others_waits.acquire()
            yield blob_pb2.UploadRequest(data=own.data[1:])

        with self.under_test.connect() as other:
            upload = other._connection._method("stream_unary", "BlobService", "Upload").future(held_back())
            query = blob_pb2.QueryUploadRequest(blob=own.ref())
            while not other._connection.call("BlobService", "QueryUpload", query).stored_bytes:
                pass
            try:
                with unittest.mock.patch("tessera._wire.time.sleep", lambda _: others_waits.release()):
                    job = self.farm.submit(scene)
            finally:
                others_waits.release(3)
            upload.result()
        self.assertEqual(job.wait().state, "done")

    def test_errors_are_named(self) -> None:
        with self.assertRaisesRegex(ValueError, "there is no AOV 'colour'"):
            self.farm.submit(small_scene(), aovs=["colour"])
        with self.assertRaisesRegex(tessera.TesseraError, "there is no file"):
            self.farm.submit_file("/there/is/none.pbrt")
        with self.assertRaisesRegex(tessera.Refused, "webhook"):
            self.farm.submit(small_scene(), webhook="http://127.0.0.1:1/")
        with self.assertRaisesRegex(tessera.Refused, "no encryption"):
            tessera.Farm("10.0.0.1:7070")
        with tessera.Farm("127.0.0.1:1", patience=0) as nobody:
            with self.assertRaises(tessera.Unreachable):
                nobody.jobs()


class RestartTest(unittest.TestCase):
    def test_a_watch_outlives_the_coordinator(self) -> None:
        with FarmUnderTest(workers=0) as under_test, under_test.connect() as farm:
            first = farm.submit(small_scene())
            scene = small_scene()
            scene.settings.seed = 1
            job = farm.submit(scene, after=[first])
            stream = job.updates()
            self.assertEqual(next(stream).state, "queued")
            under_test.stop_server()
            under_test.start_server()
            self.assertEqual(list(job.progress.status.after), [first.id])
            under_test.start_worker()
            last = list(stream)[-1]
            self.assertEqual(last.state, "done")
            self.assertEqual(first.progress.state, "done")


class TlsTest(unittest.TestCase):
    def test_certificates_are_those_of_the_command_line(self) -> None:
        import subprocess

        from farm_under_test import BIN

        with tempfile.TemporaryDirectory() as folder:
            tls = Path(folder) / "tls"
            subprocess.run(
                [BIN / "tessera-server", "--init-tls", tls, "--tls-user", "ann"],
                check=True,
                capture_output=True,
            )
            with FarmUnderTest("--tls", str(tls / "server"), workers=0) as under_test:
                address = under_test.connect().address
                with tessera.Farm(address, tls=tls / "client-ann", user="somebody") as farm:
                    job = farm.submit(small_scene())
                    self.assertEqual(job.progress.status.user, "ann")
                with tessera.Farm(address, patience=0) as stranger:
                    with self.assertRaises(tessera.Unreachable):
                        stranger.jobs()


class WebhookTest(unittest.TestCase):
    def test_the_end_of_a_job_is_told_and_signed(self) -> None:
        told: queue.Queue[tuple[str, dict[str, str], bytes]] = queue.Queue()
        refused = [503, 503]  # answers, before it is taken

        class Receiver(http.server.BaseHTTPRequestHandler):
            def do_POST(self) -> None:
                body = self.rfile.read(int(self.headers["Content-Length"]))
                code = refused.pop() if refused and self.path == "/all" else 200
                self.send_response(302 if self.path == "/jobs/moved" else code)
                self.send_header("Location", "/elsewhere")
                self.end_headers()
                if code == 200:
                    told.put((self.path, dict(self.headers), body))

            def log_message(self, *words: object) -> None:
                pass

        receiver = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Receiver)
        threading.Thread(target=receiver.serve_forever, daemon=True).start()
        url = f"http://127.0.0.1:{receiver.server_address[1]}"
        with tempfile.TemporaryDirectory() as folder:
            key = Path(folder) / "key"
            key.touch(0o600)
            key.write_text("a key of enough bytes\n")
            options = ["--webhook-key", str(key), "--webhook", url + "/all"]
            with FarmUnderTest(*options, "--webhook-allow", url + "/jobs/", workers=0) as under_test:
                with under_test.connect() as farm:
                    with self.assertRaisesRegex(tessera.Refused, "webhook-allow"):
                        farm.submit(small_scene(), webhook=url + "/other")
                    job = farm.submit(small_scene(), webhook=url + "/jobs/mine")
                    job.cancel()
                    heard = {path: (headers, body) for path, headers, body in (told.get(), told.get())}
                    farm.submit(small_scene(), webhook=url + "/jobs/moved").cancel()
                    later = {told.get()[0], told.get()[0]}
        receiver.shutdown()
        receiver.server_close()
        self.assertEqual(set(heard), {"/all", "/jobs/mine"})
        self.assertEqual(later, {"/all", "/jobs/moved"}, "and what it points to is not called")
        for headers, body in heard.values():
            message = json.loads(body)
            self.assertEqual((message["job"], message["state"]), (job.id, "cancelled"))
            text = headers["X-Tessera-Timestamp"].encode() + b"." + body
            digest = hmac.new(b"a key of enough bytes", text, hashlib.sha256).hexdigest()
            self.assertEqual(headers["X-Tessera-Signature"], "v1=" + digest)


class HostileTest(unittest.TestCase):
    def test_damaged_results_are_refused_by_name(self) -> None:
        random = np.random.default_rng(5)
        with FarmUnderTest() as under_test, under_test.connect() as farm:
            job = farm.submit(small_scene(spp=1))
            job.wait()
            payloads = [
                result.payload
                for response in job._watch(status_only=False)
                if not isinstance(response, tessera.Restart)
                for result in response.results
            ]
            spec = job.spec
        decode_tile(payloads[0])
        for payload in payloads[:2]:
            for _ in range(400):
                changed = bytearray(payload)
                for place in random.integers(0, len(changed), random.integers(1, 4)):
                    changed[place] ^= int(random.integers(1, 256))
                changed = changed[: random.integers(0, len(changed) + 1)]
                with self.assertRaisesRegex(tessera.TesseraError, "tile result"):
                    decode_tile(bytes(changed))
        assembler = Assembler(spec)
        tile = decode_tile(payloads[0])
        assembler.add(tile)
        with self.assertRaisesRegex(tessera.TesseraError, "there already"):
            assembler.add(tile)
        spec.cut.crop.CopyFrom(job_pb2.PixelRect(x0=40, y0=0, x1=48, y1=8))
        with self.assertRaisesRegex(tessera.TesseraError, "not inside"):
            Assembler(spec).add(tile)


if __name__ == "__main__":
    unittest.main()
