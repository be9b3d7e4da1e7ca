//! The command line of transect.

use std::process::ExitCode;

#[global_allocator]
static ALLOCATOR: transect::Allocator = transect::Allocator;

fn main() -> ExitCode {
    // Mesa's device-select layer prints a line that looks like an error of
    // ours wherever XDG_RUNTIME_DIR is unset.
    // SAFETY: no other thread runs yet.
    unsafe { std::env::set_var("NODEVICE_SELECT", "1") };
    transect::run()
}
