//! How far every label is from a point. Floats: what they are for is shape and
//! size, not decisions.

use glam::DVec3;

use super::Oracle;
use super::exact::Query;
use super::foot::Foot;
use super::site::Site;
use crate::label::Label;

impl Oracle<'_> {
    /// The labels that are known somewhere, sorted.
    pub fn known_labels(&self) -> &[Label] {
        &self.labels
    }

    /// For every known label the distance from a point to the nearest point of
    /// that label, in world units, sorted by label.
    pub fn distances(&self, point: DVec3) -> Vec<(Label, f64)> {
        let distances = self.distances_off_planes(point, 0.0, f64::INFINITY);
        self.labels.iter().copied().zip(distances).collect()
    }

    /// The same by [`Oracle::known_labels`]; planes that are nearer than
    /// `clearance` count as that far away, and what is more than `reach` times
    /// as far as the nearest label may come out as infinite.
    pub(super) fn distances_off_planes(
        &self,
        point: DVec3,
        clearance: f64,
        reach: f64,
    ) -> Vec<f64> {
        let query = Query::new(point);
        let mut best = vec![f64::INFINITY; self.labels.len()];
        if let Some(border) = self.border {
            self.lower(&mut best, border.label, |_| Some(border.nearest(point).0));
        }
        let height = |site: &Site| site.plane.distance(point).value.max(clearance);
        let mut heights: Vec<(f64, &Site)> =
            self.sites.iter().map(|site| (height(site), site)).collect();
        heights.sort_by(|one, other| one.0.total_cmp(&other.0));
        for (height, site) in heights {
            // Of use below this distance; 0 times infinity is not a number.
            let nearest = best.iter().copied().fold(f64::INFINITY, f64::min);
            let useful_near = |nearest: f64| reach * nearest.max(f64::MIN_POSITIVE);
            let useful = useful_near(nearest);
            if useful <= height || best.iter().all(|&distance| distance <= height) {
                break;
            }
            let foot = Foot::new(site, &query);
            let here = foot.label();
            let useful = match here {
                Label::UNKNOWN => useful,
                _ => useful.min(useful_near(height)),
            };
            for &label in &site.labels {
                self.lower(&mut best, label, |limit| match limit.min(useful) {
                    _ if label == here => Some(height),
                    limit if limit <= height => None,
                    limit => {
                        let aside = (limit * limit - height * height).sqrt();
                        Some(height.hypot(site.aside(&foot, site.around(label)?, aside)?))
                    }
                });
            }
        }
        best
    }

    /// Lowers the distance of a label to what is found below it.
    fn lower(&self, best: &mut [f64], label: Label, find: impl FnOnce(f64) -> Option<f64>) {
        if let Ok(slot) = self.labels.binary_search(&label) {
            let found = find(best[slot]).unwrap_or(f64::INFINITY);
            best[slot] = best[slot].min(found);
        }
    }
}
