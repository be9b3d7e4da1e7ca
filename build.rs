//! Builds the C++ side: `cmake/` finds CGAL and OpenVDB and writes their flags
//! to a text file; every `src/ffi/NAME.rs` bridge is compiled with its
//! `cpp/NAME.cc`.

use std::path::{Path, PathBuf};
use std::{env, fs};

fn main() {
    // Lints look at the Rust side alone, and a run of theirs would compile all of the C++ side for
    // itself.
    println!("cargo:rerun-if-env-changed=TRANSECT_RUST_ONLY");
    if env::var_os("TRANSECT_RUST_ONLY").is_some() {
        return;
    }
    let bridges = files_with("src/ffi", "rs")
        .into_iter()
        .filter(|path| path.file_name().is_some_and(|name| name != "mod.rs"))
        .collect::<Vec<_>>();
    let sources =
        ["cpp", "cpp/complex", "cpp/skeleton"].map(|folder| files_with(folder, "cc")).concat();

    let flags = library_flags();
    let mut build = cxx_build::bridges(&bridges);
    build
        .std("c++17")
        .files(&sources)
        .flag_if_supported("-frounding-math") // CGAL's interval arithmetic needs it
        .opt_level(2)
        .warnings(true)
        .extra_warnings(true)
        .debug(false); // CGAL's templates make for a gigabyte of it
    // System headers, of which compilers do not warn: cxx's and those of other libraries. A folder
    // that is given both ways (cxx-build gives its own with -I) counts as a system one.
    let generated = PathBuf::from(env::var("OUT_DIR").expect("cargo sets it"));
    let generated = generated.join("cxxbridge/include").display().to_string();
    for folder in values(&flags, "include").into_iter().chain([generated.as_str()]) {
        build.flag("-isystem").flag(folder);
    }
    // Which of GCC's and clang's sanitizers watch the C++ side, as in `address,undefined`.
    println!("cargo:rerun-if-env-changed=TRANSECT_SANITIZE");
    let sanitizers = env::var("TRANSECT_SANITIZE").unwrap_or_default();
    for sanitizer in sanitizers.split(',').filter(|name| !name.is_empty()) {
        build.flag(format!("-fsanitize={sanitizer}")).flag("-fno-sanitize-recover=all");
        // Quick to build, and lines stay what they are.
        build.flag("-fno-omit-frame-pointer").flag("-g1").opt_level(1);
    }
    // CGAL's assertions, and ours: for tests. These also fail by a warning, unless sanitizers are
    // on, whose code the compiler warns of where there is nothing.
    if env::var_os("CARGO_FEATURE_ASSERTIONS").is_none() {
        build.define("NDEBUG", None);
    } else {
        build.warnings_into_errors(sanitizers.is_empty());
    }
    for definition in values(&flags, "define") {
        let (name, value) = match definition.split_once('=') {
            Some((name, value)) => (name, Some(value)),
            None => (definition, None),
        };
        build.define(name, value);
    }
    for option in values(&flags, "option") {
        build.flag_if_supported(option);
    }
    build.compile("transect_cpp");

    for library in values(&flags, "link") {
        link(library);
    }
    for sanitizer in sanitizers.split(',') {
        match sanitizer {
            "address" => link("-lasan"),
            "undefined" => link("-lubsan"),
            "thread" => link("-ltsan"),
            _ => {}
        }
    }
    for folder in ["src/ffi", "cpp", "cpp/complex", "cpp/skeleton", "cmake"] {
        println!("cargo:rerun-if-changed={folder}");
        for path in files_with(folder, "") {
            println!("cargo:rerun-if-changed={}", path.display());
        }
    }
}

/// The lines of `flags.txt`, which `cmake/CMakeLists.txt` writes.
fn library_flags() -> Vec<(String, String)> {
    let built = cmake::Config::new("cmake").build_target("flags").build();
    let path = built.join("build").join("flags.txt");
    let text = fs::read_to_string(&path)
        .unwrap_or_else(|error| panic!("cannot read {}: {error}", path.display()));
    text.lines()
        .filter_map(|line| line.split_once(' '))
        .map(|(key, value)| (key.to_owned(), value.trim().to_owned()))
        .filter(|(_, value)| !value.is_empty())
        .collect()
}

fn values<'a>(flags: &'a [(String, String)], key: &str) -> Vec<&'a str> {
    flags.iter().filter(|(name, _)| name == key).map(|(_, value)| value.as_str()).collect()
}

/// A library is given by its path, or as `-lNAME`.
fn link(library: &str) {
    if let Some(name) = library.strip_prefix("-l") {
        println!("cargo:rustc-link-lib={name}");
        return;
    }
    let path = Path::new(library);
    if let Some(folder) = path.parent() {
        println!("cargo:rustc-link-search=native={}", folder.display());
    }
    let file = path.file_name().unwrap_or_default().to_string_lossy();
    let name = file.strip_prefix("lib").unwrap_or(&file);
    let name = name.split('.').next().unwrap_or(name);
    println!("cargo:rustc-link-lib={name}");
}

/// The files in `folder` with this extension (any, when it is empty), sorted.
fn files_with(folder: &str, extension: &str) -> Vec<PathBuf> {
    let mut paths: Vec<PathBuf> = fs::read_dir(folder)
        .unwrap_or_else(|error| panic!("cannot read {folder}: {error}"))
        .filter_map(|entry| entry.ok())
        .map(|entry| entry.path())
        .filter(|path| {
            extension.is_empty() || path.extension().is_some_and(|found| found == extension)
        })
        .collect();
    paths.sort();
    paths
}
