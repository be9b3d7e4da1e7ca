//! Errors in the command line's words, which alone knows what its options are called.

use crate::error::{Error, Remedy};
use crate::terminal::shortened;

/// An error as one line, whatever a library's words contain. What is long is cut short, but for
/// the names of files.
pub fn line(error: &Error) -> String {
    match error {
        Error::Avoidable { error, remedy } => format!("{}{}", line(error), option(*remedy)),
        Error::Device(what) => format!("GPU: {}; use --device cpu", shortened(what)),
        Error::File { file, what } => format!("{}: {}", file.display(), shortened(what)),
        Error::Input { file, place, what } => {
            format!("{}: {}: {}", file.display(), shortened(place), shortened(what))
        }
        other => shortened(&other.to_string()),
    }
}

/// In place of the library's words, by options.
fn option(remedy: Remedy) -> &'static str {
    match remedy {
        Remedy::CoarserLattice => "; use a lower --resolution or a larger --voxel-size",
        Remedy::LongerEdges => "; use a larger --fair",
        Remedy::LargerTriangles => "; use a larger --facet-size or --facet-distance",
        Remedy::LargerSpacing => "; use a larger --spacing",
        Remedy::NotStrict => " (an error because warnings are, --strict)",
        Remedy::Overlap => ", or say who wins with --overlap first|last|smallest",
        Remedy::UnknownLabel => "; give another --unknown-label, or none",
        Remedy::ImageSpacing => {
            "; give it in world units with --spacing-xyz DX,DY,DZ, or DZ alone where pictures say \
             the rest"
        }
        Remedy::Structures => {
            ": choose one with --structures NAME, or let them exclude each other with --partition"
        }
        Remedy::OtherGrids => ", or leave the grid out of --grids",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_that_can_be_done_is_named_by_its_options() {
        let error = Error::Option("label 7\n does not occur".to_owned());
        let error = error.avoidable(Remedy::UnknownLabel).avoidable(Remedy::NotStrict);
        assert!(!error.to_string().contains("--"), "{error}");
        let line = line(&error);
        assert!(line.starts_with("label 7 does not occur; "), "{line}");
        assert!(line.contains("--unknown-label") && line.contains("--strict"), "{line}");
        assert!(super::line(&Error::Device("it is gone".to_owned())).ends_with("--device cpu"));
    }
}
