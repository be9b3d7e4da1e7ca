#include "transect/cpp/skeleton/labels.h"

#include <algorithm>
#include <utility>

namespace transect::skeleton::partial {
namespace {

bool flat(const Polygon& polygon, const Kernel::Plane_3& plane) {
  return std::all_of(polygon.begin(), polygon.end(),
                     [&](const Point& corner) { return side(plane, corner) == 0; });
}

}  // namespace

RegionLabels::RegionLabels(const Region& region, const Distances& distances)
    : site_(&distances.sites()[region.owner.site]),
      zone_(&distances.zone(region.owner)),
      body_(&region.body) {
  plane_ = site_->face->plane;
  const Rough& distance = distances.rough(region.owner);
  const std::vector<Place> places = body_->places();
  const Shown seen = shown(*site_, *zone_, distance, places);
  if (!seen.is_mixed && seen.only) {
    only_ = seen.only;
    return;
  }
  double height = 0;
  for (const Place& place : places) {
    const auto [value, error] = distance.at(place);
    height = std::max(height, value + error);
  }
  height_ = height;
  if (on_face())
    across_face();
  else
    across_edge();
  if (changes_.empty()) only_ = at(centre());
}

const Point& RegionLabels::centre() const {
  if (!centre_) centre_ = body_->centre();
  return *centre_;
}

void RegionLabels::leave_region() {
  if (!only_) centre();
  body_ = nullptr;
  changes_ = {};
  changes_along_ = {};
}

std::vector<Polygon> RegionLabels::lines_on(const Halfspace& plane) const {
  std::vector<Polygon> lines;
  for (const Change& change : changes_) {
    Polygon line;
    for (const Point& corner : change.polygon) {
      if (side(plane.plane(), corner) == 0) line.push_back(corner);
    }
    if (line.size() == 2) lines.push_back(std::move(line));
  }
  return lines;
}

Point RegionLabels::foot(const Point& point) const {
  return point - zone_->rays[0] * zone_->distance.at(point);
}

void RegionLabels::across_face() {
  CGAL::Bbox_3 box;
  for (const auto& corner : body_->corners) box += foot(corner->point()).bbox();
  const Vector up = zone_->rays[0] * height_;
  const bool before = up * site_->normal > 0;
  const Face& face = *site_->face;
  for (std::size_t i = 0; i < face.segments.size(); ++i) {
    if (!CGAL::do_overlap(box, face.boxes[i])) continue;
    const auto& [from, to, left, right] = face.segments[i];
    // The polygon's normal is (to − from) × up: to the right in front of the section.
    const Polygon wall{from, to, to + up, from + up};
    add(before ? Change{wall, left, right} : Change{wall, right, left});
  }
}

void RegionLabels::across_edge() {
  const Vector along = zone_->foot[1] - zone_->foot[0];
  across_ = CGAL::cross_product(zone_->rays[0], zone_->rays[1]);
  const bool ahead = across_ * along > 0;
  if (!ahead) across_ = -across_;
  const Vector first = zone_->rays[ahead ? 0 : 1] * height_;
  const Vector second = zone_->rays[ahead ? 1 : 0] * height_;
  const auto& [stops, labels] = zone_->labels;
  for (std::size_t i = 0; i < stops.size(); ++i) {
    const Polygon fan{stops[i], stops[i] + first, stops[i] + second};
    add({fan, labels[i], labels[i + 1]});
  }
}

// Where labels change along a facet, the regions on both sides see it there.
void RegionLabels::add(Change change) {
  for (const Facet& facet : body_->facets) {
    if (!clip(change.polygon, facet.plane->plane())) return;
  }
  for (const Facet& facet : body_->facets) {
    if (!flat(change.polygon, facet.plane->plane())) continue;
    changes_along_.push_back(facet.plane);
    return;
  }
  changes_.push_back(std::move(change));
}

Number RegionLabels::past(const Point& change, const Point& point) const {
  return across_ * (point - change);
}

Label RegionLabels::at(const Point& point) const {
  if (only_) return *only_;
  if (on_face()) {
    const Point here = foot(point);
    return site_->face->map.at(here, foot(centre()) - here);
  }
  const auto& [stops, labels] = zone_->labels;
  std::size_t i = 0;
  for (; i < stops.size(); ++i) {
    const Number past_it = past(stops[i], point);
    if (past_it < 0 || (past_it == 0 && past(stops[i], centre()) < 0)) break;
  }
  return labels[i];
}

}  // namespace transect::skeleton::partial
