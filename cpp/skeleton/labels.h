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
  RegionLabels(const Region& region, const Site& site);

  const std::vector<Change>& changes() const { return changes_; }
  // On the border of the region, as seen from inside; labels must not change there.
  Label at(const Point& point) const;
  Index plane() const { return site_.face->plane; }

 private:
  bool on_face() const { return zone_.foot.size() > 2; }
  Point foot(const Point& point) const;
  void across_face(const Region& region);
  void across_edge(const Region& region);
  void add(const Region& region, Change change);
  Number past(const Point& change, const Point& point) const;

  const Site& site_;
  const Zone& zone_;
  Point centre_;
  Number height_;  // the distance is not larger than that
  Vector across_;  // of an edge: towards later labels, along which they change
  std::vector<Change> changes_;
};

}  // namespace transect::skeleton::partial
