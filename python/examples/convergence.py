"""How error falls with samples: a scene at growing sample counts, with both ways to sample, against a reference of
many samples, on a farm; and a diagram of it.

    python3 convergence.py plot.png [SCENE] [--server HOST:PORT] [--most 256]

Without SCENE, one that is built here. Jobs of one seed go on from one another's samples: the coordinator takes over
what it has. So each count has a seed of its own here, and its error is independent of the others.
"""

from __future__ import annotations

import argparse
from typing import Any

import matplotlib
import numpy as np
import tessera

matplotlib.use("Agg")  # no window
from matplotlib import pyplot  # noqa: E402


def courtyard() -> tessera.Scene:
    """Two walls and a floor, lit by a small lamp behind a wall: mostly by light that was reflected."""
    scene = tessera.Scene("courtyard")
    white = scene.diffuse("white", 0.75)
    red = scene.diffuse("red", (0.7, 0.15, 0.1))
    scene.box((-3, -0.1, -3), (3, 0, 3), white)
    scene.box((-3, 0, -3.1), (3, 3, -3), white)
    scene.box((-3.1, 0, -3), (-3, 3, 3), red)
    scene.box((-0.5, 0, -1.6), (1.5, 1.5, -1.4), white)
    scene.sphere(0.15, (0.5, 0.7, -2.3), emission=60.0)
    scene.camera(tessera.look_at((3.5, 3, 5), (-0.5, 0.7, -1)), fov=40)
    scene.film(96, 72)
    return scene


def relative_error(test: Any, reference: Any) -> float:
    """The root of relMSE, as `tessera compare` has it: epsilon 0.01."""
    return float(np.sqrt(np.mean((test - reference) ** 2 / (reference**2 + 0.01))))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("output", help="the diagram, .png or .svg")
    parser.add_argument("scene", nargs="?", help="a scene file, which the program tessera reads")
    parser.add_argument("--server", help="the coordinator; by default $TESSERA_SERVER")
    parser.add_argument("--tls", help="a client's certificates; by default $TESSERA_TLS")
    parser.add_argument("--most", type=int, default=256, help="samples of the longest test")
    options = parser.parse_args()

    counts = [2**i for i in range(options.most.bit_length())]
    with tessera.Farm(options.server, tls=options.tls) as farm:

        def submit(spp: int, sampler: str, seed: int) -> tessera.Job:
            if options.scene:
                words = [f"--spp={spp}", f"--sampler={sampler}", f"--seed={seed}"]
                return farm.submit_file(options.scene, *words)
            scene = courtyard()
            scene.settings.spp, scene.settings.seed = spp, seed
            scene.settings.sampler = {"sobol": 1, "independent": 2}[sampler]  # type: ignore[assignment]
            return farm.submit(scene, comment="convergence")

        # 32 times the samples of the longest test: a fiftieth of its variance is the reference's.
        reference = submit(32 * options.most, "sobol", 0)
        jobs = {
            sampler: [submit(spp, sampler, seed + 1) for seed, spp in enumerate(counts)]
            for sampler in ("sobol", "independent")
        }
        truth = reference.fetch().rgb
        errors = {
            sampler: [relative_error(job.fetch().rgb, truth) for job in row] for sampler, row in jobs.items()
        }

    figure, axes = pyplot.subplots(figsize=(6, 4))
    for sampler, row in errors.items():
        slope = np.polyfit(np.log(counts), np.log(row), 1)[0]
        axes.loglog(counts, row, "o-", label=f"{sampler}: samples^{slope:.2f}")
        print(f"{sampler}: " + ", ".join(f"{spp}: {error:.4f}" for spp, error in zip(counts, row)))
    axes.set_xlabel("samples a pixel")
    axes.set_ylabel("relative error")
    axes.grid(True, which="both", alpha=0.3)
    axes.legend()
    figure.tight_layout()
    figure.savefig(options.output, dpi=120)


if __name__ == "__main__":
    main()
