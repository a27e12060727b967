"""Tables of a case file, made from its JSON Schema by solvers/python/case_types.py; do not edit."""

from typing import Any, Literal, NotRequired, TypeAlias, TypedDict


class BodyForce(TypedDict):
    """Accelerations of everything that moves freely, water and solids."""

    # acceleration added to gravity, for example by a shaken tank.  Unit: m/s². Default: none. Range: a finite number
    # or an expression of the coordinates and t for each axis.
    acceleration_m_s2: NotRequired[list[float | str]]
    # constant acceleration, such as [0.0, -9.81].  Unit: m/s². Default: 0 along each axis. Range: a finite number for
    # each axis.
    gravity_m_s2: NotRequired[list[float]]


class Checkpoint(TypedDict):
    """States from which an interrupted run continues, see docs/operation.md."""

    # steps between checkpoints.  Unit: steps. Default: off. Range: a whole number from 1 to 999999999.
    every_steps: NotRequired[int]
    # wall time between checkpoints.  Unit: s. Default: 300. Range: a number above 0 and at most 1e9.
    every_wall_s: NotRequired[float]
    # largest number of restarts of lost servers.  Unit: -. Default: 3. Range: a whole number from 0 to 1000.
    max_restarts: NotRequired[int]


class Deadlines(TypedDict):
    """Longest waits, after which a server counts as lost, see docs/operation.md."""

    # longest wait for an answer of a server.  Unit: s. Default: 30. Range: a number from 1 to 1e6.
    call_s: NotRequired[float]
    # longest wait for the disk to take outputs.  Unit: s. Default: 60. Range: a number from 1 to 1e6.
    disk_s: NotRequired[float]
    # longest wait for a server's set-up.  Unit: s. Default: 300. Range: a number from 1 to 1e6.
    open_s: NotRequired[float]
    # longest wait for a sign of life of a server.  Unit: s. Default: 20. Range: a number from 3 to 1e6.
    silence_s: NotRequired[float]
    # shortest deadline of a step.  Unit: s. Default: 60. Range: a number from 1 to 1e6.
    step_s: NotRequired[float]


class Domain(TypedDict):
    """The box that contains the scene; the number of its coordinates is the number of dimensions of the case."""

    # a corner of the square lattice on which all particles are placed.  Unit: m. Default: `lower_m`. Range: a finite
    # number for each axis.
    lattice_origin_m: NotRequired[list[float]]
    # lower corner of the box: two numbers for a case of the plane, three for one in space.  Unit: m. Default: must be
    # written. Range: a finite number for each axis.
    lower_m: list[float]
    # sides through which particles may leave; a particle that crosses another side has escaped, see
    # `lost_particle_limit`.  - `left`: toward lower x, in the plane - `right`: toward higher x, in the plane -
    # `bottom`: toward lower y, in the plane - `top`: toward higher y, in the plane - `-x`: toward lower x, in space -
    # `+x`: toward higher x, in space - `-y`: toward lower y, in space - `+y`: toward higher y, in space - `-z`:
    # toward lower z, in space - `+z`: toward higher z, in space  Unit: -. Default: open sides of containers that
    # reach the domain's side. Range: a list of some of "left", "right", "bottom", "top", "-x", "+x", "-y", "+y",
    # "-z", "+z".
    outflow_sides: NotRequired[list[Literal['left', 'right', 'bottom', 'top', '-x', '+x', '-y', '+y', '-z', '+z']]]
    # directions in which the scene repeats.  - `x`: along x - `y`: along y - `z`: along z; in space only  Unit: -.
    # Default: `[]`. Range: a list of some of "x", "y", "z".
    periodic: NotRequired[list[Literal['x', 'y', 'z']]]
    # upper corner of the box.  Unit: m. Default: must be written. Range: a finite number for each axis.
    upper_m: list[float]


class Damping(TypedDict):
    """Acceleration −k v on all free particles until a time, to reach a state of rest."""

    # rate k.  Unit: 1/s. Default: must be written. Range: a number above 0.
    rate_per_s: float
    # time at which it ends.  Unit: s. Default: must be written. Range: a finite number.
    until_s: float


class ShapeRectangle(TypedDict):
    """a rectangle along the axes, in the plane"""

    # lower left corner.  Unit: m. Default: must be written. Range: a finite number for each axis.
    lower_m: list[float]
    # kind of the shape: rectangle, a rectangle along the axes, in the plane
    type: Literal['rectangle']
    # upper right corner.  Unit: m. Default: must be written. Range: a finite number for each axis.
    upper_m: list[float]


class ShapeCircle(TypedDict):
    """a disc, in the plane"""

    # centre.  Unit: m. Default: must be written. Range: a finite number for each axis.
    centre_m: list[float]
    # radius.  Unit: m. Default: must be written. Range: a number above 0.
    radius_m: float
    # kind of the shape: circle, a disc, in the plane
    type: Literal['circle']


class ShapeRing(TypedDict):
    """what lies between two circles, in the plane"""

    # centre.  Unit: m. Default: must be written. Range: a finite number for each axis.
    centre_m: list[float]
    # inner radius.  Unit: m. Default: must be written. Range: a number above 0.
    inner_radius_m: float
    # outer radius.  Unit: m. Default: must be written. Range: a number above 0.
    outer_radius_m: float
    # kind of the shape: ring, what lies between two circles, in the plane
    type: Literal['ring']


class ShapePolygon(TypedDict):
    """a polygon, in the plane"""

    # file of the corners, with columns `x_m` and `y_m`.  Unit: -. Default: must be written. Range: the path of a CSV
    # file, from the folder of the case.
    file: NotRequired[str]
    # kind of the shape: polygon, a polygon, in the plane
    type: Literal['polygon']
    # corners in order, either way around.  Unit: m. Default: must be written. Range: a list of points, each with a
    # finite number for each axis.
    vertices_m: NotRequired[list[list[float]]]


class ShapeOutline(TypedDict):
    """what closed lines of a drawing enclose, less what lines within them enclose, in the plane"""

    # turn about the origin of the drawing, counterclockwise.  Unit: rad. Default: 0. Range: a finite number.
    angle_rad: NotRequired[float]
    # displacement after the turn.  Unit: m. Default: 0 along each axis. Range: a finite number for each axis.
    by_m: NotRequired[list[float]]
    # DXF file in words (ASCII); lines, arcs, circles, ellipses, splines and polylines of the model are read, notes
    # and dimensions are not.  Unit: -. Default: must be written. Range: the path of a DXF file, from the folder of
    # the case.
    file: str
    # the layer that has the lines.  Unit: -. Default: all layers. Range: a name.
    layer: NotRequired[str]
    # largest distance of a curve from the chords that replace it, and of ends that are joined.  Unit: m. Default:
    # 1e-4 of the longer side of the drawing. Range: a number above 0.
    tolerance_m: NotRequired[float]
    # kind of the shape: outline, what closed lines of a drawing enclose, less what lines within them enclose, in the
    # plane
    type: Literal['outline']
    # unit of length of the file.  - `m`: metre - `dm`: 0.1 m - `cm`: 0.01 m - `mm`: 0.001 m - `in`: 0.0254 m - `ft`:
    # 0.3048 m  Unit: -. Default: must be written. Range: "m", "dm", "cm", "mm", "in", "ft".
    unit: Literal['m', 'dm', 'cm', 'mm', 'in', 'ft']


