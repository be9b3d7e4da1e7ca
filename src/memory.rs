//! How much memory the program has used and may still use, as the operating system counts it.

use std::fs;
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};

/// The largest resident size so far, in bytes; `None` where the system does
/// not tell.
pub fn peak() -> Option<u64> {
    status("VmHWM:")
}

/// A size of this process, in bytes.
fn status(name: &str) -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with(name))?;
    let kibibytes: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kibibytes * 1024)
}

/// Refuses what would not fit, before it is made.
///
/// # Errors
/// [`Error::Memory`] with what it would take, and what there is.
pub fn require(needed: u64, what: impl FnOnce() -> String) -> Result<()> {
    let available = available();
    if needed <= available {
        return Ok(());
    }
    Err(Error::Memory { what: what(), needed, available })
}

/// Bytes that can still be had: what the system has, within the limits of
/// the control groups that this process is in, and of its address space
/// (`ulimit -v`).
pub fn available() -> u64 {
    let mut system = sysinfo::System::new();
    system.refresh_memory();
    let groups = group_folders();
    let groups = groups.iter().filter_map(|folder| left_in_group(folder));
    groups.chain(left_in_address_space()).fold(system.available_memory(), u64::min)
}

/// Where Linux shows the control groups (version 1 and 2) that limit this
/// process, with all their parents; empty elsewhere.
fn group_folders() -> Vec<PathBuf> {
    let groups = fs::read_to_string("/proc/self/cgroup").unwrap_or_default();
    groups
        .lines()
        .filter_map(|line| {
            let mut fields = line.splitn(3, ':').skip(1);
            let (controllers, path) = (fields.next()?, fields.next()?);
            let root = match controllers {
                "" => Path::new("/sys/fs/cgroup"),
                "memory" => Path::new("/sys/fs/cgroup/memory"),
                _ => return None,
            };
            let group = root.join(path.trim_start_matches('/'));
            let within = |folder: &&Path| folder.starts_with(root);
            Some(group.ancestors().take_while(within).map(Path::to_owned).collect::<Vec<_>>())
        })
        .flatten()
        .collect()
}

/// What a control group may still use; file cache that can be dropped counts
/// as free.
fn left_in_group(folder: &Path) -> Option<u64> {
    let number = |name: &str| -> Option<u64> {
        fs::read_to_string(folder.join(name)).ok()?.trim().parse().ok()
    };
    let limit = number("memory.max").or_else(|| number("memory.limit_in_bytes"))?;
    let used = number("memory.current").or_else(|| number("memory.usage_in_bytes"))?;
    let statistics = fs::read_to_string(folder.join("memory.stat")).unwrap_or_default();
    let cache = statistics
        .lines()
        .filter_map(|line| line.split_once(' '))
        .find(|(name, _)| *name == "inactive_file" || *name == "total_inactive_file")
        .and_then(|(_, bytes)| bytes.parse().ok())
        .unwrap_or(0);
    Some(limit.saturating_sub(used.saturating_sub(cache)))
}

/// What is left below the limit of the process's address space, if there is one (Linux).
fn left_in_address_space() -> Option<u64> {
    let limits = fs::read_to_string("/proc/self/limits").ok()?;
    let line = limits.lines().find_map(|line| line.strip_prefix("Max address space"))?;
    // No number where it is unlimited.
    let limit: u64 = line.split_whitespace().next()?.parse().ok()?;
    Some(limit.saturating_sub(status("VmSize:")?))
}
