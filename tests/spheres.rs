//! Four balls that overlap each other: fifteen domains, one for every set of
//! balls that a point can lie in, cut by fifteen planes (the setting of
//! Barequet and Vaxman's Fig. 12).

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use transect::change::Change;
use transect::context::Context;
use transect::label::Label;
use transect::mesh::Mesh;
use transect::method::{MeanValue, Method};
use transect::model::{Model, Options};
use transect::plane::{Bounds, Plane};
use transect::section::{Edge, Rules, Section, Sections};

/// Centres and radii. The label of a domain has bit i set inside ball i.
const BALLS: [([f64; 3], f64); 4] = [
    ([0.38, 0.34, 0.36], 1.0),
    ([0.33, -0.32, -0.34], 0.95),
    ([-0.34, 0.37, -0.38], 1.05),
    ([-0.38, -0.35, 0.37], 1.0),
];
const DOMAINS: usize = 16;
/// Three directions, a little off the axes, with five planes each at these
/// distances from the middle: those that matter pass through the small domains.
const NORMALS: [[f64; 3]; 3] = [[10.0, 1.0, -1.0], [-1.0, 10.0, 2.0], [1.0, -2.0, 10.0]];
const CUTS: [f64; 5] = [-0.89, -0.39, -0.03, 0.33, 0.83];
/// Edges of a whole circle.
const STEPS: f64 = 240.0;

/// What a section of the balls is made of.
struct Cut {
    plane: Plane,
    origin: DVec3,
    tangents: [DVec3; 2],
    /// The ball, the circle's centre and its radius.
    circles: Vec<(usize, DVec2, f64)>,
    points: Vec<DVec3>,
    edges: Vec<Edge>,
}

impl Cut {
    fn new(normal: DVec3, distance: f64) -> Self {
        let plane = Plane { normal, offset: distance * normal.length() };
        let (origin, tangents) = (distance * normal.normalize(), plane.tangents());
        let circle = |(ball, &(centre, radius)): (usize, &([f64; 3], f64))| {
            let centre = DVec3::from(centre);
            let squared = radius * radius - plane.distance(centre).powi(2);
            let flat = tangents.map(|tangent| tangent.dot(centre - origin));
            (squared > 0.0).then(|| (ball, DVec2::from(flat), squared.sqrt()))
        };
        let circles = BALLS.iter().enumerate().filter_map(circle).collect();
        Self { plane, origin, tangents, circles, points: Vec::new(), edges: Vec::new() }
    }

    fn add(&mut self, point: DVec2) -> u32 {
        self.points.push(self.origin + point.x * self.tangents[0] + point.y * self.tangents[1]);
        self.points.len() as u32 - 1
    }

    /// For every circle the angles at which others cross it, ascending, with
    /// the crossings' numbers.
    fn crossings(&mut self) -> Vec<Vec<(f64, u32)>> {
        let mut crossings = vec![Vec::new(); self.circles.len()];
        for i in 0..self.circles.len() {
            for j in i + 1..self.circles.len() {
                let [(_, a, r), (_, b, s)] = [self.circles[i], self.circles[j]];
                let apart = a.distance(b);
                if apart >= r + s || apart <= (r - s).abs() {
                    continue;
                }
                let along = (apart * apart + r * r - s * s) / (2.0 * apart);
                let off = (r * r - along * along).sqrt();
                let d = (b - a) / apart;
                for side in [off, -off] {
                    let point = a + along * d + side * d.perp();
                    let number = self.add(point);
                    for (circle, centre) in [(i, a), (j, b)] {
                        let angle = (point - centre).to_angle().rem_euclid(TAU);
                        crossings[circle].push((angle, number));
                    }
                }
            }
        }
        for angles in &mut crossings {
            angles.sort_by(|one, other| one.0.total_cmp(&other.0));
        }
        crossings
    }

    /// The circles as arcs between crossings; an arc's own ball is on its left.
    fn section(mut self, name: &str) -> Section {
        let crossings = self.crossings();
        for (index, mut ends) in crossings.into_iter().enumerate() {
            let (ball, centre, radius) = self.circles[index];
            let on = move |angle: f64| centre + radius * DVec2::from_angle(angle);
            if ends.is_empty() {
                ends.push((0.0, self.add(on(0.0))));
            }
            for (place, &(from, start)) in ends.iter().enumerate() {
                let (to, end) = ends[(place + 1) % ends.len()];
                let to = if place + 1 < ends.len() { to } else { to + TAU };
                let middle = on(f64::midpoint(from, to));
                let inside = |&&(other, b, s): &&(usize, DVec2, f64)| {
                    other != ball && middle.distance(b) < s
                };
                let others = self.circles.iter().filter(inside);
                let right = others.fold(0, |set, (other, ..)| set | 1 << other);
                let steps = (STEPS * (to - from) / TAU).ceil().max(1.0) as u32;
                let mut last = start;
                for step in 1..=steps {
                    let angle = from + (to - from) * f64::from(step) / f64::from(steps);
                    let next = if step == steps { end } else { self.add(on(angle)) };
                    let (left, right) = (Label(right | 1 << ball), Label(right));
                    self.edges.push(Edge { start: last, end: next, left, right });
                    last = next;
                }
            }
        }
        let (plane, points, edges) = (self.plane, &self.points, &self.edges);
        Section::from_graph(name, plane, points, edges, 4.0, &Rules::default()).unwrap().0
    }
}

