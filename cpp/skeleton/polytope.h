// Convex polygons and polytopes, clipped by planes. All of it is exact.
#pragma once

#include "transect/cpp/skeleton/exact.h"

namespace transect::skeleton::partial {

using Halfspace = Kernel::Plane_3;  // what is on the negative side, or on the plane
using Polygon = std::vector<Point>;

// Negative behind the plane, 0 on it. Exact as the kernel's own, but without reducing
// fractions, since corners of polytopes are on planes all the time.
int side(const Halfspace& plane, const Point& point);

// Where the segment from a to b crosses the plane, which separates its ends.
Point crossing(const Halfspace& plane, const Point& a, const Point& b);

// Clips a polygon or a segment; false if nothing but a part of the border is left.
bool clip(Polygon& polygon, const Halfspace& plane);

struct Facet {
  const Halfspace* plane;   // the polytope is behind it
  std::vector<Index> loop;  // counter-clockwise, seen from outside
};

struct Polytope {
  std::vector<Point> points;
  std::vector<Facet> facets;

  struct Sides {
    bool behind, front;  // whether a corner is strictly behind, in front
  };
  Sides sides(const Halfspace& plane) const;
  // False if nothing is left. The plane must outlive the polytope.
  bool clip(const Halfspace& plane);
  Polygon polygon(const Facet& facet) const;
  Point centre() const;
};

}  // namespace transect::skeleton::partial
