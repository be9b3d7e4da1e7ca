//! A sequence of tracked frames, as Plus and 3D Slicer write them: pictures, and for each of them
//! how tools lay to each other (`Seq_Frame0007_ProbeToTrackerTransform`) and whether that was seen.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::{self, Write};

use glam::{DMat4, DVec4};
use serde::Serialize;

use super::Checked;
use super::header::Header;
use crate::io::text::shortened;
use crate::terminal::Lines;

/// What the keys of a frame begin with.
const FRAME: &str = "Seq_Frame";
/// What pixels are numbered in: x to the right in the picture, y down.
const IMAGE: &str = "Image";
/// Where the world is, if a sequence says it: the first of these that a chain leads to.
const FIXED: [&str; 6] = ["RAS", "Ras", "World", "Patient", "Reference", "Tracker"];

/// A transform's name: from one coordinate system to another.
type Pair = [String; 2];

/// What a header says of the frames.
#[derive(Debug, Default)]
pub struct Sequence {
    /// As the header gives it; empty where it does not.
    pub orientation: String,
    /// How many frames the file has.
    pub count: usize,
    /// What holds for all frames.
    common: BTreeMap<Pair, DMat4>,
    /// By number; those of which nothing is said are not there.
    frames: BTreeMap<usize, Frame>,
}

#[derive(Debug, Default)]
struct Frame {
    transforms: BTreeMap<Pair, DMat4>,
    /// What was not seen.
    lost: BTreeSet<Pair>,
    image_is_lost: bool,
}

/// Coordinate systems from that of the pixels to the world, each tied to the next.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct Chain(Vec<String>);

impl Chain {
    /// What the world is called.
    pub fn world(&self) -> &str {
        self.0.last().map_or("", String::as_str)
    }
}

impl fmt::Display for Chain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0.join(" → "))
    }
}

impl Sequence {
    /// What a header says of frames; `None` where it is no sequence.
    pub fn read(header: &Header) -> Checked<Option<Self>> {
        if !header.entries().any(|(key, _)| key.starts_with(FRAME)) {
            return Ok(None);
        }
        let mut sequence = Self::default();
        if let Some(sizes) = header.numbers::<usize>(&["DimSize"], 3)? {
            sequence.count = sizes[2];
        }
        for (key, value) in header.entries() {
            match key.strip_prefix(FRAME).and_then(|rest| rest.split_once('_')) {
                Some((number, name)) => sequence.add(key, number, name, value)?,
                None if key == "UltrasoundImageOrientation" => {
                    sequence.orientation = value.to_uppercase();
                }
                None => {
                    if let Some(pair) = key.strip_suffix("Transform").and_then(pair) {
                        sequence.common.insert(pair, matrix(key, value)?);
                    }
                }
            }
        }
        Ok(Some(sequence))
    }

    /// One entry of a frame.
    fn add(&mut self, key: &str, number: &str, name: &str, value: &str) -> Checked<()> {
        let number: usize = number
            .parse()
            .map_err(|_| format!("{:?} is about no frame: correct its number", shortened(key)))?;
        if number >= self.count {
            return Err(format!("it tells of frame {number}, and has {}, from 0", self.count));
        }
        let frame = self.frames.entry(number).or_default();
        if name == "ImageStatus" {
            frame.image_is_lost = value != "OK";
        } else if let Some(pair) = name.strip_suffix("TransformStatus").and_then(pair) {
            if value != "OK" {
                frame.lost.insert(pair);
            }
        } else if let Some(pair) = name.strip_suffix("Transform").and_then(pair) {
            frame.transforms.insert(pair, matrix(key, value)?);
        }
        Ok(())
    }

    /// All transforms that there are.
    fn pairs(&self) -> BTreeSet<&Pair> {
        let of_frames = self.frames.values().flat_map(|frame| frame.transforms.keys());
        self.common.keys().chain(of_frames).collect()
    }

