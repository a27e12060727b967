"""The cases of the gallery, by task."""

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Entry:
    """A case: what it is, how it is run, what is drawn, and the one thing it teaches."""

    name: str
    task: str
    title: str
    case: str
    teaches: str
    # Keys over the case, as for `--set`.
    set: dict = field(default_factory=dict)
    # Time and field of the picture, or probe columns to plot in its place.
    time: float = float("inf")
    field: str = "pressure"
    plot: tuple = ()
    # Between snapshots [s].
    interval: float = 0.05

    @property
    def settings(self):
        """Keys over the case; the report's pictures of the whole case do not fit a shorter run."""
        return {"outputs.picture_times_s": [0.0], **self.set} if "time.end_time_s" in self.set else self.set


FREE, STILL, SHEAR = "Water with a free surface", "Water at rest", "Flow between walls and drops"
FSI, FLOAT, SOLID = "Water and elastic bodies", "Floating and falling bodies", "Solids alone"
SPACE = "In space"
V = "cases/validation"

ENTRIES = [
    Entry(
        "dam_break", FREE, "Dam break", f"{V}/dam_break.toml",
        "A case needs 21 lines: what it leaves out are settings that suit water.", time=0.3, field="speed",
    ),
    Entry(
        "bore", FREE, "Breaking bore", f"{V}/bore.toml",
        "A wall that moves by an expression of time is a piston.", {"time.end_time_s": 1.6}, time=1.6, field="speed",
        interval=0.2,
    ),
    Entry(
        "drop_on_pool", FREE, "A drop falls into a pool", f"{V}/hard_drop_on_pool.toml",
        "Regions of water may start with velocities of their own.", {"time.end_time_s": 0.3}, time=0.2, field="speed",
    ),
    Entry(
        "wedge", FREE, "A wedge on the floor", f"{V}/hard_wedge.toml",
        "A solid wall of any polygon: slanted faces are layered, not staircases.", {"time.end_time_s": 0.7}, time=0.6,
        field="speed",
    ),
    Entry(
        "ramp", FREE, "A ramp from a drawing", "docs/gallery/cases/ramp.toml",
        "An outline comes from a DXF drawing, here an arc and two lines on a layer of their own.", time=0.5, field="speed",
    ),
    Entry(
        "sloshing", FREE, "Sloshing at resonance", f"{V}/hard_sloshing.toml",
        "A body force may depend on time: shaking the frame shakes the tank.", {"time.end_time_s": 4.0}, time=3.8,
        field="speed", interval=0.1,
    ),
    Entry(
        "rotating_tank", FREE, "A tank that turns over", f"{V}/hard_rotating_tank.toml",
        "Walls turn about a pivot by `angle_rad`.", {"time.end_time_s": 0.8}, time=0.8, field="speed", interval=0.1,
    ),
    Entry(
        "still_water", STILL, "Still water", f"{V}/still_water.toml",
        "A hydrostatic start is in balance: nothing moves, and the pressure is that of the depth.",
        {"time.end_time_s": 0.2}, interval=0.1,
    ),
    Entry(
        "standing_wave", STILL, "Standing wave", f"{V}/standing_wave.toml",
        "Regions have any outline, so that a wave can start with its shape.", {"time.end_time_s": 3.0}, time=0.0,
        interval=0.5,
    ),
    Entry(
        "poiseuille", SHEAR, "Flow between plates", f"{V}/poiseuille.toml",
        "A periodic direction and a body force make a channel; to measure viscosity, artificial viscosity is 0.",
        {"time.end_time_s": 4.0}, field="speed", interval=1.0,
    ),
    Entry(
        "taylor_green", SHEAR, "Taylor-Green vortices", f"{V}/taylor_green.toml",
        "Velocities at the start are expressions of x and y; a box that is periodic both ways has no walls.",
        {"time.end_time_s": 0.4}, field="speed", interval=0.2,
    ),
    Entry(
        "square_patch", SHEAR, "Rotating patch", f"{V}/square_patch.toml",
        "Water in tension stays whole: shifting and tensile control are on by default.", {"time.end_time_s": 1.5},
        field="speed", interval=0.5,
    ),
    Entry(
        "drop", SHEAR, "A drop that stretches", f"{V}/drop.toml",
        "A case without walls and gravity, and probes of second moments that measure an ellipse.", field="speed",
        interval=0.002,
    ),
    Entry(
        "obstacle", FSI, "Dam break on an elastic obstacle", "cases/obstacle.toml",
        "Held parts of a body cut the floor that they stand in.", {"fluid.particle_spacing_m": 0.004}, time=0.2,
        interval=0.02,
    ),
    Entry(
        "gate", FSI, "Elastic gate", f"{V}/elastic_gate.toml",
        "A body that hangs from a clamp lets water pass below it.", {"time.end_time_s": 0.12}, time=0.12,
        interval=0.02,
    ),
    Entry(
        "hydrostatic_plate", FSI, "Water on an aluminium plate", f"{V}/hydrostatic_plate.toml",
        "A stiff plate takes sub-steps of its own while the water takes long ones.", {"time.end_time_s": 0.02},
        interval=0.01,
    ),
    Entry(
        "thin_plate", FSI, "A thin plate between two depths", f"{V}/thin_plate.toml",
        "Water on one side acts on that on the other through a plate that is thinner than about two spacings of the water; "
        "`check` warns. This one has four.",
        {"time.end_time_s": 0.2},
    ),
    Entry(
        "flap", FSI, "A flap in a full channel", f"{V}/closed_channel_flap.toml",
        "A start pressure keeps a full channel from tearing behind a flap.", {"time.end_time_s": 1.0}, field="speed",
        interval=0.5,
    ),
    Entry(
        "baffle", FSI, "Sloshing with an elastic baffle", "docs/gallery/cases/baffle.toml",
        "A shaken tank with a clamped baffle: a body force of time, a support in the floor.", time=1.4, field="speed",
        interval=0.1,
    ),
    Entry(
        "plate_behind", FSI, "A plate behind a dam break", "docs/gallery/cases/plate_behind.toml",
        "The load on a plate from two probes: the force of the water and the reaction of the clamp.",
        plot=("load_force_x*", "clamp_force_x*"),
    ),
    Entry(
        "floating_body", FLOAT, "A floating block", "cases/floating_body.toml",
        "A rigid body floats at its draught, and its heave decays.", {"fluid.particle_spacing_m": 0.01, "time.end_time_s": 1.5},
        plot=("block_centre_y*",),
    ),
    Entry(
        "floating_box", FLOAT, "A floating box in waves", "docs/gallery/cases/floating_box.toml",
        "A paddle is a moving solid wall; a free body drifts, heaves and rolls.", time=2.0, field="speed", interval=0.1,
    ),
    Entry(
        "light_float", FLOAT, "A float lighter than a row of water", f"{V}/light_float.toml",
        "Very light bodies need implicit coupling: `[interface] iterate = {}`.", {"time.end_time_s": 0.1},
        plot=("*centre_y*",),
    ),
    Entry(
        "debris", FLOAT, "Debris against a plate", "cases/drifting_body_coarse.toml",
        "Bodies touch without stating pairs: contact is on for all of them.", {"time.end_time_s": 0.3}, time=0.26,
        interval=0.02,
    ),
    Entry(
        "cantilever", SOLID, "Swinging cantilever", f"{V}/cantilever_6.toml",
        "A case without water has solids only; a period comes from a probe of the tip.", {"time.end_time_s": 0.6},
        plot=("*displacement_y*",),
    ),
    Entry(
        "rings", SOLID, "Two rubber rings collide", f"{V}/rings_fast.toml",
        "Bodies start with velocities and rebound by contact.", time=0.005, interval=0.001, field="von_mises",
    ),
    Entry(
        "stack", SOLID, "A stack of rubber blocks", f"{V}/contact_stack.toml",
        "Friction is one number; contact forces are probes.", {"time.end_time_s": 0.3}, interval=0.1, field="von_mises",
    ),
    Entry(
        "fold", SOLID, "A plate that folds on itself", f"{V}/contact_fold.toml",
        "A body that bends far touches itself.", time=0.02, interval=0.002, field="von_mises",
    ),
    Entry(
        "shapes", SPACE, "Shapes in a dam break", "cases/shapes_3d.toml",
        "In space plane shapes are extruded or revolved.", {"time.end_time_s": 0.25}, time=0.25, field="speed",
    ),
    Entry(
        "slope", SPACE, "A block slides down a slope", "cases/slope_3d.toml",
        "Gravity may be turned in place of the slope.", {"time.end_time_s": 0.1}, plot=("*velocity_*",),
    ),
    Entry(
        "plate_3d", SPACE, "A plate that is wet on both sides", "cases/plate_3d.toml",
        "No water passes through a plate of two rows. It is one spacing of the water thick, and `check` warns: water on one "
        "side acts on that on the other.", {"time.end_time_s": 0.03}, interval=0.01,
    ),
]
