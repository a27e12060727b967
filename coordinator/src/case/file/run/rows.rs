//! Rows of domain, forces, time, outputs, ledger and motions.

use sph::setup::{Allowed, LedgerPolicy};

use crate::case::spec::{Kind, TableSpec, Variables, Variant, Variants, Words, key};

/// Meanings of the names of axes.
pub const AXIS_WORDS: Words = &[("x", "along x"), ("y", "along y"), ("z", "along z; in space only")];

/// Meanings of the names of sides: four in the plane, six in space.
pub const SIDE_WORDS: Words = &[
    ("left", "toward lower x, in the plane"),
    ("right", "toward higher x, in the plane"),
    ("bottom", "toward lower y, in the plane"),
    ("top", "toward higher y, in the plane"),
    ("-x", "toward lower x, in space"),
    ("+x", "toward higher x, in space"),
    ("-y", "toward lower y, in space"),
    ("+y", "toward higher y, in space"),
    ("-z", "toward lower z, in space"),
    ("+z", "toward higher z, in space"),
];

/// Rows of `[domain]`.
pub static DOMAIN: TableSpec = TableSpec::new(
    "domain",
    "The box that contains the scene; the number of its coordinates is the number of dimensions of the case.",
    &[
        key(
            "lower_m",
            Kind::Vector,
            "lower corner of the box: two numbers for a case of the plane, three for one in space",
        ),
        key("upper_m", Kind::Vector, "upper corner of the box"),
        key("periodic", Kind::SomeWords(AXIS_WORDS), "directions in which the scene repeats").or_else("`[]`"),
        key(
            "lattice_origin_m",
            Kind::Vector,
            "a corner of the square lattice on which all particles are placed",
        )
        .or_else("`lower_m`"),
        key(
            "outflow_sides",
            Kind::SomeWords(SIDE_WORDS),
            "sides through which particles may leave; a particle that crosses another side has escaped, see \
             `lost_particle_limit`",
        )
        .or_else("open sides of containers that reach the domain's side"),
    ],
);

/// Rows of `[body_force]`.
pub static BODY_FORCE: TableSpec = TableSpec::new(
    "body_force",
    "Accelerations of everything that moves freely, water and solids.",
    &[
        key("gravity_m_s2", Kind::Vector, "constant acceleration, such as [0.0, -9.81]")
            .or_else("0 along each axis"),
        key(
            "acceleration_m_s2",
            Kind::Expressions(Variables::CoordinatesAndTime),
            "acceleration added to gravity, for example by a shaken tank",
        )
        .or_else("none"),
    ],
);

const GROWTH: Allowed = Allowed::new(1.0, 2.0, (false, true), "a number above 1 and at most 2");
const LIMIT: Allowed = Allowed::new(0.0, 10.0, (false, true), "a number above 0 and at most 10");

/// Rows of `[time]`.
pub static TIME: TableSpec = TableSpec::new(
    "time",
    "Start, end and steps of the run.",
    &[
        key("end_time_s", Kind::Number(Allowed::FINITE), "end of the run"),
        key("start_time_s", Kind::Number(Allowed::FINITE), "start of the run").or(0.0),
        key("step", Kind::Table(&STEP), "size of the time steps"),
        key(
            "limit_factor",
            Kind::Number(LIMIT),
            "a fixed step above this fraction of the stability limit is refused; the run header shows it when it is not 1",
        )
        .or(1.0),
    ],
);

/// Rows of `step` of `[time]`.
static STEP: TableSpec =
    TableSpec::new("step", "Size of the time steps.", &[]).by(Variants::new("type", "how steps are sized", &[
        Variant::new("fixed", "steps of one size", &[key(
            "time_step_s",
            Kind::Number(Allowed::POSITIVE),
            "size of every step",
        )]),
        Variant::new("adaptive", "steps follow the stability limits of both solvers", &[
            key(
                "factor",
                Kind::Number(Allowed::FRACTION),
                "fraction of the smaller of both solvers' stability limits that a step takes",
            )
            .or(0.5),
            key("maximum_s", Kind::Number(Allowed::POSITIVE), "longest step").or_else("the time of the run"),
            key("growth", Kind::Number(GROWTH), "longest step, as a multiple of the previous one").or(1.05),
            key(
                "exact_outputs",
                Kind::Flag,
                "steps are shortened so that they meet the times of snapshots, pictures and `exact_times_s`, and of probes \
                 where these are at least five steps apart",
            )
            .or_flag(true),
            key("exact_times_s", Kind::Numbers(Allowed::FINITE), "further times that steps meet; with `exact_outputs` only")
                .or_else("the end of the run"),
        ]),
    ]));

/// Rows of `[outputs]`.
pub static OUTPUTS: TableSpec = TableSpec::new(
    "outputs",
    "What a run leaves behind, and when.",
    &[
        key("snapshot_interval_s", Kind::Number(Allowed::POSITIVE), "time between snapshots for ParaView")
            .or_else("first and last only"),
        key("probe_interval_s", Kind::Number(Allowed::POSITIVE), "time between rows of `probes.csv`")
            .or_else("first and last only"),
        // A row has some eighty numbers, and one a step would outgrow all other outputs.
        key("ledger_every_steps", Kind::Count(1, 1_000_000), "steps between rows of `ledger.csv`")
            .or_count(10),
        key("picture_times_s", Kind::Numbers(Allowed::FINITE), "times of the report's pictures")
            .or_else("six of the snapshots, evenly spaced"),
    ],
);

/// Rows of `[ledger]`; the tolerances are those of [`LedgerPolicy`].
pub static LEDGER: TableSpec = TableSpec::new(
    "ledger",
    "The audit of forces, torques and momentum at every half-step.",
    &[
        key(
            "action",
            Kind::Word(&[
                ("stop", "the run ends"),
                ("warn", "the run continues, and its verdict says so"),
                ("stop-and-checkpoint", "the run ends with a checkpoint of the end of the step"),
            ]),
            "effect of a failed balance",
        )
        .or_word("stop"),
        key(
            "balance_tolerance",
            Kind::Number(Allowed::POSITIVE),
            "largest imbalance of force and torque across the interface, relative to the sum of magnitudes",
        )
        .or(LedgerPolicy::DEFAULT.balance_tolerance),
        key(
            "momentum_tolerance",
            Kind::Number(Allowed::POSITIVE),
            "largest residual of each side's momentum and angular momentum budget, relative to the sum of magnitudes",
        )
        .or(LedgerPolicy::DEFAULT.momentum_tolerance),
    ],
);

/// Rows of `motion` of walls and supports.
pub static MOTION: TableSpec = TableSpec::new(
    "motion",
    "A prescribed motion: pivot + R(angle)(X − pivot) + displacement, X the position at the start.",
    &[
        key("displacement_x_m", Kind::Expression(Variables::Time), "displacement along x").or(0.0),
        key("displacement_y_m", Kind::Expression(Variables::Time), "displacement along y").or(0.0),
        key("displacement_z_m", Kind::Expression(Variables::Time), "displacement along z; in space only").or(0.0),
        key(
            "angle_rad",
            Kind::Expression(Variables::Time),
            "angle of rotation, in the plane counter-clockwise, in space right-handed about `axis`",
        )
        .or(0.0),
        key(
            "axis",
            Kind::Vector,
            "direction of the axis of rotation, of any length; in space only, where it must be written with `angle_rad`",
        )
        .or_else("none without `angle_rad`"),
        key("pivot_m", Kind::Vector, "point about which it turns; must be written with `angle_rad`")
            .or_else("the origin without `angle_rad`"),
    ],
);
