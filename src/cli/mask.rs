//! `transect mask`: parts of sections made unknown, for experiments.

use super::args::MaskArguments;
use super::print_warnings;
use crate::error::{Error, Result};
use crate::io;
use crate::mask::{Blobs, Mask, mask};
use crate::output::Outputs;

/// Reads, masks and writes.
pub fn run(arguments: &MaskArguments) -> Result<()> {
    let path = &arguments.output;
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    if ending != "json" {
        let what = "only .json has a word for unknown regions: name such a file";
        return Err(Error::file(path, what));
    }
    let mut outputs = Outputs::reserve([path.as_path()])?;
    let sections = arguments.input.read()?;
    if !arguments.quiet {
        print_warnings(&sections);
    }
    let (size, seed) = (arguments.blob_size, arguments.seed);
    let blobs = arguments.blobs.map(|fraction| Blobs { fraction, size, seed });
    let masked = mask(sections, &Mask { blobs, frame: arguments.extent })?;
    outputs.write(path, |out| io::json::write(&masked, out))?;
    outputs.commit()
}
