//! Memory that a case needs, against what the machine has: said before any of it is taken.

use crate::case::{Case, Server};
use crate::failure::Failure;

/// Memory of a built-in server for each particle \[bytes\]: state, workspace, neighbour lists, set-up and frames on their way,
/// by peak sizes of processes; solids keep the pairs of their reference. In space between processes of 110,592 and 262,144
/// particles of `taylor_green_3d`, with the walls of `dam_break_box_3d` at 20 mm and the bar of `cantilever_3d_static` at
/// 20 across. The peak is during a snapshot, which takes a second workspace.
struct PerParticle {
    fluid: u64,
    wall: u64,
    solid: u64,
}

const PLANE: PerParticle = PerParticle { fluid: 850, wall: 250, solid: 1_500 };
const SPACE: PerParticle = PerParticle { fluid: 2_750, wall: 900, solid: 5_900 };

/// Memory that the built-in servers of `case` need on this machine \[bytes\].
pub fn needed(case: &Case) -> u64 {
    let each = if case.dimensions() == 2 { PLANE } else { SPACE };
    let [fluid, solid] = case.particles().map(|count| count as u64);
    let walls = case.wall_particles() as u64;
    let of = |server: &Server, bytes: u64| if *server == Server::BuiltIn { bytes } else { 0 };
    of(&case.servers.fluid, each.fluid * fluid + each.wall * walls)
        + of(&case.servers.solid, if solid > 0 { each.solid * solid + each.wall * walls } else { 0 })
}

/// Refuses a case that needs more than this machine has.
///
/// # Errors
/// It does; with both numbers.
pub fn check(case: &Case) -> Result<(), Failure> {
    check_against(case, total())
}

fn check_against(case: &Case, total: Option<u64>) -> Result<(), Failure> {
    let (needed, Some(total)) = (needed(case), total) else { return Ok(()) };
    if needed <= total {
        return Ok(());
    }
    let [fluid, solid] = case.particles();
    let gibibytes = |bytes: u64| bytes as f64 / f64::from(1 << 30);
    Err(Failure::input(format!(
        "the case needs some {:.1} GiB of memory and this machine has {:.1} GiB: {fluid} particles of fluid, {solid} of \
         solids, {} of walls\n  raise `particle_spacing_m` by a factor of {:.2}, or run the servers on larger machines \
         (`servers.fluid_address`, `servers.solid_address`)",
        gibibytes(needed),
        gibibytes(total),
        case.wall_particles(),
        (needed as f64 / total as f64).powf(1.0 / case.dimensions() as f64).max(1.01),
    )))
}

/// Memory of this machine, or of the group of processes that this one belongs to \[bytes\]; `None` where the system does not
/// say.
fn total() -> Option<u64> {
    let read = |path: &str| std::fs::read_to_string(path).ok();
    let machine = read("/proc/meminfo").as_deref().and_then(of_machine)?;
    let group = read("/sys/fs/cgroup/memory.max").and_then(|text| text.trim().parse().ok());
    Some(group.map_or(machine, |group: u64| group.min(machine)))
}

fn of_machine(meminfo: &str) -> Option<u64> {
    let line = meminfo.lines().find_map(|line| line.strip_prefix("MemTotal:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kilobytes| 1024 * kilobytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::tests::{TANK, good};

    #[test]
    fn a_case_beyond_the_machine_is_refused_with_both_numbers() {
        let case = good(TANK);
        let needed = needed(&case);
        assert!(needed > PLANE.fluid * case.particles()[0] as u64, "{needed}");
        assert!(check_against(&case, Some(needed)).is_ok() && check_against(&case, None).is_ok());
        let refused = check_against(&case, Some(needed / 4)).unwrap_err().to_string();
        // A quarter of the memory is that of twice the spacing in the plane.
        for words in ["GiB", "particles of fluid", "by a factor of 2.0"] {
            assert!(refused.contains(words), "{refused}");
        }
    }

    #[test]
    fn the_memory_of_the_machine_is_read() {
        assert_eq!(of_machine("MemTotal:       24576 kB\nMemFree: 1 kB\n"), Some(24_576 * 1024));
        assert_eq!(of_machine("MemFree: 1 kB\n"), None);
        assert!(total().is_none_or(|bytes| bytes > 1 << 26));
    }
}
