//! The method of a reconstruction, from arguments: what it does not use is refused
//! by name.

use super::args::{BorderName, CapsName, DeviceName, MesherName, MethodArguments, MethodName};
use crate::choice::{Choice, Suited};
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
        MethodName::Auto => {
            let what = "--method auto chooses by all of the sections, and here they come one by \
                        one: name a method";
            return Err(Error::Option(what.to_owned()));
        }
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

/// The method that is asked for before sections are known, or that options leave when it is to
/// be chosen; `None` when the sections decide.
pub fn asked(arguments: &MethodArguments, exact: bool) -> Result<Option<Chosen>> {
    if arguments.method != MethodName::Auto {
        return Ok(Some((method(arguments, exact)?, None)));
    }
    let unused = |name: MethodName| {
        let options = options(arguments, exact).into_iter();
        options.filter(move |own| own.is_given && !own.methods.contains(&name)).map(|own| own.name)
    };
    let because = |method: Suited, options: Vec<&str>| {
        let reasons = vec![format!("{} is given", options.join(" and "))];
        chosen(arguments, exact, Choice { method, reasons }).map(Some)
    };
    let [without_stack, without_variational] =
        [MethodName::Stack, MethodName::Variational].map(|name| unused(name).collect::<Vec<_>>());
    if let Some(option) = without_stack.iter().find(|own| without_variational.contains(own)) {
        return Err(Error::Option(format!(
            "{option} is an option of methods that --method auto does not choose: leave it out, \
             or name the method"
        )));
    }
    if !without_stack.is_empty() {
        return because(Suited::Variational, without_stack);
    }
    if !without_variational.is_empty() {
        return because(Suited::Stack, without_variational);
    }
    // What is wrong with options is told before anything is read.
    chosen(arguments, exact, Choice { method: Suited::Variational, reasons: Vec::new() })?;
    Ok(None)
}

/// A method, and why it was chosen if it was.
pub type Chosen = (Method, Option<Choice>);

/// A chosen method with the options that are given.
pub fn chosen(arguments: &MethodArguments, exact: bool, choice: Choice) -> Result<Chosen> {
    let name = match choice.method {
        Suited::Variational => MethodName::Variational,
        Suited::Stack => MethodName::Stack,
    };
    let named = MethodArguments { method: name, ..arguments.clone() };
    Ok((method(&named, exact)?, Some(choice)))
}

/// An option that is for some methods alone.
struct OwnOption {
    name: &'static str,
    is_given: bool,
    methods: &'static [MethodName],
}

/// Which options there are for some methods alone, whether they are given, and the
/// methods they are for.
fn options(arguments: &MethodArguments, exact: bool) -> Vec<OwnOption> {
    use MethodName::{Hermite, Mvc, Skeleton, Stack, Variational};
    const OF_FIELD: &[MethodName] = &[Variational, Mvc, Hermite];
    const OF_GRID: &[MethodName] = &[Variational, Mvc, Hermite, Stack];
    let has_caps = |caps: CapsName| arguments.caps == Some(caps);
    let mesher = arguments.meshing.mesher != MesherName::Dual;
    let options = [
        ("--smooth", arguments.smooth.is_some(), &[Mvc] as &[MethodName]),
        ("--spacing", arguments.spacing.is_some(), &[Mvc, Hermite]),
        ("--gradients", arguments.gradients.is_some(), &[Hermite]),
        ("--density", arguments.density.is_some(), &[Hermite]),
        ("--fair", arguments.fair.is_some(), &[Skeleton]),
        ("--exact", exact, &[Skeleton]),
        ("--link", arguments.link.is_some(), &[Stack]),
        ("--device", arguments.device.is_some(), OF_FIELD),
        ("--box unknown", is_open(arguments), OF_FIELD),
        ("--caps rounded", has_caps(CapsName::Rounded), OF_GRID),
        ("--caps none", has_caps(CapsName::None), OF_GRID),
        ("--mesher delaunay", mesher, OF_GRID),
    ];
    let own = |(name, is_given, methods)| OwnOption { name, is_given, methods };
    options.into_iter().map(own).collect()
}

fn refuse_unused(arguments: &MethodArguments, exact: bool) -> Result<()> {
    if arguments.method == MethodName::Auto {
        return Ok(());
    }
    for OwnOption { name, is_given, methods } in options(arguments, exact) {
        if is_given && !methods.contains(&arguments.method) {
            let names: Vec<&str> = methods.iter().map(|method| method.name()).collect();
            return Err(Error::Option(format!(
                "{name} is an option of --method {}, and means nothing to {}: leave it out, or \
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
