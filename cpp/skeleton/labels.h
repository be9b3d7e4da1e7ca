// The labels in a region: those of the feet on its owner.
#pragma once

#include "transect/cpp/skeleton/territory.h"

namespace transect::skeleton::partial {

// Where labels change within a region: a convex polygon, counter-clockwise as seen from
// the front.
struct Change {
  Polygon polygon;
  Label back, front;
};

class RegionLabels {
 public:
  RegionLabels(const Region& region, const Distances& distances);
  // Of a region with one label, whoever owns it; the plane is said of its surfaces.
  RegionLabels(Label label, Index plane) : plane_(plane), only_(label) {}

  const std::vector<Change>& changes() const { return changes_; }
  // The label everywhere, where it does not change.
  const std::optional<Label>& only() const { return only_; }
  // The planes of facets along which labels change.
  const std::vector<const Halfspace*>& changes_along() const { return changes_along_; }
  // Where labels change on a facet in a plane.
  std::vector<Polygon> lines_on(const Halfspace& plane) const;
  // On the border of the region, as seen from inside; labels must not change there.
  Label at(const Point& point) const;
  // To be asked for labels alone, although the region is gone.
  void leave_region();
  Index plane() const { return plane_; }

 private:
  bool on_face() const { return zone_->foot.size() > 2; }
  Point foot(const Point& point) const;
  const Point& centre() const;
  void across_face();
  void across_edge();
  void add(Change change);
  Number past(const Point& change, const Point& point) const;

  Index plane_;
  std::optional<Label> only_;
  // None where a label was given.
  const Site* site_ = nullptr;
  const Zone* zone_ = nullptr;
  const Polytope* body_ = nullptr;
  mutable std::optional<Point> centre_;
  Number height_;  // the distance is not larger than that
  Vector across_;  // of an edge: towards later labels, along which they change
  std::vector<Change> changes_;
  std::vector<const Halfspace*> changes_along_;
};

}  // namespace transect::skeleton::partial