    /// The chain from pixels to the world: to the first of the fixed systems that any frame leads
    /// to, else to what is farthest along.
    ///
    /// # Errors
    /// What is missing.
    pub fn chain(&self) -> Checked<Chain> {
        let pairs = self.pairs();
        let names: BTreeSet<&String> = pairs.iter().copied().flatten().collect();
        if !names.contains(&IMAGE.to_owned()) {
            return Err(self.missing(&names));
        }
        let mut chains = chains(&pairs);
        let rank = |chain: &Chain| {
            let fixed = FIXED.iter().position(|&name| name == chain.world());
            (fixed.unwrap_or(FIXED.len()), usize::MAX - chain.0.len())
        };
        chains.sort_by_key(rank);
        let leads = |chain: &&Chain| !self.matrices(chain).is_empty();
        let found = chains.iter().find(leads).cloned();
        found.ok_or_else(|| "not one of its frames is OK: record it again".to_owned())
    }

    /// What is not there where nothing leads from the pixels.
    fn missing(&self, names: &BTreeSet<&String>) -> String {
        if names.is_empty() {
            return "it holds no transforms, so nobody knows where its frames lie".to_owned();
        }
        let to = match names.iter().find(|name| name.as_str() == "Probe") {
            Some(_) => "Probe".to_owned(),
            None => names.first().map_or_else(String::new, ToString::to_string),
        };
        let known: Vec<String> =
            self.pairs().iter().map(|[from, to]| format!("{from}To{to}")).collect();
        format!(
            "nothing says where pixels lie: it holds {}, and {IMAGE}To{to} is missing: add the \
             calibration to its header, as {IMAGE}To{to}Transform = 16 numbers by rows",
            known.join(", ")
        )
    }

    /// For every frame that is OK along a chain its number, and where its pixels lie in the world.
    pub fn matrices(&self, chain: &Chain) -> Vec<(usize, DMat4)> {
        let of = |(&number, frame): (&usize, &Frame)| {
            let matrix = self.matrix(frame, chain).filter(|_| !frame.image_is_lost)?;
            Some((number, matrix))
        };
        self.frames.iter().filter_map(of).collect()
    }

    /// From pixels to the world.
    fn matrix(&self, frame: &Frame, chain: &Chain) -> Option<DMat4> {
        let known = |pair: &Pair| {
            let own = frame.transforms.get(pair).or_else(|| self.common.get(pair));
            own.filter(|_| !frame.lost.contains(pair))
        };
        let mut all = DMat4::IDENTITY;
        for step in chain.0.windows(2) {
            let [from, to] = [step[0].clone(), step[1].clone()];
            let there = known(&[from.clone(), to.clone()]).copied();
            let step = there.or_else(|| known(&[to, from]).map(DMat4::inverse))?;
            all = step * all;
        }
        all.is_finite().then_some(all)
    }

    /// How many frames have a picture and all transforms that they mention.
    fn whole(&self) -> usize {
        let is_whole = |frame: &&Frame| !frame.image_is_lost && frame.lost.is_empty();
        self.frames.values().filter(is_whole).count()
    }

    /// What there is to know about it.
    pub fn facts(&self, file: String, size: [usize; 2]) -> Facts {
        let chain = self.chain();
        let transform = |&pair: &&Pair| {
            let is_ok = |frame: &&Frame| {
                let is_there = frame.transforms.contains_key(pair);
                (is_there || self.common.contains_key(pair)) && !frame.lost.contains(pair)
            };
            let [from, to] = pair;
            let ok = self.frames.values().filter(is_ok).count();
            TransformFacts { name: format!("{from}To{to}"), ok }
        };
        Facts {
            file,
            size,
            frames: self.count,
            ok: match &chain {
                Ok(chain) => self.matrices(chain).len(),
                Err(_) => self.whole(),
            },
            orientation: self.orientation.clone(),
            transforms: self.pairs().iter().map(transform).collect(),
            missing: chain.as_ref().err().cloned(),
            chain: chain.ok(),
        }
    }
}

