//! Scenes of volumes in Pixar's universal scene description (`.usda`, text): which grids of an
//! OpenVDB file are there, what they mean, how large a unit is and which way is up (UsdVol's
//! `Volume` and `OpenVDBAsset`).

use std::io::{Result, Write};
use std::path::{Path, PathBuf};

use glam::DMat3;

use super::mesh::About;
use super::units;
use super::vdb::{Field, FieldClass, Written};
use crate::plane::Bounds;

/// Where the volumes of a scene are: beside it.
pub fn volumes(scene: &Path) -> PathBuf {
    scene.with_extension("vdb")
}

/// Writes a scene of a file of volumes, whose surfaces have these bounds.
///
/// # Errors
/// What the writer says.
pub fn write(
    Written { fields, scale }: &Written,
    volumes: &Path,
    about: &About,
    bounds: Option<Bounds>,
    out: &mut dyn Write,
) -> Result<()> {
    let name = volumes.file_name().unwrap_or_default().to_string_lossy();
    let asset = format!("@@@./{}@@@", name.replace("@@@", "\\@@@"));
    writeln!(out, "#usda 1.0")?;
    writeln!(out, "(")?;
    writeln!(out, "    doc = {}", quoted(concat!("transect ", env!("CARGO_PKG_VERSION"))))?;
    writeln!(out, "    defaultPrim = \"sections\"")?;
    writeln!(out, "    metersPerUnit = {}", units::metres(about.units))?;
    writeln!(out, "    upAxis = \"Y\"")?;
    if !about.frame.is_empty() {
        writeln!(out, "    customLayerData = {{ string frame = {} }}", quoted(about.frame))?;
    }
    writeln!(out, ")\n")?;
    writeln!(out, "def Volume \"sections\"")?;
    writeln!(out, "{{")?;
    if let Some(Bounds { min, max }) = bounds {
        let [min, max] = [min, max].map(|corner| tuple((corner * *scale).to_array()));
        writeln!(out, "    float3[] extent = [{min}, {max}]")?;
    }
    // Rows are where the axes go.
    let [right, up, front] = about.sides.axes();
    let rows = DMat3::from_cols(right, up, front) * (1.0 / scale);
    let [x, y, z] = rows.transpose().to_cols_array_2d().map(|axis| {
        let [right, up, front] = axis;
        tuple([right, up, front, 0.0])
    });
    writeln!(out, "    matrix4d xformOp:transform = ( {x}, {y}, {z}, (0, 0, 0, 1) )")?;
    writeln!(out, "    uniform token[] xformOpOrder = [\"xformOp:transform\"]")?;
    let prims = identifiers(fields);
    for prim in &prims {
        writeln!(out, "    rel field:{prim} = </sections/{prim}>")?;
    }
    for (field, prim) in fields.iter().zip(&prims) {
        writeln!(out)?;
        write_field(field, prim, &asset, about, out)?;
    }
    writeln!(out, "}}")
}

fn write_field(
    field: &Field,
    prim: &str,
    asset: &str,
    about: &About,
    out: &mut dyn Write,
) -> Result<()> {
    writeln!(out, "    def OpenVDBAsset \"{prim}\" (")?;
    if let Some(label) = field.label {
        let material = about.material(label);
        let [r, g, b] = material.color;
        writeln!(out, "        customData = {{")?;
        writeln!(out, "            int64 label = {label}")?;
        writeln!(out, "            string label_color = \"#{r:02x}{g:02x}{b:02x}\"")?;
        writeln!(out, "            string label_name = {}", quoted(&material.name))?;
        writeln!(out, "        }}")?;
    }
    writeln!(out, "    )\n    {{")?;
    let (data, class) = match field.class {
        FieldClass::LevelSet => ("float", "levelSet"),
        FieldClass::Fog => ("float", "fogVolume"),
        FieldClass::Values => ("float", "unknown"),
        FieldClass::Numbers => ("int", "unknown"),
    };
    writeln!(out, "        asset filePath = {asset}")?;
    writeln!(out, "        token fieldName = {}", quoted(&field.name))?;
    writeln!(out, "        token fieldDataType = \"{data}\"")?;
    writeln!(out, "        token fieldClass = \"{class}\"")?;
    writeln!(out, "    }}")
}

/// The names of grids as names in a scene, which are of ASCII letters, digits and underscores; each
/// is another one.
fn identifiers(fields: &[Field]) -> Vec<String> {
    let mut all: Vec<String> = Vec::with_capacity(fields.len());
    for field in fields {
        let safe = |letter: char| if letter.is_ascii_alphanumeric() { letter } else { '_' };
        let name: String = field.name.chars().map(safe).collect();
        let numbered = (2..).map(|number| format!("{name}_{number}"));
        let mut names = std::iter::once(name.clone()).chain(numbered);
        all.extend(names.find(|name| !all.contains(name)));
    }
    all
}

fn tuple<const N: usize>(numbers: [f64; N]) -> String {
    // Adding zero makes one zero of the two.
    format!("({})", numbers.map(|number| (number + 0.0).to_string()).join(", "))
}

/// A text between quotes.
fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for letter in text.chars() {
        match letter {
            '"' | '\\' => quoted.extend(['\\', letter]),
            _ if letter.is_control() => quoted.push(' '),
            _ => quoted.push(letter),
        }
    }
    quoted + "\""
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::label::{Label, Material};
    use glam::DVec3;

    fn field(name: &str, class: FieldClass, label: Option<u32>) -> Field {
        Field { name: name.to_owned(), class, label: label.map(Label) }
    }

    #[test]
    fn a_scene_names_its_fields_its_unit_and_which_way_is_up() {
        let fields = vec![
            field("density", FieldClass::Fog, None),
            field("surface_Größe", FieldClass::LevelSet, Some(3)),
            field("surface_Gr-ße", FieldClass::LevelSet, Some(4)),
            field("label", FieldClass::Numbers, None),
        ];
        let materials =
            [Material { id: 3, name: "a \"b\" \\ c\nd".to_owned(), color: [255, 128, 0] }];
        let about = About { materials: &materials, units: "cm", frame: "LPS", ..About::default() };
        let written = Written { fields, scale: 1000.0 };
        let bounds = Some(Bounds { min: -DVec3::ONE, max: DVec3::new(0.0, 1.0, 2.0) });
        let mut bytes = Vec::new();
        write(&written, Path::new("x/a@b.vdb"), &about, bounds, &mut bytes).unwrap();
        let text = String::from_utf8(bytes).unwrap();
        for line in [
            "metersPerUnit = 0.01",
            "float3[] extent = [(-1000, -1000, -1000), (0, 1000, 2000)]",
            "rel field:surface_Gr__e = </sections/surface_Gr__e>",
            "def OpenVDBAsset \"surface_Gr__e_2\" (",
            "asset filePath = @@@./a@b.vdb@@@",
            "token fieldName = \"surface_Größe\"",
            "string label_name = \"a \\\"b\\\" \\\\ c d\"",
            "string label_color = \"#ff8000\"",
            "token fieldDataType = \"int\"",
            "string frame = \"LPS\"",
        ] {
            assert!(text.contains(line), "{line} in {text}");
        }
    }
}