class ShapeBox(TypedDict):
    """a box along the axes, in space"""

    # corner toward lower coordinates.  Unit: m. Default: must be written. Range: a finite number for each axis.
    lower_m: list[float]
    # kind of the shape: box, a box along the axes, in space
    type: Literal['box']
    # corner toward higher coordinates.  Unit: m. Default: must be written. Range: a finite number for each axis.
    upper_m: list[float]


class ShapeSphere(TypedDict):
    """a ball, in space"""

    # centre.  Unit: m. Default: must be written. Range: a finite number for each axis.
    centre_m: list[float]
    # radius.  Unit: m. Default: must be written. Range: a number above 0.
    radius_m: float
    # kind of the shape: sphere, a ball, in space
    type: Literal['sphere']


class ShapeCylinder(TypedDict):
    """a cylinder or a tube, in space"""

    # centre of one end.  Unit: m. Default: must be written. Range: a finite number for each axis.
    from_m: list[float]
    # inner radius of a tube.  Unit: m. Default: 0. Range: a number of 0 or above.
    inner_radius_m: NotRequired[float]
    # radius.  Unit: m. Default: must be written. Range: a number above 0.
    radius_m: float
    # centre of the other end.  Unit: m. Default: must be written. Range: a finite number for each axis.
    to_m: list[float]
    # kind of the shape: cylinder, a cylinder or a tube, in space
    type: Literal['cylinder']


class ShapeCone(TypedDict):
    """a cone or a part of one, in space; one of the radii may be 0"""

    # centre of one end.  Unit: m. Default: must be written. Range: a finite number for each axis.
    from_m: list[float]
    # radius at the one end.  Unit: m. Default: must be written. Range: a number of 0 or above.
    radius_from_m: float
    # radius at the other end.  Unit: m. Default: must be written. Range: a number of 0 or above.
    radius_to_m: float
    # centre of the other end.  Unit: m. Default: must be written. Range: a finite number for each axis.
    to_m: list[float]
    # kind of the shape: cone, a cone or a part of one, in space; one of the radii may be 0
    type: Literal['cone']


class ShapeTorus(TypedDict):
    """a torus, in space"""

    # direction of its axis, of any length.  Unit: -. Default: must be written. Range: a finite number for each axis.
    axis: list[float]
    # centre.  Unit: m. Default: must be written. Range: a finite number for each axis.
    centre_m: list[float]
    # radius of the circle along which the tube runs.  Unit: m. Default: must be written. Range: a number above 0.
    radius_m: float
    # radius of the tube.  Unit: m. Default: must be written. Range: a number above 0.
    tube_radius_m: float
    # kind of the shape: torus, a torus, in space
    type: Literal['torus']


class ShapeExtrusion(TypedDict):
    """a shape of the plane, in x and y of its axes, moved along their third by a height, in space"""

    # height.  Unit: m. Default: must be written. Range: a number above 0.
    height_m: float
    # origin of the section's coordinates.  Unit: m. Default: must be written. Range: a finite number for each axis.
    origin_m: list[float]
    # a shape of the plane.  Unit: -. Default: must be written. Range: a table.
    section: "Shape"
    # kind of the shape: extrusion, a shape of the plane, in x and y of its axes, moved along their third by a height,
    # in space
    type: Literal['extrusion']
    # direction of x of the section, of any length.  Unit: -. Default: [1.0, 0.0, 0.0]. Range: a finite number for
    # each axis.
    x_axis: NotRequired[list[float]]
    # direction of y of the section, of any length.  Unit: -. Default: [0.0, 1.0, 0.0]. Range: a finite number for
    # each axis.
    y_axis: NotRequired[list[float]]


class ShapeRevolution(TypedDict):
    """a shape of the plane turned about an axis, in space: x of the section is the distance from the axis, y the
    height along it"""

    # direction of the axis, of any length.  Unit: -. Default: must be written. Range: a finite number for each axis.
    axis: list[float]
    # origin of the section's coordinates.  Unit: m. Default: must be written. Range: a finite number for each axis.
    origin_m: list[float]
    # a shape of the plane.  Unit: -. Default: must be written. Range: a table.
    section: "Shape"
    # kind of the shape: revolution, a shape of the plane turned about an axis, in space: x of the section is the
    # distance from the axis, y the height along it
    type: Literal['revolution']


class ShapeHalfSpace(TypedDict):
    """what lies behind a plane, to cut other shapes by, in space"""

    # direction away from what lies behind, of any length.  Unit: -. Default: must be written. Range: a finite number
    # for each axis.
    normal: list[float]
    # a point of the plane.  Unit: m. Default: must be written. Range: a finite number for each axis.
    point_m: list[float]
    # kind of the shape: half-space, what lies behind a plane, to cut other shapes by, in space
    type: Literal['half-space']


class ShapePlaced(TypedDict):
    """a shape turned about an axis through the origin, then moved, in space"""

    # angle, right-handed about the axis.  Unit: rad. Default: 0. Range: a finite number.
    angle_rad: NotRequired[float]
    # direction of the axis, of any length; must be written with `angle_rad`.  Unit: -. Default: [0.0, 0.0, 1.0].
    # Range: a finite number for each axis.
    axis: NotRequired[list[float]]
    # displacement after the turn.  Unit: m. Default: 0 along each axis. Range: a finite number for each axis.
    by_m: NotRequired[list[float]]
    # the shape that is placed.  Unit: -. Default: must be written. Range: a table.
    shape: "Shape"
    # kind of the shape: placed, a shape turned about an axis through the origin, then moved, in space
    type: Literal['placed']


class ShapeSurface(TypedDict):
    """what a surface of triangles encloses, in space"""

    # what to do with holes, and with facets that cross, come again or face inward.  - `refuse`: they are errors -
    # `repair`: facets are turned or left out where there is no doubt; what stays is an error - `accept`: the same,
    # and the inside is where the surface winds around at least half a time, whatever else is wrong  Unit: -. Default:
    # "refuse". Range: "refuse", "repair", "accept".
    defects: NotRequired[Literal['refuse', 'repair', 'accept']]
    # STL file, in words or binary.  Unit: -. Default: must be written. Range: the path of an STL file, from the
    # folder of the case.
    file: str
    # kind of the shape: surface, what a surface of triangles encloses, in space
    type: Literal['surface']
    # unit of length of the file.  - `m`: metre - `dm`: 0.1 m - `cm`: 0.01 m - `mm`: 0.001 m - `in`: 0.0254 m - `ft`:
    # 0.3048 m  Unit: -. Default: must be written. Range: "m", "dm", "cm", "mm", "in", "ft".
    unit: Literal['m', 'dm', 'cm', 'mm', 'in', 'ft']


class ShapeUnion(TypedDict):
    """what lies in any of several shapes"""

    # the shapes, at least one.  Unit: -. Default: must be written. Range: a list of tables.
    parts: list["Shape"]
    # kind of the shape: union, what lies in any of several shapes
    type: Literal['union']


class ShapeIntersection(TypedDict):
    """what lies in all of several shapes, in space"""

    # the shapes, at least one.  Unit: -. Default: must be written. Range: a list of tables.
    parts: list["Shape"]
    # kind of the shape: intersection, what lies in all of several shapes, in space
    type: Literal['intersection']


