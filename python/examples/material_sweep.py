"""A sweep of a material over a farm: roughness by metallic, one job a picture, all of them at once, and a contact
sheet of what comes back.

    python3 material_sweep.py sheet.png [--server HOST:PORT] [--spp 64]
"""

from __future__ import annotations

import argparse

import numpy as np
import tessera


def ball(roughness: float, metallic: float, spp: int) -> tessera.Scene:
    """A ball of the material on a chequered table, under a long lamp and a faint sky."""
    scene = tessera.Scene(f"ball r={roughness:.2f} m={metallic:.2f}")
    tiles = scene.checkerboard("tiles", 0.6, 0.25, (12, 12))
    table = scene.diffuse("table", tiles)
    paint = scene.principled("paint", (0.75, 0.35, 0.12), roughness=roughness, metallic=metallic)
    corners = np.array([(-4, 0, -4), (4, 0, -4), (4, 0, 4), (-4, 0, 4)])
    uvs = [(0, 0), (1, 0), (1, 1), (0, 1)]
    scene.mesh(corners, np.array([(0, 2, 1), (0, 3, 2)]), table, uvs=uvs)
    scene.sphere(1.0, (0, 1, 0), paint)
    lamp = [(-2.5, 3.5, 1.0), (2.5, 3.5, 1.0), (2.5, 4.0, 2.5), (-2.5, 4.0, 2.5)]
    scene.rectangle(lamp, emission=5.0, two_sided=True)
    scene.environment((0.25, 0.3, 0.4))
    scene.camera(tessera.look_at((0, 1.9, 4.2), (0, 0.95, 0)), fov=38)
    scene.film(128, 128)
    scene.settings.spp = spp
    return scene


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("output", help="the contact sheet, .png")
    parser.add_argument("--server", help="the coordinator; by default $TESSERA_SERVER")
    parser.add_argument("--tls", help="a client's certificates; by default $TESSERA_TLS")
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--steps", type=int, default=5, help="values of roughness")
    options = parser.parse_args()

    roughness = np.linspace(0.1, 0.9, options.steps)
    metallic = [0.0, 0.5, 1.0]
    with tessera.Farm(options.server, tls=options.tls) as farm:
        # All jobs are there before the first picture is asked for, so that no worker waits for another.
        jobs = [
            [farm.submit(ball(r, m, options.spp), comment="material sweep") for r in roughness] for m in metallic
        ]
        rows = [np.concatenate([job.fetch().rgb for job in row], axis=1) for row in jobs]
    tessera.write_png(options.output, tessera.to_srgb(np.concatenate(rows, axis=0)))
    print(f"{options.output}: roughness {roughness[0]:.2f} to {roughness[-1]:.2f}, metallic {metallic}")


if __name__ == "__main__":
    main()
