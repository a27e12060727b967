//! Whether this process was started by a launcher of MPI programs.

/// What is known of the processes that were started with this one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Launched {
    /// Their number, with this one.
    pub(super) processes: Option<usize>,
    /// The number of those on this machine.
    pub(super) here: Option<usize>,
    /// The number of cores that each was given, where Slurm says it.
    pub(super) cores: Option<usize>,
}

/// Cores of a task of Slurm, where its user has asked for some.
const CORES: &str = "SLURM_CPUS_PER_TASK";

/// Number of tasks of a step of Slurm. `SLURM_PROCID` and `SLURM_NTASKS` are set in batch scripts too.
const STEP: &str = "SLURM_STEP_NUM_TASKS";

/// Each launcher: a variable that it sets in what it starts, that of the number of processes, and that of those on this
/// machine. The first that fits counts: `mpirun` of Open MPI sets variables of PMIx too, and may run below Slurm.
const LAUNCHERS: [[&str; 3]; 4] = [
    // `mpirun` of Open MPI.
    ["OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_LOCAL_SIZE"],
    // `mpiexec` of MPICH, `srun --mpi=pmi2`.
    ["PMI_RANK", "PMI_SIZE", "MPI_LOCALNRANKS"],
    // `srun --mpi=pmix`.
    ["PMIX_RANK", STEP, "SLURM_NTASKS_PER_NODE"],
    // `srun` without any of them, with which MPI does not find the others.
    [STEP, STEP, "SLURM_NTASKS_PER_NODE"],
];

/// What started this process with others, if anything did. Only the environment is read: MPI need not be started.
pub(super) fn launched() -> Option<Launched> {
    find(|name| std::env::var(name).ok())
}

fn find(variable: impl Fn(&str) -> Option<String>) -> Option<Launched> {
    let number = |name: &str| -> Option<usize> { variable(name)?.trim().parse().ok() };
    let [_, processes, here] = LAUNCHERS.into_iter().find(|[mark, ..]| number(mark).is_some())?;
    Some(Launched { processes: number(processes), here: number(here), cores: number(CORES) })
}

#[cfg(test)]
mod tests {
    use super::{Launched, find};

    #[test]
    fn each_launcher_is_known_by_its_variables() {
        let by = |all: &'static [(&str, &str)]| {
            find(|name| {
                let (_, value) = all.iter().find(|(known, _)| *known == name)?;
                Some((*value).to_owned())
            })
        };
        assert_eq!(by(&[]), None);
        // A batch script of Slurm.
        assert_eq!(by(&[("SLURM_PROCID", "0"), ("SLURM_NTASKS", "3")]), None);
        let of_three = Launched { processes: Some(3), here: None, cores: Some(8) };
        let srun = by(&[("PMIX_RANK", "1"), ("SLURM_STEP_NUM_TASKS", "3"), ("SLURM_CPUS_PER_TASK", "8")]);
        assert_eq!(srun, Some(of_three));
        let open_mpi = [
            ("PMIX_RANK", "1"),
            ("OMPI_COMM_WORLD_RANK", "1"),
            ("OMPI_COMM_WORLD_SIZE", "2"),
            ("OMPI_COMM_WORLD_LOCAL_SIZE", "1"),
        ];
        let expected = Launched { processes: Some(2), here: Some(1), cores: None };
        assert_eq!(
            find(|name| open_mpi.iter().find(|(known, _)| *known == name).map(|(_, v)| (*v).into())),
            Some(expected)
        );
    }
}