ShapeDifference = TypedDict(
    "ShapeDifference",
    {
        "from": 'Shape',
        "minus": list['Shape'],
        "type": Literal['difference'],
    },
)


Shape: TypeAlias = """
    ShapeRectangle
    | ShapeCircle
    | ShapeRing
    | ShapePolygon
    | ShapeOutline
    | ShapeBox
    | ShapeSphere
    | ShapeCylinder
    | ShapeCone
    | ShapeTorus
    | ShapeExtrusion
    | ShapeRevolution
    | ShapeHalfSpace
    | ShapePlaced
    | ShapeSurface
    | ShapeUnion
    | ShapeIntersection
    | ShapeDifference
"""


class StartRest(TypedDict):
    """no pressure, the rest density"""

    # pressure at the start: rest, no pressure, the rest density
    type: Literal['rest']


class StartHydrostatic(TypedDict):
    """in equilibrium under its weight"""

    # where the rows lie.  - `consistent`: the water is at rest: rows drawn together as the pressure requires, or,
    # with a surface more than a spacing above the whole region, as in a full vessel, rows kept, with the mass of
    # their pressure - `uniform`: the rows are kept, and the column oscillates  Unit: -. Default: "consistent". Range:
    # "consistent", "uniform".
    lattice: NotRequired[Literal['consistent', 'uniform']]
    # height of the free surface, measured against gravity from the origin.  Unit: m. Default: must be written. Range:
    # a finite number.
    surface_m: float
    # pressure at the start: hydrostatic, in equilibrium under its weight
    type: Literal['hydrostatic']


class StartPressure(TypedDict):
    """the pressure of an expression"""

    # masses of the particles.  - `from-density`: the masses fill the lattice cells at the density of the pressure -
    # `rest`: all particles have ρ₀ Δx², in space ρ₀ Δx³  Unit: -. Default: "from-density". Range: "from-density",
    # "rest".
    particle_mass: NotRequired[Literal['from-density', 'rest']]
    # pressure.  Unit: Pa. Default: 0. Range: a finite number or an expression of the coordinates.
    pressure_pa: NotRequired[float | str]
    # pressure at the start: pressure, the pressure of an expression
    type: Literal['pressure']


Start: TypeAlias = """
    StartRest
    | StartHydrostatic
    | StartPressure
"""


class Region(TypedDict):
    """Water at the start."""

    # remove particles inside solids; if false, such particles are an error.  Unit: -. Default: true. Range: true or
    # false.
    cut_by_solids: NotRequired[bool]
    # remove particles inside walls; if false, such particles are an error.  Unit: -. Default: true. Range: true or
    # false.
    cut_by_walls: NotRequired[bool]
    # random displacement of the particles along each axis, at most this fraction of Δx.  Unit: -. Default: 0. Range:
    # a number from 0 to below 0.5.
    displacement_fraction: NotRequired[float]
    # seed of the displacement.  Unit: -. Default: 1. Range: a whole number from 0 to 2^62 − 1.
    displacement_seed: NotRequired[int]
    # a corner of a lattice of its own.  Unit: m. Default: the domain's lattice. Range: a finite number for each axis.
    lattice_origin_m: NotRequired[list[float]]
    # where the particles stand; the mass is that of the shape in every case.  - `auto`: on the lattice where all
    # faces lie between two of its rows, else what suits the shape best, see cases/FORMAT.md - `fitted`: in layers
    # along the faces - `lattice`: on the lattice: faces that do not run along it become staircases  Unit: -. Default:
    # "auto". Range: "auto", "fitted", "lattice".
    layout: NotRequired[Literal['auto', 'fitted', 'lattice']]
    # name of the region.  Unit: -. Default: must be written. Range: 1 to 64 letters, digits, `_` or `-`.
    name: str
    # where the water is.  Unit: -. Default: must be written. Range: a table.
    shape: "Shape"
    # pressure at the start.  Unit: -. Default: `{ type = "rest" }`. Range: a table.
    start: NotRequired["Start"]
    # velocity at the start.  Unit: m/s. Default: 0 along each axis. Range: a finite number or an expression of the
    # coordinates for each axis.
    velocity_m_s: NotRequired[list[float | str]]


Fluid = TypedDict(
    "Fluid",
    {
        "acoustic_damping": NotRequired[float],
        "acoustic_relaxation": NotRequired[float],
        "acoustic_relaxation_time_s": NotRequired[float],
        "artificial_pressure": NotRequired[float],
        "artificial_viscosity_a": NotRequired[float],
        "artificial_viscosity_b": NotRequired[float],
        "artificial_viscosity_form": NotRequired[Literal['residual', 'plain']],
        "artificial_viscosity_solid_share": NotRequired[float],
        "background_pressure_pa": NotRequired[float],
        "damping": NotRequired['Damping'],
        "density_diffusion": NotRequired[Literal['renormalised', 'plain', 'none']],
        "density_diffusion_delta": NotRequired[float],
        "dynamic_viscosity_pa_s": NotRequired[float],
        "equation_of_state": NotRequired[Literal['tait', 'linear']],
        "exponent": NotRequired[float],
        "gradient_correction": NotRequired[Literal['lattice-moment', 'continuity', 'renormalised', 'none']],
        "gradient_correction_share": NotRequired[float],
        "kernel_ratio": NotRequired[float],
        "lambda": NotRequired[float],
        "lost_particle_limit": NotRequired[int],
        "particle_spacing_m": float,
        "region": NotRequired[list['Region']],
        "rest_density_kg_m3": float,
        "scheme": NotRequired[Literal['leapfrog', 'predictor-corrector']],
        "shifting": NotRequired[float],
        "sound_speed_m_s": float,
        "tensile_control": NotRequired[bool],
        "tension_limit_pa": NotRequired[float],
        "viscous_form": NotRequired[Literal['pairwise', 'stress']],
        "volume_correction": NotRequired[float],
        "wall_repulsion": NotRequired[float],
    },
)


class Iterate(TypedDict):
    """Implicit coupling: half-steps are repeated until the forces on each body agree with those that moved it."""

    # largest number of updates in a half-step.  Unit: -. Default: 50. Range: a whole number from 1 to 1000.
    limit: NotRequired[int]
    # relaxation of the updates: a constant factor or a rule.  - `aitken`: a factor that follows from the last two
    # updates  Unit: -. Default: "aitken". Range: a number above 0 and at most 1, or "aitken".
    relaxation: NotRequired[float | Literal['aitken']]
    # convergence tolerance, relative to the sum of magnitudes of the forces on a body.  Unit: -. Default: 1e-6.
    # Range: a number above 0 and below 1.
    tolerance: NotRequired[float]
    # effect of a half-step that has not converged at the limit.  - `stop`: the run ends - `accept`: the run continues
    # and counts it in `summary.json`  Unit: -. Default: "stop". Range: "stop", "accept".
    unsettled: NotRequired[Literal['stop', 'accept']]


