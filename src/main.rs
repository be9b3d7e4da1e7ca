//! test
fn main() {
    println!("{}", transect::ffi::measure::library_versions());
}