/// What there is to know about a sequence, whether its frames hold labels or not.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Facts {
    /// The file.
    pub file: String,
    /// Pixels of a row, and rows.
    pub size: [usize; 2],
    /// How many frames there are.
    pub frames: usize,
    /// How many of them have a picture and what the chain needs, or without a chain all that the
    /// sequence holds.
    pub ok: usize,
    /// As the header gives it; empty where it does not.
    pub orientation: String,
    /// All transforms.
    pub transforms: Vec<TransformFacts>,
    /// From pixels to the world; absent where something is missing.
    pub chain: Option<Chain>,
    /// What is missing.
    pub missing: Option<String>,
}

/// A transform of a sequence.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct TransformFacts {
    /// `ProbeToTracker`
    pub name: String,
    /// In how many frames it was seen.
    pub ok: usize,
}

/// All chains from the pixels on, none longer than it must be.
fn chains(pairs: &BTreeSet<&Pair>) -> Vec<Chain> {
    let mut chains = vec![Chain(vec![IMAGE.to_owned()])];
    let mut seen = BTreeSet::from([IMAGE.to_owned()]);
    let mut next = 0;
    while let Some(Chain(names)) = chains.get(next).cloned() {
        let end = names.last().cloned().unwrap_or_default();
        let others = pairs.iter().filter_map(|[from, to]| match () {
            () if *from == end => Some(to),
            () if *to == end => Some(from),
            () => None,
        });
        for other in others {
            if seen.insert(other.clone()) {
                chains.push(Chain(names.iter().chain([other]).cloned().collect()));
            }
        }
        next += 1;
    }
    chains.split_off(1)
}

/// `ProbeToTracker`: names begin with capitals, and so "To" is what stands before one.
fn pair(name: &str) -> Option<Pair> {
    let is_between = |&(at, _): &(usize, &str)| {
        at > 0 && name[at + 2..].starts_with(|first: char| first.is_ascii_uppercase())
    };
    let (at, _) = name.match_indices("To").find(is_between)?;
    Some([name[..at].to_owned(), name[at + 2..].to_owned()])
}

/// 16 numbers by rows, the last of them 0 0 0 1.
fn matrix(key: &str, text: &str) -> Checked<DMat4> {
    let numbers = text.split_whitespace().map(str::parse::<f64>).collect::<Result<Vec<_>, _>>();
    let numbers: Option<[f64; 16]> = numbers.ok().and_then(|numbers| numbers.try_into().ok());
    let matrix = numbers.map(|numbers| DMat4::from_cols_array(&numbers).transpose());
    matrix.filter(|matrix| matrix.row(3) == DVec4::W && matrix.is_finite()).ok_or_else(|| {
        format!("{key} is {:?}: 16 numbers belong there, the last four 0 0 0 1", shortened(text))
    })
}

impl fmt::Display for Facts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut lines = Lines::default();
        self.write(&mut lines)?;
        f.write_str(lines.as_str())
    }
}