class Interface(TypedDict):
    """How fluid and solids act on each other."""

    # implicit coupling, for which `iterate = {}` suffices; implies loads.  Unit: -. Default: explicit coupling.
    # Range: a table.
    iterate: NotRequired["Iterate"]
    # what the solid sends and receives.  - `states`: both sides evaluate the pair law - `loads`: the solid sends
    # coupling points and receives the force on each; with wall laws only  Unit: -. Default: states if both servers
    # offer it, else loads; loads with `iterate`. Range: "states", "loads".
    kind: NotRequired[Literal['states', 'loads']]
    # pair law between fluid and solids.  - `wall`: a solid is a wall along which the fluid slides - `wall-no-slip`:
    # the fluid has the velocity of the solid at its face - `plain-sum`: one sum over all particles, as in the source
    # paper  Unit: -. Default: "wall"; "plain-sum" with the preset "paper". Range: "wall", "wall-no-slip", "plain-
    # sum".
    law: NotRequired[Literal['wall', 'wall-no-slip', 'plain-sum']]
    # margin beyond the support radius up to which interface particles are sent.  Unit: Δx of the fluid. Default: 1.
    # Range: a number above 0 and at most 20.
    margin_spacings: NotRequired[float]
    # path of the half-step frames.  - `direct`: from one server to the other - `relay`: through the coordinator; the
    # results have the same bits  Unit: -. Default: "direct". Range: "direct", "relay".
    path: NotRequired[Literal['direct', 'relay']]
    # coefficient of the repulsion of fluid particles lower than 0.6 Δx over the outer row of a solid, in the wall
    # laws; 0 switches it off.  Unit: -. Default: 1. Range: a number of 0 or above.
    repulsion: NotRequired[float]


class Ledger(TypedDict):
    """The audit of forces, torques and momentum at every half-step."""

    # effect of a failed balance.  - `stop`: the run ends - `warn`: the run continues, and its verdict says so -
    # `stop-and-checkpoint`: the run ends with a checkpoint of the end of the step  Unit: -. Default: "stop". Range:
    # "stop", "warn", "stop-and-checkpoint".
    action: NotRequired[Literal['stop', 'warn', 'stop-and-checkpoint']]
    # largest imbalance of force and torque across the interface, relative to the sum of magnitudes.  Unit: -.
    # Default: 1e-12. Range: a number above 0.
    balance_tolerance: NotRequired[float]
    # largest residual of each side's momentum and angular momentum budget, relative to the sum of magnitudes.  Unit:
    # -. Default: 1e-12. Range: a number above 0.
    momentum_tolerance: NotRequired[float]


class Outputs(TypedDict):
    """What a run leaves behind, and when."""

    # steps between rows of `ledger.csv`.  Unit: steps. Default: 10. Range: a whole number from 1 to 1000000.
    ledger_every_steps: NotRequired[int]
    # times of the report's pictures.  Unit: s. Default: six of the snapshots, evenly spaced. Range: a list, each a
    # finite number.
    picture_times_s: NotRequired[list[float]]
    # time between rows of `probes.csv`.  Unit: s. Default: first and last only. Range: a number above 0.
    probe_interval_s: NotRequired[float]
    # time between snapshots for ParaView.  Unit: s. Default: first and last only. Range: a number above 0.
    snapshot_interval_s: NotRequired[float]


class ProbeFluidPoint(TypedDict):
    """Pressure and velocity at a point, means over the fluid in its support; the pressure follows the body force to
    the point, on the face of a wall too. Zero where there is no fluid."""

    # `at_m` of the kind of probe.  Unit: m. Default: must be written. Range: a finite number for each axis.
    at_m: list[float]
    # name of the probe, the first part of the names of its columns.  Unit: -. Default: must be written. Range: 1 to
    # 64 letters, digits, `_` or `-`.
    name: str
    # what it reports: fluid-point, Pressure and velocity at a point, means over the fluid in its support; the
    # pressure follows the body force to the point, on the face of a wall too. Zero where there is no fluid.
    type: Literal['fluid-point']


class ProbeWaterLevel(TypedDict):
    """Highest connected fluid at an x; not a number where it is dry."""

    # name of the probe, the first part of the names of its columns.  Unit: -. Default: must be written. Range: 1 to
    # 64 letters, digits, `_` or `-`.
    name: str
    # what it reports: water-level, Highest connected fluid at an x; not a number where it is dry.
    type: Literal['water-level']
    # `x_m` of the kind of probe.  Unit: m. Default: must be written. Range: a finite number.
    x_m: float


class ProbeGauge(TypedDict):
    """Free surface along an axis: the farthest place against gravity, at the highest coordinate where gravity does
    not act along the axis, of the connected fluid within a spacing of the line along it through a point; not a
    number where that is dry."""

    # `at_m` of the kind of probe.  Unit: m. Default: must be written. Range: a finite number for each axis.
    at_m: list[float]
    # name of the axis.  Unit: -. Default: must be written. Range: 1 to 64 letters, digits, `_` or `-`.
    axis: str
    # name of the probe, the first part of the names of its columns.  Unit: -. Default: must be written. Range: 1 to
    # 64 letters, digits, `_` or `-`.
    name: str
    # what it reports: gauge, Free surface along an axis: the farthest place against gravity, at the highest
    # coordinate where gravity does not act along the axis, of the connected fluid within a spacing of the line along
    # it through a point; not a number where that is dry.
    type: Literal['gauge']


class ProbeFront(TypedDict):
    """99.5 percentile of x of the connected fluid."""

    # name of the probe, the first part of the names of its columns.  Unit: -. Default: must be written. Range: 1 to
    # 64 letters, digits, `_` or `-`.
    name: str
    # what it reports: front, 99.5 percentile of x of the connected fluid.
    type: Literal['front']


class ProbeFluidSums(TypedDict):
    """Mass, momentum, energies, and second moments about the centre of mass, of a region or of all fluid."""

    # name of the probe, the first part of the names of its columns.  Unit: -. Default: must be written. Range: 1 to
    # 64 letters, digits, `_` or `-`.
    name: str
    # name of the region.  Unit: -. Default: all. Range: 1 to 64 letters, digits, `_` or `-`.
    region: NotRequired[str]
    # what it reports: fluid-sums, Mass, momentum, energies, and second moments about the centre of mass, of a region
    # or of all fluid.
    type: Literal['fluid-sums']


class ProbeFlowRate(TypedDict):
    """Volume flux of the fluid through a segment, positive to the right of the way from its first to its second
    point: Σ V_j v_j·n ∫ W(|x − x_j|) ds; zero where it is dry."""

    # `from_m` of the kind of probe.  Unit: m. Default: must be written. Range: a finite number for each axis.
    from_m: list[float]
    # name of the probe, the first part of the names of its columns.  Unit: -. Default: must be written. Range: 1 to
    # 64 letters, digits, `_` or `-`.
    name: str
    # `to_m` of the kind of probe.  Unit: m. Default: must be written. Range: a finite number for each axis.
    to_m: list[float]
    # what it reports: flow-rate, Volume flux of the fluid through a segment, positive to the right of the way from
    # its first to its second point: Σ V_j v_j·n ∫ W(|x − x_j|) ds; zero where it is dry.
    type: Literal['flow-rate']


class ProbeSurfaceFlux(TypedDict):
    """Volume flux of the fluid in space through the parallelogram with a corner and the two corners next to it,
    positive along (first − corner) × (second − corner): Σ V_j v_j·n ∫ W(|x − x_j|) dA; zero where it is dry."""

    # `corner_m` of the kind of probe.  Unit: m. Default: must be written. Range: a finite number for each axis.
    corner_m: list[float]
    # `first_m` of the kind of probe.  Unit: m. Default: must be written. Range: a finite number for each axis.
    first_m: list[float]
    # name of the probe, the first part of the names of its columns.  Unit: -. Default: must be written. Range: 1 to
    # 64 letters, digits, `_` or `-`.
    name: str
    # `second_m` of the kind of probe.  Unit: m. Default: must be written. Range: a finite number for each axis.
    second_m: list[float]
    # what it reports: surface-flux, Volume flux of the fluid in space through the parallelogram with a corner and the
    # two corners next to it, positive along (first − corner) × (second − corner): Σ V_j v_j·n ∫ W(|x − x_j|) dA; zero
    # where it is dry.
    type: Literal['surface-flux']


