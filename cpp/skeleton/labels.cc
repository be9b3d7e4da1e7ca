#include "transect/cpp/skeleton/labels.h"

#include <algorithm>
#include <utility>

namespace transect::skeleton::partial {
namespace {

CGAL::Bbox_3 bounds(const std::vector<Point>& points) {
  CGAL::Bbox_3 box;
  for (const Point& point : points) box += point.bbox();
  return box;
}

bool flat(const Polygon& polygon, const Halfspace& plane) {
  return std::all_of(polygon.begin(), polygon.end(),
                     [&](const Point& corner) { return side(plane, corner) == 0; });
}

}  // namespace

RegionLabels::RegionLabels(const Region& region, const Site& site)
    : site_(site), zone_(site.zones[region.owner.zone]), centre_(region.body.centre()) {
  double height = 0;
  for (const Point& point : region.body.points) {
    height = std::max(height, CGAL::to_interval(zone_.distance.at(point)).second);
  }
  height_ = height;
  if (on_face()) across_face(region);
  if (zone_.foot.size() == 2) across_edge(region);
}

Point RegionLabels::foot(const Point& point) const {
  return point - zone_.rays[0] * zone_.distance.at(point);
}

void RegionLabels::across_face(const Region& region) {
  std::vector<Point> feet;
  for (const Point& point : region.body.points) feet.push_back(foot(point));
  const CGAL::Bbox_3 box = bounds(feet);
  const Vector up = zone_.rays[0] * height_;
  const bool before = up * site_.normal > 0;
  for (const Segment& segment : site_.face->segments) {
    const auto& [from, to, left, right] = segment;
    if (!CGAL::do_overlap(box, from.bbox() + to.bbox())) continue;
    // The polygon's normal is (to − from) × up: to the right in front of the section.
    const Polygon wall{from, to, to + up, from + up};
    add(region, before ? Change{wall, left, right} : Change{wall, right, left});
  }
}

void RegionLabels::across_edge(const Region& region) {
  const Vector along = zone_.foot[1] - zone_.foot[0];
  across_ = CGAL::cross_product(zone_.rays[0], zone_.rays[1]);
  const bool ahead = across_ * along > 0;
  if (!ahead) across_ = -across_;
  const Vector first = zone_.rays[ahead ? 0 : 1] * height_;
  const Vector second = zone_.rays[ahead ? 1 : 0] * height_;
  const auto& [stops, labels] = zone_.labels;
  for (std::size_t i = 0; i < stops.size(); ++i) {
    const Polygon fan{stops[i], stops[i] + first, stops[i] + second};
    add(region, {fan, labels[i], labels[i + 1]});
  }
}

// Where labels change along a facet, the regions on both sides see it there.
void RegionLabels::add(const Region& region, Change change) {
  for (const Facet& facet : region.body.facets) {
    if (!clip(change.polygon, *facet.plane)) return;
  }
  for (const Facet& facet : region.body.facets) {
    if (flat(change.polygon, *facet.plane)) return;
  }
  changes_.push_back(std::move(change));
}

Number RegionLabels::past(const Point& change, const Point& point) const {
  return across_ * (point - change);
}

Label RegionLabels::at(const Point& point) const {
  if (on_face()) {
    const Point here = foot(point);
    return site_.face->map.at(here, foot(centre_) - here);
  }
  const auto& [stops, labels] = zone_.labels;
  std::size_t i = 0;
  for (; i < stops.size(); ++i) {
    const Number past_it = past(stops[i], point);
    if (past_it < 0 || (past_it == 0 && past(stops[i], centre_) < 0)) break;
  }
  return labels[i];
}

}  // namespace transect::skeleton::partial
