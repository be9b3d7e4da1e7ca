//! Writes six closed solids as meshes, to judge methods by: what is cut from them
//! and reconstructed can be compared with what they are. A picture of each lies
//! beside it.
//!
//! `cargo run --release --example solids -- FOLDER [VOXELS]`

mod formulas;
#[cfg(test)]
mod tests;

use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use transect::error::{Error, Result};
use transect::io::mesh::About;
use transect::io::ply;
use transect::label::Label;
use transect::mesh::Mesh;
use transect::picture::{PictureOptions, render, write_png};
use transect::section::Sections;

use formulas::Solid;

/// Voxels on the longest side of a solid's box, when none are asked for.
const VOXELS: u32 = 384;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (folder, voxels) = match &arguments[..] {
        [folder] => (PathBuf::from(folder), Some(VOXELS)),
        [folder, voxels] => (PathBuf::from(folder), voxels.parse().ok()),
        _ => (PathBuf::new(), None),
    };
    let Some(voxels) = voxels else {
        eprintln!("usage: solids FOLDER [VOXELS]");
        return ExitCode::from(2);
    };
    match write_all(&folder, voxels) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn write_all(folder: &Path, voxels: u32) -> Result<()> {
    fs::create_dir_all(folder).map_err(|error| Error::file(folder, error))?;
    println!(
        "{:<8}{:>14}{:>14}{:>12}{:>10}{:>7}{:>12}",
        "solid", "volume", "by formula", "components", "cavities", "genus", "triangles"
    );
    for solid in formulas::solids() {
        let mesh = formulas::mesh(&solid, voxels)?;
        print_facts(&solid, &mesh)?;
        let path = folder.join(solid.name).with_extension("ply");
        write(&mesh, &path).map_err(|error| Error::file(&path, error))?;
        let path = path.with_extension("png");
        let seen =
            if solid.truth.cavities > 0 { formulas::mesh(&solid.opened(), voxels)? } else { mesh };
        draw(&seen, &path).map_err(|error| Error::file(&path, error))?;
    }
    Ok(())
}

fn print_facts(solid: &Solid, mesh: &Mesh) -> Result<()> {
    let facts = mesh.surface(Label(1)).facts(false)?;
    let volume = solid.truth.volume.map_or("-".to_owned(), |volume| format!("{volume:.1}"));
    println!(
        "{:<8}{:>14.1}{:>14}{:>12}{:>10}{:>7}{:>12}",
        solid.name,
        facts.volume,
        volume,
        facts.components,
        facts.cavities,
        facts.genus,
        facts.triangles
    );
    Ok(())
}

fn write(mesh: &Mesh, path: &Path) -> std::io::Result<()> {
    let mut out = BufWriter::new(File::create(path)?);
    ply::write(mesh, &About::default(), &mut out)?;
    out.flush()
}

fn draw(mesh: &Mesh, path: &Path) -> std::io::Result<()> {
    let options = PictureOptions { size: [800, 600], ..PictureOptions::default() };
    let mut out = BufWriter::new(File::create(path)?);
    write_png(&render(mesh, &Sections::default(), &[], &options), &mut out)?;
    out.flush()
}