class ProbeWallForce(TypedDict):
    """Force of the fluid on a wall."""

    # name of the probe, the first part of the names of its columns.  Unit: -. Default: must be written. Range: 1 to
    # 64 letters, digits, `_` or `-`.
    name: str
    # what it reports: wall-force, Force of the fluid on a wall.
    type: Literal['wall-force']
    # name of the wall.  Unit: -. Default: must be written. Range: 1 to 64 letters, digits, `_` or `-`.
    wall: str


class ProbeImmersedFluid(TypedDict):
    """Number of fluid particles inside solids: those with Σ V W > 1/2 over solid particles, as of the last
    corrector."""

    # name of the probe, the first part of the names of its columns.  Unit: -. Default: must be written. Range: 1 to
    # 64 letters, digits, `_` or `-`.
    name: str
    # what it reports: immersed-fluid, Number of fluid particles inside solids: those with Σ V W > 1/2 over solid
    # particles, as of the last corrector.
    type: Literal['immersed-fluid']


class ProbeMaterialPoint(TypedDict):
    """Displacement, velocity, stress, its invariants and the strain energy of the material at a point of the
    undeformed body; principal stresses are those in the plane."""

    # `at_m` of the kind of probe.  Unit: m. Default: must be written. Range: a finite number for each axis.
    at_m: list[float]
    # name of the body.  Unit: -. Default: must be written. Range: 1 to 64 letters, digits, `_` or `-`.
    body: str
    # name of the probe, the first part of the names of its columns.  Unit: -. Default: must be written. Range: 1 to
    # 64 letters, digits, `_` or `-`.
    name: str
    # what it reports: material-point, Displacement, velocity, stress, its invariants and the strain energy of the
    # material at a point of the undeformed body; principal stresses are those in the plane.
    type: Literal['material-point']


class ProbeBodyMotion(TypedDict):
    """Centre of mass, velocity, angle and angular velocity of a body."""

    # name of the body.  Unit: -. Default: must be written. Range: 1 to 64 letters, digits, `_` or `-`.
    body: str
    # name of the probe, the first part of the names of its columns.  Unit: -. Default: must be written. Range: 1 to
    # 64 letters, digits, `_` or `-`.
    name: str
    # what it reports: body-motion, Centre of mass, velocity, angle and angular velocity of a body.
    type: Literal['body-motion']


class ProbeBodyForce(TypedDict):
    """Force of the fluid on a body."""

    # name of the body.  Unit: -. Default: must be written. Range: 1 to 64 letters, digits, `_` or `-`.
    body: str
    # name of the probe, the first part of the names of its columns.  Unit: -. Default: must be written. Range: 1 to
    # 64 letters, digits, `_` or `-`.
    name: str
    # what it reports: body-force, Force of the fluid on a body.
    type: Literal['body-force']


class ProbeSupportReaction(TypedDict):
    """Reaction of a support on its body."""

    # name of the body.  Unit: -. Default: must be written. Range: 1 to 64 letters, digits, `_` or `-`.
    body: str
    # name of the probe, the first part of the names of its columns.  Unit: -. Default: must be written. Range: 1 to
    # 64 letters, digits, `_` or `-`.
    name: str
    # name of the support.  Unit: -. Default: must be written. Range: 1 to 64 letters, digits, `_` or `-`.
    support: str
    # what it reports: support-reaction, Reaction of a support on its body.
    type: Literal['support-reaction']


class ProbeBodySums(TypedDict):
    """Mass, momentum, energies, and second moments about the centre of mass, of a body or of all."""

    # name of the body.  Unit: -. Default: all. Range: 1 to 64 letters, digits, `_` or `-`.
    body: NotRequired[str]
    # name of the probe, the first part of the names of its columns.  Unit: -. Default: must be written. Range: 1 to
    # 64 letters, digits, `_` or `-`.
    name: str
    # what it reports: body-sums, Mass, momentum, energies, and second moments about the centre of mass, of a body or
    # of all.
    type: Literal['body-sums']


class ProbeGap(TypedDict):
    """Smallest distance from a particle of a body, or of any, to one of another body, and from one that no support
    holds to one of a wall; not a number beyond three spacings."""

    # name of the body.  Unit: -. Default: all. Range: 1 to 64 letters, digits, `_` or `-`.
    body: NotRequired[str]
    # name of the probe, the first part of the names of its columns.  Unit: -. Default: must be written. Range: 1 to
    # 64 letters, digits, `_` or `-`.
    name: str
    # what it reports: gap, Smallest distance from a particle of a body, or of any, to one of another body, and from
    # one that no support holds to one of a wall; not a number beyond three spacings.
    type: Literal['gap']


class ProbeContact(TypedDict):
    """Contact of a body, or of all: forces of other bodies and of walls on it, deepest penetration so far of it into
    others or of others into it, and the sum over its particles and time of the magnitudes of the forces."""

    # name of the body.  Unit: -. Default: all. Range: 1 to 64 letters, digits, `_` or `-`.
    body: NotRequired[str]
    # name of the probe, the first part of the names of its columns.  Unit: -. Default: must be written. Range: 1 to
    # 64 letters, digits, `_` or `-`.
    name: str
    # what it reports: contact, Contact of a body, or of all: forces of other bodies and of walls on it, deepest
    # penetration so far of it into others or of others into it, and the sum over its particles and time of the
    # magnitudes of the forces.
    type: Literal['contact']


Probe: TypeAlias = """
    ProbeFluidPoint
    | ProbeWaterLevel
    | ProbeGauge
    | ProbeFront
    | ProbeFluidSums
    | ProbeFlowRate
    | ProbeSurfaceFlux
    | ProbeWallForce
    | ProbeImmersedFluid
    | ProbeMaterialPoint
    | ProbeBodyMotion
    | ProbeBodyForce
    | ProbeSupportReaction
    | ProbeBodySums
    | ProbeGap
    | ProbeContact
"""


class Run(TypedDict):
    """A member of an ensemble: the same case, disturbed. Without the table no particle is displaced."""

    # displacement of every water particle along each axis, at most this fraction of Δx; masses and densities stay.
    # Unit: -. Default: 0.01. Range: a number above 0 and at most 0.1.
    displacement_fraction: NotRequired[float]
    # decides the displacements: the same ones on any number of threads and any machine.  Unit: -. Default: must be
    # written. Range: a whole number from 0 to 2^62 − 1.
    seed: int


