//! What files say, as a page shows it: nothing of it is read as HTML or as a script, and no
//! character moves what stands around it.

use maud::{Markup, html};
use serde::Serialize;

use crate::figures::{grouped, number};
use crate::label::Material;
use crate::terminal::escaped;

/// A text of a file: control characters and such as turn the direction of writing are shown, and
/// the writing around it keeps its direction.
pub fn text(text: &str) -> Markup {
    html! { bdi { (escaped(text)) } }
}

/// A value as JSON that can stand in a script element: no `<` ends it, and no separator of lines is
/// taken for the end of one.
pub fn json(value: &impl Serialize) -> serde_json::Result<String> {
    let json = serde_json::to_string(value)?;
    let mut safe = String::with_capacity(json.len());
    for character in json.chars() {
        match character {
            // In JSON they stand in texts alone.
            '<' | '>' | '&' | '\u{2028}' | '\u{2029}' => {
                safe.push_str(&format!("\\u{:04x}", u32::from(character)));
            }
            _ => safe.push(character),
        }
    }
    Ok(safe)
}

/// A place in world units.
pub fn place(at: [f64; 3]) -> String {
    format!("({})", at.map(number).join(", "))
}

/// From this on a quantity is a whole number, in groups of digits, and up to this.
const GROUPED: [f64; 2] = [1e4, 1e15];

/// A quantity without more digits than a reader wants.
pub fn quantity(value: f64) -> String {
    let [least, most] = GROUPED;
    match value {
        _ if (least..most).contains(&value) => grouped(value.round() as u64),
        _ => number(value),
    }
}

/// A quantity and its unit, to a power, if the unit is known.
pub fn with_unit(value: f64, units: &str, power: &str) -> String {
    match units {
        "" => quantity(value),
        _ => format!("{} {}{power}", quantity(value), escaped(units)),
    }
}

/// What a label is called.
pub fn name_of(label: u32, materials: &[Material]) -> String {
    let own = materials.iter().find(|material| material.id == label);
    own.map_or_else(|| format!("label {label}"), |material| escaped(&material.name))
}

/// A colour, beside a name.
pub fn swatch([red, green, blue]: [u8; 3]) -> Markup {
    html! { span.swatch style=(format!("background:#{red:02x}{green:02x}{blue:02x}")) {} }
}

/// So many of something.
pub fn counted(count: usize, one: &str, many: &str) -> String {
    match count {
        1 => format!("1 {one}"),
        _ => format!("{count} {many}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_files_say_is_neither_html_nor_script_nor_control() {
        let shown = text("</script><b>&\"\u{202e}\u{7}").into_string();
        assert_eq!(shown, "<bdi>&lt;/script&gt;&lt;b&gt;&amp;&quot;\\u{202e}\\u{7}</bdi>");
        let written = json(&["</script><!--", "a\u{2028}b\u{2029}&\"\\"]).expect("JSON");
        assert!(!written.contains(['<', '>', '&', '\u{2028}', '\u{2029}']), "{written}");
        let read: [String; 2] = serde_json::from_str(&written).expect("JSON");
        assert_eq!(read, ["</script><!--", "a\u{2028}b\u{2029}&\"\\"]);
    }

    #[test]
    fn quantities_have_units_where_these_are_known() {
        assert_eq!(with_unit(2.5, "mm", "²"), "2.50000 mm²");
        assert_eq!(with_unit(2.5, "", "²"), "2.50000");
        assert_eq!(with_unit(5.99373e6, "mm", "³"), "5 993 730 mm³");
    }
}
