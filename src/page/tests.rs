//! Pages as a whole, of sections whose names mean harm.

use glam::DVec3;

use super::*;
use crate::change::Change;
use crate::context::Context;
use crate::grid::lattice::Resolution;
use crate::label::{Label, Material};
use crate::model::Options;
use crate::plane::Plane;
use crate::section::{Rules, Section};

/// Ends scripts, styles, attributes and comments, and turns the direction of writing.
const HOSTILE: &str =
    "</script></style><img src=x onerror=alert(1)>\"'<!--&lt;\u{2028}\u{202e}\u{7}]]>`${x}";

/// An octagon around the z axis, of a material, in a section that is unknown beyond a square.
fn slice(name: &str, height: f64, radius: f64, is_partial: bool) -> Section {
    let plane = Plane { normal: DVec3::Z, offset: height };
    let corner = |step: i32| {
        let (sin, cos) = (std::f64::consts::FRAC_PI_4 * f64::from(step)).sin_cos();
        DVec3::new(radius * cos, radius * sin, height)
    };
    let mut section = Section::builder(name, plane).region(Label(1), (0..8).map(corner));
    if is_partial {
        let square = [[2.0, -1.0], [4.0, -1.0], [4.0, 1.0], [2.0, 1.0]];
        section = section.region(Label::UNKNOWN, square.map(|[x, y]| DVec3::new(x, y, height)));
    }
    section.build(&Rules::default()).expect("a section").0
}

/// A page of so many slices, and what it says.
fn page_of(slices: Vec<Section>, name: &str) -> (String, Report) {
    let mut sections = Sections::new(slices, &Rules::default()).expect("sections");
    sections.name_materials(vec![Material { id: 1, name: name.to_owned(), color: [200, 80, 0] }]);
    sections.units = format!("mm{name}");
    sections.frame = name.to_owned();
    sections.files = vec![format!("folder/{name}.json").into()];
    let warning = crate::section::Warning { section: name.to_owned(), what: name.to_owned() };
    sections.warnings.push(warning.clone());
    sections.left_out.push(warning.clone());
    sections.notes.push(warning);
    let mut model =
        Model::new(Options { resolution: Resolution::Voxels(24), ..Options::default() });
    let mut context = Context::default();
    model.apply(Change::Add(sections), &mut context).expect("a surface");
    let check = model.check(&mut context).expect("a check");
    let surfaces = &model.derived().expect("a surface").mesh;
    let picture = PictureOptions { size: [64, 48], samples: 1, ..PictureOptions::default() };
    let parts = [Part { model: &model, check: &check }];
    let page = || {
        Page::new(&parts, surfaces, model.sections(), &picture, &crate::progress::Silent)
            .expect("a page")
    };
    let report = model.report(check.clone(), &context.stages).expect("a report");
    let text = |page: Page| {
        let mut bytes = Vec::new();
        page.write(&report, &format!("transect {name}"), &mut bytes).expect("it is written");
        String::from_utf8(bytes).expect("UTF-8")
    };
    let (one, other) = (text(page()), text(page()));
    assert!(one == other, "the same twice");
    (one, report)
}

fn five(name: &str) -> (String, Report) {
    let height = |number: i32| f64::from(number) * 0.7;
    let slices = (0..5).map(|number| {
        let name = if number == 2 { name.to_owned() } else { format!("slice {number}") };
        slice(&name, height(number), 1.0 + 0.2 * height(number), number == 3)
    });
    page_of(slices.collect(), name)
}

/// The page without its script, its styles and its data.
fn without_data(page: &str) -> String {
    let mut rest = page;
    let mut left = String::new();
    for [begin, end] in
        [["<style>", "</style>"], ["<script", "</script>"], ["<script", "</script>"]]
    {
        let (before, after) = rest.split_once(begin).expect(begin);
        left.push_str(before);
        rest = after.split_once(end).expect(end).1;
    }
    assert!(!rest.contains("<script") && !rest.contains("<style"), "{rest}");
    left + rest
}

/// The names of a page's elements, and every attribute whose name begins with "on".
fn elements(html: &str) -> Vec<&str> {
    let end =
        |text: &str| text.find(|own: char| !own.is_ascii_alphanumeric()).unwrap_or(text.len());
    html.split('<')
        .skip(1)
        .map(|tag| tag.trim_start_matches(['/', '!']))
        .map(|tag| &tag[..end(tag)])
        .collect()
}

#[test]
fn hostile_names_add_no_element_and_reach_scripts_as_they_are() {
    let (plain, hostile) = (five("liver").0, five(HOSTILE).0);
    let (plain_html, hostile_html) = (without_data(&plain), without_data(&hostile));
    assert_eq!(elements(&plain_html), elements(&hostile_html));
    for harm in ["<img src=x", "<!--", "\u{2028}", "\u{202e}", "\u{7}", "onerror=alert(1)>\""] {
        assert!(!hostile_html.contains(harm), "{harm:?}");
    }
    assert!(hostile_html.contains("&lt;/script&gt;") && hostile_html.contains("\\u{202e}"));
    let data = hostile.split_once("id=\"data\">").expect("data").1;
    let data = data.split_once("</script>").expect("its end").0;
    let data: serde_json::Value = serde_json::from_str(data).expect("JSON");
    assert_eq!(data["scene"]["bodies"][0]["name"], HOSTILE);
}

#[test]
fn nothing_in_the_script_ends_its_element() {
    for harm in ["</script", "<!--", "<script"] {
        assert!(!SCRIPT.to_lowercase().contains(harm), "{harm}");
    }
    assert!(!STYLE.contains("</style"));
    assert!(SCRIPT.starts_with("/*!") && SCRIPT.contains("MIT License"), "whose it is");
    // 32 bytes.
    assert_eq!(SCRIPT_HASH.trim().len(), 44);
}

#[test]
fn a_page_says_what_the_report_says() {
    let (page, report) = five("liver");
    let html = without_data(&page);
    let check = &report.check.labels[0];
    for word in [
        &text::quantity(check.facts.volume),
        &format!("{:.4}", report.check.dice.min.expect("sections")),
        "liver.json",
        "variational: the smoothest field",
        "The surface is closed and faces outward.",
        "There is 1 warning; 1 thing was left out.",
        "slice 4",
        "Hatched is unknown.",
        "transect liver",
    ] {
        assert!(html.contains(word), "{word}");
    }
    assert_eq!(html.matches("<figure class=\"plate\">").count(), 5);
    assert_eq!(html.matches("data:image/png;base64,").count(), 4);
    // Nothing comes from elsewhere.
    for far in ["http://", "https://", "url(//", "@import"] {
        let found = html.replace("http://www.w3.org", "").contains(far) || STYLE.contains(far);
        assert!(!found, "{far}");
    }
}

#[test]
fn many_sections_make_no_large_page() {
    let slices = (0..70).map(|number| slice(&number.to_string(), f64::from(number), 20.0, false));
    let (page, _) = page_of(slices.collect(), "liver");
    let html = without_data(&page);
    assert_eq!(html.matches("<figure class=\"plate\">").count(), 48);
    assert!(html.contains("48 of 70 sections are shown; those left out have a Dice of"));
}