class Servers(TypedDict):
    """Where the solvers come from, see docs/operation.md; by default the built-in ones are started."""

    # certificates (PEM) of the authorities that must have signed those of servers with TLS.  Unit: -. Default: none.
    # Range: the path of a regular file, from the folder of the case.
    ca_file: NotRequired[str]
    # certificate (PEM) to present to servers; with `key_file` and `ca_file`.  Unit: -. Default: none. Range: the path
    # of a regular file, from the folder of the case.
    cert_file: NotRequired[str]
    # address of a fluid server that already listens.  Unit: -. Default: none. Range: HOST:PORT, such as
    # "127.0.0.1:7001", or https://HOST:PORT.
    fluid_address: NotRequired[str]
    # program and arguments that start a fluid server.  Unit: -. Default: none. Range: a list: a program and its
    # arguments, such as ["python3", "solver.py"].
    fluid_command: NotRequired[list[str]]
    # private key (PEM) of `cert_file`.  Unit: -. Default: none. Range: the path of a regular file, from the folder of
    # the case.
    key_file: NotRequired[str]
    # address of a solid server that already listens.  Unit: -. Default: none. Range: HOST:PORT, such as
    # "127.0.0.1:7001", or https://HOST:PORT.
    solid_address: NotRequired[str]
    # program and arguments that start a solid server.  Unit: -. Default: none. Range: a list: a program and its
    # arguments, such as ["python3", "solver.py"].
    solid_command: NotRequired[list[str]]
    # text file with the access token of the servers.  Unit: -. Default: none. Range: the path of a regular file, from
    # the folder of the case.
    token_file: NotRequired[str]


class FormulationTotalLagrangian(TypedDict):
    """deformation gradient and nominal stress in the reference configuration"""

    # Artificial viscosity A of Eq. (23) [-]; by default 0.2 where there is a fluid.  Unit: -. Default: 0.2 in a case
    # with a fluid, else 0. Range: a number of 0 or above.
    artificial_viscosity_a: NotRequired[float]
    # Artificial viscosity B of Eq. (23) [-].  Unit: -. Default: 0. Range: a number of 0 or above.
    artificial_viscosity_b: NotRequired[float]
    # Hourglass coefficient ζ [-], as a fraction of Young's modulus.  Unit: -. Default: 0.3. Range: a number of 0 or
    # above.
    hourglass: NotRequired[float]
    # Kernel ratio h/Δx of the stencil in the undeformed body [-]; 0.75 has 8 neighbours in the plane, 18 in space.
    # Unit: -. Default: 0.75. Range: a number from 0.6 to 3.
    kernel_ratio: NotRequired[float]
    # Stress as a function of the deformation gradient.  - `neo-hookean`: σ = (G (FFᵀ − I) + λ ln J I)/J: resists
    # compression to nothing - `st-venant-kirchhoff`: S = λ tr(E) I + 2G E, E = ½(FᵀF − I): Hooke's law for large
    # rotations and small strains  Unit: -. Default: "neo-hookean". Range: "neo-hookean", "st-venant-kirchhoff".
    law: NotRequired[Literal['neo-hookean', 'st-venant-kirchhoff']]
    # how the body is discretised: total-lagrangian, deformation gradient and nominal stress in the reference
    # configuration
    type: NotRequired[Literal['total-lagrangian']]


FormulationUpdatedLagrangian = TypedDict(
    "FormulationUpdatedLagrangian",
    {
        "artificial_stress": NotRequired[float],
        "artificial_stress_exponent": NotRequired[float],
        "artificial_viscosity_a": NotRequired[float],
        "artificial_viscosity_b": NotRequired[float],
        "gradient_correction": NotRequired[bool],
        "kernel_ratio": NotRequired[float],
        "lambda": NotRequired[float],
        "type": NotRequired[Literal['updated-lagrangian']],
    },
)


class FormulationRigid(TypedDict):
    """keeps its shape and takes no stress"""

    # how the body is discretised: rigid, keeps its shape and takes no stress
    type: NotRequired[Literal['rigid']]


Formulation: TypeAlias = """
    FormulationTotalLagrangian
    | FormulationUpdatedLagrangian
    | FormulationRigid
"""


class Load(TypedDict):
    """A load on part of the surface of a body."""

    # name of the load.  Unit: -. Default: must be written. Range: 1 to 64 letters, digits, `_` or `-`.
    name: str
    # pressure along the current normal; total-Lagrangian bodies only.  Unit: Pa. Default: must be written. Range: a
    # finite number or an expression of the coordinates and t.
    pressure_pa: NotRequired[float | str]
    # loads the outer cell faces of the body whose centre lies in this shape at the start.  Unit: -. Default: must be
    # written. Range: a table.
    shape: "Shape"
    # force per undeformed area, of given direction.  Unit: Pa. Default: must be written. Range: a finite number or an
    # expression of the coordinates and t for each axis.
    traction_pa: NotRequired[list[float | str]]


class Material(TypedDict):
    """Density and two elastic constants, K and G or E and ν."""

    # Bulk modulus K [Pa].  Unit: Pa. Default: must be written. Range: a number above 0.
    bulk_modulus_pa: NotRequired[float]
    # Rest density ρ₀ [kg/m³].  Unit: kg/m³. Default: must be written. Range: a number above 0.
    density_kg_m3: float
    # What holds across the plane; in space there is no such axis, and no other choice than `strain`.  - `strain`: No
    # strain: a slice of a long body, or one between smooth walls - `stress`: No stress: a thin sheet that is free to
    # change its thickness. Masses and forces are per undeformed depth  Unit: -. Default: "strain". Range: "strain",
    # "stress".
    plane: NotRequired[Literal['strain', 'stress']]
    # Poisson's ratio ν; 0.3 for a rigid body that names no moduli.  Unit: -. Default: must be written. Range: a
    # number above -1 and below 0.5 (0.49 for nearly incompressible).
    poisson_ratio: NotRequired[float]
    # Shear modulus G [Pa].  Unit: Pa. Default: must be written. Range: a number above 0.
    shear_modulus_pa: NotRequired[float]
    # Young's modulus E; a rigid body, for which moduli act in contact alone, takes 1e7 Pa where it names none.  Unit:
    # Pa. Default: must be written. Range: a number above 0.
    young_modulus_pa: NotRequired[float]


class Motion(TypedDict):
    """A prescribed motion: pivot + R(angle)(X − pivot) + displacement, X the position at the start."""

    # angle of rotation, in the plane counter-clockwise, in space right-handed about `axis`.  Unit: rad. Default: 0.
    # Range: a finite number or an expression of t.
    angle_rad: NotRequired[float | str]
    # direction of the axis of rotation, of any length; in space only, where it must be written with `angle_rad`.
    # Unit: -. Default: none without `angle_rad`. Range: a finite number for each axis.
    axis: NotRequired[list[float]]
    # displacement along x.  Unit: m. Default: 0. Range: a finite number or an expression of t.
    displacement_x_m: NotRequired[float | str]
    # displacement along y.  Unit: m. Default: 0. Range: a finite number or an expression of t.
    displacement_y_m: NotRequired[float | str]
    # displacement along z; in space only.  Unit: m. Default: 0. Range: a finite number or an expression of t.
    displacement_z_m: NotRequired[float | str]
    # point about which it turns; must be written with `angle_rad`.  Unit: m. Default: the origin without `angle_rad`.
    # Range: a finite number for each axis.
    pivot_m: NotRequired[list[float]]


