//! The method of a reconstruction, from arguments: what it does not use is refused
//! by name.

use super::args::{BorderName, CapsName, DeviceName, MesherName, MethodArguments, MethodName};
use crate::error::{Error, Result};
use crate::field::hermite;
use crate::label::Label;
use crate::method::{
    Caps, Fairing, Hermite, Linking, MeanValue, Method, ShapeBased, Skeleton, Variational,
};
use crate::skeleton;

/// The method that arguments ask for, with exact coordinates or without.
pub fn method(arguments: &MethodArguments, exact: bool) -> Result<Method> {
    refuse_unused(arguments, exact)?;
    Ok(match arguments.method {
        MethodName::Variational => Method::Variational(Variational {
            border: border(arguments),
            caps: caps(arguments)?,
            device: device(arguments),
            mesher: arguments.meshing.mesher()?,
            ..Variational::default()
        }),
        MethodName::Mvc => Method::MeanValue(MeanValue {
            smooth: arguments.smooth.unwrap_or(MeanValue::default().smooth),
            border: border(arguments),
            caps: caps(arguments)?,
            device: device(arguments),
            spacing: arguments.spacing,
            mesher: arguments.meshing.mesher()?,
        }),
        MethodName::Hermite => Method::Hermite(Hermite {
            interpolation: hermite::Options {
                spacing: arguments.spacing,
                gradients: arguments.gradients.map_or_else(Default::default, Into::into),
                density: arguments.density.map_or(hermite::Options::default().density, Into::into),
            },
            border: border(arguments),
            caps: caps(arguments)?,
            device: device(arguments),
            mesher: arguments.meshing.mesher()?,
        }),
        MethodName::Stack => Method::Stack(ShapeBased {
            link: arguments.link.map(|farthest| Linking { farthest }),
            caps: caps(arguments)?,
            mesher: arguments.meshing.mesher()?,
        }),
        MethodName::Skeleton => Method::Skeleton(Skeleton {
            exactness: skeleton::Options { exact, ..skeleton::Options::default() },
            fairing: arguments.fair.map(|edge_length| Fairing { edge_length }),
        }),
    })
}

fn border(arguments: &MethodArguments) -> Label {
    arguments.border.unwrap_or(BorderName::Outside).into()
}

/// In an open box nothing is rounded, and what leaves it is open unless it is closed.
fn caps(arguments: &MethodArguments) -> Result<Caps> {
    match (is_open(arguments), arguments.caps) {
        (false, given) => Ok(given.map_or(Caps::default(), Caps::from)),
        (true, None) => Ok(Caps::None),
        (true, Some(CapsName::Rounded)) => Err(Error::Option(
            "--caps rounded means nothing with --box unknown, where materials go on up to the \
             box's faces: choose --caps flat to close surfaces there, or none to leave them open"
                .to_owned(),
        )),
        (true, Some(given)) => Ok(given.into()),
    }
}

fn is_open(arguments: &MethodArguments) -> bool {
    arguments.border.is_some_and(|border| border != BorderName::Outside)
}

fn device(arguments: &MethodArguments) -> crate::field::Device {
    arguments.device.unwrap_or(DeviceName::Auto).into()
}

/// Which options there are for some methods alone, whether they are given, and the
/// methods they are for.
fn refuse_unused(arguments: &MethodArguments, exact: bool) -> Result<()> {
    use MethodName::{Hermite, Mvc, Skeleton, Stack, Variational};
    let of_field: &[MethodName] = &[Variational, Mvc, Hermite];
    let of_grid: &[MethodName] = &[Variational, Mvc, Hermite, Stack];
    let has_caps = |caps: CapsName| arguments.caps == Some(caps);
    let mesher = arguments.meshing.mesher != MesherName::Dual;
    let options = [
        ("--smooth", arguments.smooth.is_some(), &[Mvc][..]),
        ("--spacing", arguments.spacing.is_some(), &[Mvc, Hermite]),
        ("--gradients", arguments.gradients.is_some(), &[Hermite]),
        ("--density", arguments.density.is_some(), &[Hermite]),
        ("--fair", arguments.fair.is_some(), &[Skeleton]),
        ("--exact", exact, &[Skeleton]),
        ("--link", arguments.link.is_some(), &[Stack]),
        ("--device", arguments.device.is_some(), of_field),
        ("--box unknown", is_open(arguments), of_field),
        ("--caps rounded", has_caps(CapsName::Rounded), of_grid),
        ("--caps none", has_caps(CapsName::None), of_grid),
        ("--mesher delaunay", mesher, of_grid),
    ];
    for (option, is_given, methods) in options {
        if is_given && !methods.contains(&arguments.method) {
            let names: Vec<&str> = methods.iter().map(|method| method.name()).collect();
            return Err(Error::Option(format!(
                "{option} is an option of --method {}, and means nothing to {}: leave it out, or \
                 choose another method",
                names.join(" and "),
                arguments.method.name()
            )));
        }
    }
    if exact && arguments.fair.is_some() {
        let what = "--fair moves vertices away from their exact places: leave it or --exact out";
        return Err(Error::Option(what.to_owned()));
    }
    Ok(())
}