fn sections() -> Sections {
    let mut sections = Vec::new();
    for normal in NORMALS {
        for distance in CUTS {
            let name = format!("{}", sections.len() + 1);
            sections.push(Cut::new(DVec3::from(normal), distance).section(&name));
        }
    }
    Sections::new(sections, &Rules::default()).unwrap()
}

/// The volume of every domain: exact along z, the midpoint rule across. Half as
/// many columns change no volume by more than a part in a thousand.
fn volumes(columns: u32) -> [f64; DOMAINS] {
    let (low, high) = (-1.5, 1.5);
    let step = (high - low) / f64::from(columns);
    let middle = |index: u32| low + (f64::from(index) + 0.5) * step;
    let mut volumes = [0.0; DOMAINS];
    for column in 0..columns * columns {
        let at = DVec2::new(middle(column / columns), middle(column % columns));
        let span = |&([x, y, z], radius): &([f64; 3], f64)| {
            let half = (radius * radius - at.distance_squared(DVec2::new(x, y))).max(0.0).sqrt();
            [z - half, z + half]
        };
        let spans: Vec<[f64; 2]> = BALLS.iter().map(span).collect();
        let mut ends = spans.as_flattened().to_vec();
        ends.sort_by(f64::total_cmp);
        for piece in ends.windows(2) {
            let z = f64::midpoint(piece[0], piece[1]);
            let within = spans.iter().enumerate().filter(|(_, span)| span[0] < z && z < span[1]);
            let domain = within.fold(0, |set, (ball, _)| set | 1 << ball);
            volumes[domain] += (piece[1] - piece[0]) * step * step;
        }
    }
    volumes
}

/// The volume of *outside* in a box, from the triangles of the network that
/// face it and the box.
fn outside_volume(mesh: &Mesh, bounds: Bounds) -> f64 {
    let signed = |triangle: usize| {
        let [a, b, c] = mesh.triangles[triangle].map(|v| mesh.vertices[v as usize] - bounds.min);
        a.dot(b.cross(c)) / 6.0
    };
    // Outside is in front, where the normal points: its own border is turned.
    let facing = (0..mesh.triangles.len()).filter(|&i| mesh.sides[i][1] == Label::OUTSIDE);
    assert!(mesh.sides.iter().all(|sides| sides[0] != Label::OUTSIDE));
    bounds.volume() - facing.map(signed).sum::<f64>()
}

#[test]
fn all_domains_of_four_balls_come_back() {
    let expected = volumes(500);
    let coarse = volumes(250);
    for (fine, coarse) in expected.iter().zip(coarse).skip(1) {
        assert!((coarse / fine - 1.0).abs() < 1e-3, "{coarse} {fine}");
    }
    let sections = sections();
    assert_eq!(sections.sections.len(), 15);
    let mut model = Model::new(Options {
        method: Method::MeanValue(MeanValue::default()),
        ..Options::default()
    });
    let mut context = Context::default();
    model.apply(Change::Add(sections), &mut context).unwrap();
    let derived = model.derived().unwrap();
    let mesh = &derived.mesh;
    let found = model.check(&mut context).unwrap();

    assert_eq!(mesh.labels(), (1..16).map(Label).collect::<Vec<_>>());
    assert_eq!(found.labels.len(), 15);
    for label in &found.labels {
        let (facts, true_volume) = (&label.facts, expected[label.label as usize]);
        let error = facts.volume / true_volume - 1.0;
        println!("domain {:04b}: {true_volume:.4}, off by {:.2} %", label.label, 100.0 * error);
        assert!(facts.closed && facts.outward, "domain {:04b}", label.label);
        assert!(error.abs() < 0.05, "domain {:04b} is off by {error}", label.label);
    }
    let bounds = derived.complex.as_ref().expect("cells").bounds();
    let sum: f64 = found.labels.iter().map(|label| label.facts.volume).sum();
    let whole = sum + outside_volume(mesh, bounds);
    assert!((whole / bounds.volume() - 1.0).abs() < 1e-6, "{whole} of {}", bounds.volume());
}