class Support(TypedDict):
    """A part of a body that is held or moved, or a point about which a rigid body turns."""

    # held components: all for a clamp, one in the plane for a roller.  - `x`: along x - `y`: along y - `z`: along z;
    # in space only  Unit: -. Default: all. Range: a list of some of "x", "y", "z".
    held: NotRequired[list[Literal['x', 'y', 'z']]]
    # prescribed motion of the held components, or of the pivot.  Unit: -. Default: at rest. Range: a table.
    motion: NotRequired["Motion"]
    # name of the support.  Unit: -. Default: must be written. Range: 1 to 64 letters, digits, `_` or `-`.
    name: str
    # in place of `shape` and `held`: a point about which a rigid body turns freely, a hinge in the plane; it may lie
    # off the body.  Unit: m. Default: must be written. Range: a finite number for each axis.
    pivot_m: NotRequired[list[float]]
    # time at which the support ceases to act.  Unit: s. Default: never. Range: a finite number.
    release_time_s: NotRequired[float]
    # holds the particles of the body inside this shape at the start.  Unit: -. Default: must be written. Range: a
    # table.
    shape: NotRequired["Shape"]


class Body(TypedDict):
    """One body."""

    # acceleration of this body only, in addition to `[body_force]`.  Unit: m/s². Default: none. Range: a finite
    # number or an expression of the coordinates and t for each axis.
    acceleration_m_s2: NotRequired[list[float | str]]
    # how the body is discretised.  Unit: -. Default: total-lagrangian; updated-lagrangian with the preset `paper`.
    # Range: a table.
    formulation: NotRequired["Formulation"]
    # a corner of a lattice of its own.  Unit: m. Default: the domain's lattice. Range: a finite number for each axis.
    lattice_origin_m: NotRequired[list[float]]
    # where the particles stand; the mass is that of the shape in every case.  - `auto`: on the lattice where all
    # faces lie between two of its rows, else what suits the shape best, see cases/FORMAT.md - `fitted`: in layers
    # along the faces - `lattice`: on the lattice: faces that do not run along it become staircases  Unit: -. Default:
    # "auto". Range: "auto", "fitted", "lattice".
    layout: NotRequired[Literal['auto', 'fitted', 'lattice']]
    # loads on its surface.  Unit: -. Default: none. Range: a list of tables.
    load: NotRequired[list["Load"]]
    # density and elastic constants.  Unit: -. Default: must be written. Range: a table.
    material: "Material"
    # name of the body.  Unit: -. Default: must be written. Range: 1 to 64 letters, digits, `_` or `-`.
    name: str
    # rotation at the start about the centre of mass, or about the pivot of a support, added to the velocity.  Unit:
    # rad/s. Default: none. Range: a finite number; in space one for each axis.
    rotation_speed_rad_s: NotRequired[float | list[float]]
    # the body as it is at the start, undeformed.  Unit: -. Default: must be written. Range: a table.
    shape: "Shape"
    # parts that are held or moved, or a pivot.  Unit: -. Default: none. Range: a list of tables.
    support: NotRequired[list["Support"]]
    # velocity at the start.  Unit: m/s. Default: 0 along each axis. Range: a finite number or an expression of the
    # coordinates for each axis.
    velocity_m_s: NotRequired[list[float | str]]


class Contact1(TypedDict):
    """repulsion by the depth in the other that never pulls"""

    # Damping of the approach as a fraction of critical [-].  Unit: -. Default: 0.2. Range: a number of 0 or above.
    damping: NotRequired[float]
    # Distance d at which it sets in, in particle spacings [-].  Unit: -. Default: 2 in a case with a fluid, else 1.
    # Range: a number above 0 and at most 10.
    distance: NotRequired[float]
    # Coulomb's coefficient of friction [-].  Unit: -. Default: 0. Range: a number of 0 or above.
    friction: NotRequired[float]
    # in place of `distance`: the gap that faces keep when they touch, as rough faces do; at most nine spacings.
    # Unit: m. Default: `distance` holds. Range: a number of 0 or above.
    gap_m: NotRequired[float]
    # contact law: repulsion, repulsion by the depth in the other that never pulls
    law: NotRequired[Literal['repulsion']]
    # Whether total-Lagrangian bodies also touch themselves.  Unit: -. Default: true. Range: true or false.
    self_contact: NotRequired[bool]
    # Stiffness as a fraction of the softer bulk modulus [-].  Unit: -. Default: 1. Range: a number above 0.
    stiffness: NotRequired[float]
    # Whether the water around presses in gaps that are too thin for its particles.  Unit: -. Default: true. Range:
    # true or false.
    wet: NotRequired[bool]


class Contact2(TypedDict):
    """that of the source paper: bodies interact through the sums (22)"""

    # contact law: sums, that of the source paper: bodies interact through the sums (22)
    law: NotRequired[Literal['sums']]


Contact: TypeAlias = """
    Contact1
    | Contact2
"""


class Solid(TypedDict):
    """The solids."""

    # the bodies.  Unit: -. Default: none. Range: a list of tables.
    body: NotRequired[list["Body"]]
    # how bodies touch each other and walls.  Unit: -. Default: repulsion. Range: a table.
    contact: NotRequired["Contact"]
    # acceleration −k v on all free particles until a time.  Unit: -. Default: none. Range: a table.
    damping: NotRequired["Damping"]
    # kernel ratio h/Δx of updated-Lagrangian bodies and of contact by sums.  Unit: -. Default: 1.3. Range: a number
    # from 0.8 to 4 (h/Δx).
    kernel_ratio: NotRequired[float]
    # particles that may leave the domain; the run ends when more have left.  Unit: -. Default: 0. Range: a whole
    # number from 0 to 1000000000.
    lost_particle_limit: NotRequired[int]
    # particle spacing Δx of the solids.  Unit: m. Default: the fluid's; must be written without a fluid. Range: a
    # number above 0.
    particle_spacing_m: NotRequired[float]
    # sub-steps of the solids per step, an even number.  - `auto`: as many as the solid's stability limit requires -
    # `none`: the stage rule, Eq. (30)-(31)  Unit: -. Default: "auto" with a total-Lagrangian or rigid body, else
    # "none". Range: a whole number from 2 to 10000, or "auto", "none".
    substeps: NotRequired[int | Literal['auto', 'none']]


class StepFixed(TypedDict):
    """steps of one size"""

    # size of every step.  Unit: s. Default: must be written. Range: a number above 0.
    time_step_s: float
    # how steps are sized: fixed, steps of one size
    type: Literal['fixed']


class StepAdaptive(TypedDict):
    """steps follow the stability limits of both solvers"""

    # steps are shortened so that they meet the times of snapshots, pictures and `exact_times_s`, and of probes where
    # these are at least five steps apart.  Unit: -. Default: true. Range: true or false.
    exact_outputs: NotRequired[bool]
    # further times that steps meet; with `exact_outputs` only.  Unit: s. Default: the end of the run. Range: a list,
    # each a finite number.
    exact_times_s: NotRequired[list[float]]
    # fraction of the smaller of both solvers' stability limits that a step takes.  Unit: -. Default: 0.5. Range: a
    # number above 0 and at most 1.
    factor: NotRequired[float]
    # longest step, as a multiple of the previous one.  Unit: -. Default: 1.05. Range: a number above 1 and at most 2.
    growth: NotRequired[float]
    # longest step.  Unit: s. Default: the time of the run. Range: a number above 0.
    maximum_s: NotRequired[float]
    # how steps are sized: adaptive, steps follow the stability limits of both solvers
    type: Literal['adaptive']


Step: TypeAlias = """
    StepFixed
    | StepAdaptive
"""


