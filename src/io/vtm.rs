//! VTK's multiblock data sets (`.vtm`): a file that names others, one for the surface of each
//! label. As VTK writes them, those are in a folder called as the file is, less its ending.

use std::io::{Result, Write};
use std::path::{Path, PathBuf};

use super::mesh::About;
use super::text::attribute;
use crate::label::Label;

/// What the name of a block's file ends in.
const BLOCK: &str = "vtp";

/// Where the surface of a label is, for a `.vtm` at a path.
pub fn block(path: &Path, label: Label) -> PathBuf {
    let folder = path.with_extension("");
    let stem = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
    folder.join(block_name(&stem, label))
}

fn block_name(stem: &str, label: Label) -> String {
    format!("{stem}_{label}.{BLOCK}")
}

/// Writes the file that names the others, a block for every material.
pub fn write(about: &About, out: &mut dyn Write) -> Result<()> {
    writeln!(out, "<?xml version=\"1.0\"?>")?;
    writeln!(
        out,
        "<VTKFile type=\"vtkMultiBlockDataSet\" version=\"1.0\" byte_order=\"LittleEndian\" \
         header_type=\"UInt64\">\n<vtkMultiBlockDataSet>"
    )?;
    for (index, material) in about.materials.iter().enumerate() {
        let file = format!("{}/{}", about.stem, block_name(about.stem, Label(material.id)));
        writeln!(
            out,
            "<DataSet index=\"{index}\" name=\"{}\" file=\"{}\"/>",
            attribute(&material.name),
            attribute(&file)
        )?;
    }
    writeln!(out, "</vtkMultiBlockDataSet>\n</VTKFile>")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::label::Material;

    #[test]
    fn blocks_are_named_where_they_are() {
        let names = ["a<b>", "c \"d\" & e\u{7}"];
        let material =
            |(id, name): (u32, &&str)| Material { id, name: (*name).to_owned(), color: [0; 3] };
        let materials: Vec<Material> = (3..).zip(&names).map(material).collect();
        let about = About { materials: &materials, stem: "x&y.z", ..About::default() };
        let mut bytes = Vec::new();
        write(&about, &mut bytes).unwrap();
        let text = String::from_utf8(bytes).unwrap();
        assert!(text.contains("name=\"a&lt;b&gt;\" file=\"x&amp;y.z/x&amp;y.z_3.vtp\""), "{text}");
        assert!(text.contains("name=\"c &quot;d&quot; &amp; e \""), "{text}");
        let file = block(Path::new("out/x&y.z.vtm"), Label(4));
        assert_eq!(file, Path::new("out/x&y.z/x&y.z_4.vtp"));
    }
}
