"""Pictures of the tutorials, from the results that they left.

    python3 docs/site/tutorials.py --keep FOLDER && python3 docs/site/pictures.py FOLDER
"""

import pathlib
import sys

import images

import tidelock

PICTURES = pathlib.Path(__file__).resolve().parents[1] / "pictures"


def main():
    folder = pathlib.Path(sys.argv[1])
    dam = tidelock.open(folder / "first_picture" / "results" / "dam")
    wall = tidelock.open(folder / "first_case" / "results" / "wall")
    plate = tidelock.open(folder / "flexible_structure" / "results" / "dam_plate")
    drawn = {
        "dam": dam.plot_snapshot(0.3),
        "first_probes": wall.plot_probes("front_*", "foot_pressure_pa"),
        "first_splash": wall.plot_snapshot(0.36, field="speed"),
        "dam_plate": plate.plot_snapshot(0.25),
        "plate_forces": plate.plot_forces(),
        "plate_ledger": plate.plot_ledger(),
    }
    PICTURES.mkdir(exist_ok=True)
    for name, plot in drawn.items():
        print(name, images.save(plot, PICTURES / f"{name}.png"), "bytes")


if __name__ == "__main__":
    main()