class Time(TypedDict):
    """Start, end and steps of the run."""

    # end of the run.  Unit: s. Default: must be written. Range: a finite number.
    end_time_s: float
    # a fixed step above this fraction of the stability limit is refused; the run header shows it when it is not 1.
    # Unit: -. Default: 1. Range: a number above 0 and at most 10.
    limit_factor: NotRequired[float]
    # start of the run.  Unit: s. Default: 0. Range: a finite number.
    start_time_s: NotRequired[float]
    # size of the time steps.  Unit: -. Default: must be written. Range: a table.
    step: "Step"


class WallContainer(TypedDict):
    """layers around the outside of a shape"""

    # how the fluid flows along the wall.  - `slip`: the fluid slides along it - `no-slip`: the fluid has the velocity
    # of the wall at its face  Unit: -. Default: "slip". Range: "slip", "no-slip".
    condition: NotRequired[Literal['slip', 'no-slip']]
    # a corner of a lattice of its own.  Unit: m. Default: the domain's lattice. Range: a finite number for each axis.
    lattice_origin_m: NotRequired[list[float]]
    # number of particle layers.  Unit: rows. Default: the support of the widest kernel, plus one. Range: a whole
    # number from 1 to 100.
    layers: NotRequired[int]
    # where the particles stand; the mass is that of the shape in every case.  - `auto`: on the lattice where all
    # faces lie between two of its rows, else what suits the shape best, see cases/FORMAT.md - `fitted`: in layers
    # along the faces - `lattice`: on the lattice: faces that do not run along it become staircases  Unit: -. Default:
    # "auto". Range: "auto", "fitted", "lattice".
    layout: NotRequired[Literal['auto', 'fitted', 'lattice']]
    # prescribed motion.  Unit: -. Default: at rest. Range: a table.
    motion: NotRequired["Motion"]
    # name of the wall.  Unit: -. Default: must be written. Range: 1 to 64 letters, digits, `_` or `-`.
    name: str
    # sides without a wall; where the shape reaches a periodic side of the domain it is open.  - `left`: toward lower
    # x, in the plane - `right`: toward higher x, in the plane - `bottom`: toward lower y, in the plane - `top`:
    # toward higher y, in the plane - `-x`: toward lower x, in space - `+x`: toward higher x, in space - `-y`: toward
    # lower y, in space - `+y`: toward higher y, in space - `-z`: toward lower z, in space - `+z`: toward higher z, in
    # space  Unit: -. Default: `[]`. Range: a list of some of "left", "right", "bottom", "top", "-x", "+x", "-y",
    # "+y", "-z", "+z".
    open_sides: NotRequired[list[Literal['left', 'right', 'bottom', 'top', '-x', '+x', '-y', '+y', '-z', '+z']]]
    # time at which the wall is removed.  Unit: s. Default: never. Range: a finite number.
    release_time_s: NotRequired[float]
    # inside of the container.  Unit: -. Default: the domain. Range: a table.
    shape: NotRequired["Shape"]
    # where the particles of the wall lie: container, layers around the outside of a shape
    type: Literal['container']


class WallSolid(TypedDict):
    """the outer layers inside a shape, at least three spacings thick"""

    # how the fluid flows along the wall.  - `slip`: the fluid slides along it - `no-slip`: the fluid has the velocity
    # of the wall at its face  Unit: -. Default: "slip". Range: "slip", "no-slip".
    condition: NotRequired[Literal['slip', 'no-slip']]
    # a corner of a lattice of its own.  Unit: m. Default: the domain's lattice. Range: a finite number for each axis.
    lattice_origin_m: NotRequired[list[float]]
    # number of particle layers.  Unit: rows. Default: the support of the widest kernel, plus one. Range: a whole
    # number from 1 to 100.
    layers: NotRequired[int]
    # where the particles stand; the mass is that of the shape in every case.  - `auto`: on the lattice where all
    # faces lie between two of its rows, else what suits the shape best, see cases/FORMAT.md - `fitted`: in layers
    # along the faces - `lattice`: on the lattice: faces that do not run along it become staircases  Unit: -. Default:
    # "auto". Range: "auto", "fitted", "lattice".
    layout: NotRequired[Literal['auto', 'fitted', 'lattice']]
    # prescribed motion.  Unit: -. Default: at rest. Range: a table.
    motion: NotRequired["Motion"]
    # name of the wall.  Unit: -. Default: must be written. Range: 1 to 64 letters, digits, `_` or `-`.
    name: str
    # time at which the wall is removed.  Unit: s. Default: never. Range: a finite number.
    release_time_s: NotRequired[float]
    # the wall itself.  Unit: -. Default: must be written. Range: a table.
    shape: "Shape"
    # where the particles of the wall lie: solid, the outer layers inside a shape, at least three spacings thick
    type: Literal['solid']


Wall: TypeAlias = """
    WallContainer
    | WallSolid
"""


class CaseFile(TypedDict):
    """A case of Tidelock: a fluid, solids or both, and a run of them. All numbers are SI, with the unit in the name
    of the key."""

    # gravity and other accelerations.  Unit: -. Default: nothing pulls. Range: a table.
    body_force: NotRequired["BodyForce"]
    # when states are kept.  Unit: -. Default: the defaults of its keys. Range: a table.
    checkpoint: NotRequired["Checkpoint"]
    # longest waits for servers.  Unit: -. Default: the defaults of its keys. Range: a table.
    deadlines: NotRequired["Deadlines"]
    # the box that contains the scene.  Unit: -. Default: must be written. Range: a table.
    domain: "Domain"
    # the fluid.  Unit: -. Default: none: there must be solids. Range: a table.
    fluid: NotRequired["Fluid"]
    # law between fluid and solids, in a case with both.  Unit: -. Default: the defaults of its keys. Range: a table.
    interface: NotRequired["Interface"]
    # audit of the balances.  Unit: -. Default: the defaults of its keys. Range: a table.
    ledger: NotRequired["Ledger"]
    # name of the case.  Unit: -. Default: must be written. Range: 1 to 64 letters, digits, `_` or `-`.
    name: str
    # what a run leaves behind.  Unit: -. Default: the defaults of its keys. Range: a table.
    outputs: NotRequired["Outputs"]
    # values of what the case leaves out.  - `recommended`: the defaults of all keys - `paper`: the source paper: its
    # column of docs/parameters.md, the laws `plain-sum` and `sums`, and updated-Lagrangian bodies  Unit: -. Default:
    # "recommended". Range: "recommended", "paper".
    preset: NotRequired[Literal['recommended', 'paper']]
    # the probes, a table for each.  Unit: -. Default: none. Range: a list of tables.
    probe: NotRequired[list["Probe"]]
    # which member of an ensemble it is.  Unit: -. Default: none. Range: a table.
    run: NotRequired["Run"]
    # where the solvers come from.  Unit: -. Default: the built-in servers. Range: a table.
    servers: NotRequired["Servers"]
    # the solids.  Unit: -. Default: none: there must be a fluid. Range: a table.
    solid: NotRequired["Solid"]
    # output folder of an earlier run whose final state is the initial state.  Unit: -. Default: none: the case is its
    # own start. Range: the path of a folder, from the folder of the case.
    start_from: NotRequired[str]
    # start, end and steps.  Unit: -. Default: must be written. Range: a table.
    time: "Time"
    # the walls, a table for each.  Unit: -. Default: none. Range: a list of tables.
    wall: NotRequired[list["Wall"]]
