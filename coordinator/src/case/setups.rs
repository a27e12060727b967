//! Set-ups of the solvers of a case.

use sph::map_space;
use sph::setup::{
    AnyFluidSetup, AnySolidSetup, BodySetup, Coupling, CouplingKind, FluidSetup, InterfaceLaw, ParameterSet,
    RunPlan, RunSetup, SolidSetup,
};
use sph::space::Space;

use super::scene::Scene;
use super::{Case, file};

impl Case {
    /// The part of the set-up that both participants share; the run's id is the name of the case.
    pub fn run_plan(&self) -> RunPlan {
        sph::in_space!(&self.scene, scene => self.run_setup(scene).plan())
    }

    /// The same in the space of `scene`.
    fn run_setup<S: Space>(&self, _scene: &Scene<S>) -> RunSetup<S> {
        let file = &self.file;
        let coupling = match (&file.fluid, &file.solid, &file.interface) {
            (Some(fluid), Some(solid), Some(interface)) => Some(Coupling {
                kind: self.coupling_kinds()[0],
                law: interface.law.value,
                fluid: fluid.parameters.of_pair_law(),
                solid_spacing: solid.particle_spacing_m.value,
                repulsion: interface.repulsion.unwrap_or(0.0),
                margin: interface.margin_spacings * fluid.parameters.particle_spacing,
                implicit: interface.iterate.as_ref().map(file::interface::IterateTable::to_setup),
            }),
            _ => None,
        };
        RunSetup {
            run_id: self.name.clone(),
            domain: file.domain.domain(),
            time: file.time.to_setup(),
            body_force: file.body_force.to_setup(),
            outputs: self.outputs.plan.clone(),
            ledger: file.ledger.to_setup(),
            coupling,
        }
    }

    /// Kinds of coupling that the run may use, the preferred one first: all, unless the case names one.
    pub fn coupling_kinds(&self) -> Vec<CouplingKind> {
        let named = self.file.interface.as_ref().and_then(|interface| interface.kind.as_ref());
        match (named, &self.file.interface) {
            (Some(kind), _) => vec![kind.value],
            (None, Some(interface)) if interface.law.value == InterfaceLaw::PlainSum => {
                vec![CouplingKind::States]
            }
            (None, Some(interface)) if interface.iterate.is_some() => vec![CouplingKind::Loads],
            (None, _) => CouplingKind::ALL.to_vec(),
        }
    }

    /// Set-up of the fluid solver; `None` without a fluid.
    pub fn fluid_setup(&self) -> Option<AnyFluidSetup> {
        let fluid = self.file.fluid.as_ref()?;
        Some(map_space!(&self.scene, scene => self.fluid_of(fluid, scene)))
    }

    fn fluid_of<S: Space>(&self, fluid: &file::fluid::FluidTable, scene: &Scene<S>) -> FluidSetup<S> {
        FluidSetup {
            run: self.run_setup(scene),
            parameters: fluid.parameters.values(),
            damping: fluid.damping.as_ref().map(file::fluid::DampingTable::to_setup),
            regions: fluid.regions.iter().map(|region| region.name.value.clone()).collect(),
            walls: self.file.walls.iter().map(file::wall::WallTable::to_setup).collect(),
            particles: scene.fluid.clone(),
            wall_particles: scene.walls.clone(),
            probes: scene.probes.fluid.clone(),
            outflow: self.file.domain.outflow(),
        }
    }

    /// Set-up of the solid solver; `None` without a solid.
    pub fn solid_setup(&self) -> Option<AnySolidSetup> {
        let solid = self.file.solid.as_ref()?;
        Some(map_space!(&self.scene, scene => self.solid_of(solid, scene)))
    }

    fn solid_of<S: Space>(&self, solid: &file::solid::SolidTable, scene: &Scene<S>) -> SolidSetup<S> {
        let body = |(k, body): (usize, &file::body::BodyTable)| BodySetup {
            name: body.name.value.clone(),
            material: body.material.parameters.values(),
            formulation: body.formulation.to_setup(),
            supports: body.supports.iter().map(file::support::SupportTable::to_setup).collect(),
            acceleration: body.acceleration_m_s2.as_deref().map(file::formula::texts::<S>),
            loads: scene.loads.get(k).cloned().unwrap_or_default(),
        };
        SolidSetup {
            run: self.run_setup(scene),
            particle_spacing: solid.particle_spacing_m.value,
            bodies: solid.bodies.iter().enumerate().map(body).collect(),
            particles: scene.solid.clone(),
            contact: solid.contact.to_setup(),
            walls: self.file.walls.iter().map(file::wall::WallTable::to_setup).collect(),
            wall_particles: scene.walls.clone(),
            damping: solid.damping.as_ref().map(file::fluid::DampingTable::to_setup),
            stepping: solid.substeps.to_setup(),
            probes: scene.probes.solid.clone(),
            lost_particle_limit: solid.lost_particle_limit,
        }
    }
}