impl Facts {
    fn write(&self, f: &mut Lines) -> fmt::Result {
        let [width, height] = self.size;
        let orientation = match self.orientation.as_str() {
            "" => "unknown, taken as MF",
            known => known,
        };
        writeln!(f, "sequence      {}", self.file)?;
        writeln!(f, "frames        {}, {} of them OK", self.frames, self.ok)?;
        writeln!(f, "pixels        {width} × {height}, orientation {orientation}")?;
        writeln!(f, "transforms    {}", self.transforms.len())?;
        for TransformFacts { name, ok } in &self.transforms {
            writeln!(f, "  {name}, OK in {ok} frames")?;
        }
        match (&self.chain, &self.missing) {
            (Some(chain), _) => writeln!(f, "chain         {chain}"),
            (None, missing) => {
                writeln!(f, "chain         none: {}", missing.as_deref().unwrap_or_default())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_split_where_a_capital_follows() {
        let split = |name: &str| pair(name).map(|[from, to]| [from, to].join(" "));
        assert_eq!(split("ProbeToTracker").as_deref(), Some("Probe Tracker"));
        assert_eq!(split("StylusTipToTool").as_deref(), Some("StylusTip Tool"));
        assert_eq!(split("ToolToTracker").as_deref(), Some("Tool Tracker"));
        assert_eq!(split("ToTracker"), None);
        assert_eq!(split("Time"), None);
    }

    fn sequence(lines: &str) -> Sequence {
        let text = format!("NDims = 3\nDimSize = 4 3 3\n{lines}\nElementDataFile = LOCAL\n");
        let (header, _) = Header::read(text.as_bytes()).expect("a header");
        Sequence::read(&header).expect("sound").expect("a sequence")
    }

    const MOVE: &str = "1 0 0 10 0 1 0 0 0 0 1 0 0 0 0 1";

    #[test]
    fn the_chain_leads_to_what_is_fixed_whichever_way_round_transforms_are() {
        let all = |number: usize| {
            format!(
                "Seq_Frame000{number}_ProbeToTrackerTransform = {MOVE}\n\
                 Seq_Frame000{number}_StylusToTrackerTransform = {MOVE}\n\
                 Seq_Frame000{number}_ReferenceToTrackerTransform = 1 0 0 3 0 1 0 0 0 0 1 0 0 0 0 1"
            )
        };
        let lines = format!(
            "{}\n{}\nImageToProbeTransform = 2 0 0 0 0 2 0 0 0 0 2 0 0 0 0 1",
            all(0),
            all(1)
        );
        let own = sequence(&lines);
        let chain = own.chain().expect("a chain");
        assert_eq!(chain.to_string(), "Image → Probe → Tracker → Reference");
        let matrices = own.matrices(&chain);
        assert_eq!(matrices.len(), 2);
        assert_eq!(matrices[1].1.transform_point3(glam::DVec3::X), glam::DVec3::new(9.0, 0.0, 0.0));
        // What was not seen.
        let lost = "\nSeq_Frame0001_ReferenceToTrackerTransformStatus = OUT_OF_VIEW";
        let own = sequence(&(lines.clone() + lost));
        assert_eq!(own.matrices(&chain).len(), 1);
        let lost = lost.to_owned() + &lost.replace("0001", "0000");
        let own = sequence(&(lines + &lost));
        assert_eq!(own.chain().expect("a chain").to_string(), "Image → Probe → Tracker");
    }

    #[test]
    fn what_is_missing_is_said() {
        let own = sequence(&format!("Seq_Frame0000_ProbeToTrackerTransform = {MOVE}"));
        let missing = own.chain().expect_err("nothing leads from the pixels");
        assert!(missing.contains("ImageToProbe is missing"), "{missing}");
        let own = sequence("Seq_Frame0000_Timestamp = 1");
        assert!(own.chain().expect_err("none").contains("no transforms"));
        let read = |line: &str| {
            let text = format!("DimSize = 4 3 3\n{line}\nElementDataFile = LOCAL\n");
            Sequence::read(&Header::read(text.as_bytes()).expect("a header").0).map(drop)
        };
        let wrong = |line: &str| read(line).expect_err("it is wrong");
        assert!(wrong("Seq_Frame0003_ImageStatus = OK").contains("frame 3, and has 3"));
        assert!(wrong("Seq_FrameX_ImageStatus = OK").contains("no frame"));
        assert!(wrong("Seq_Frame0001_AToBTransform = 1 2 3").contains("16 numbers"));
        let projective = MOVE.replace("0 0 0 1", "0 0 1 1");
        assert!(wrong(&format!("Seq_Frame0001_AToBTransform = {projective}")).contains("0 0 0 1"));
    }
}
