// The gauge: a convex polytope around the origin that stands in for the ball, so
// that distances are rational and piecewise linear.
//
//   corners   s n and −s n for every plane of the cell, and directions that fill
//             the gaps between them, all of about unit length. Each s n is the one
//             corner that is farthest along n: what is nearest to a plane is its
//             foot along n.
//   facets    by their polar points u: u·x = 1 on the facet, u·x < 1 inside
//
// The distance from a convex set P to x is the largest of u·x − max over P of u·p,
// over the facets' u and those of P grown by the gauge (see sites.h).
#pragma once

#include "transect/cpp/skeleton/exact.h"

namespace transect::skeleton::partial {

struct Gauge {
  struct Facet {
    Vector polar;
    std::vector<Index> corners;
  };
  struct Edge {
    Index corners[2];
    Index facets[2];
  };
  std::vector<Vector> corners;
  std::vector<Facet> facets;
  std::vector<Edge> edges;

  // Throws std::domain_error if planes are too close to parallel for their scales.
  explicit Gauge(const std::vector<Plane>& planes);

  // Whether planes, in any cell, are far enough from parallel for their scales.
  static bool scales_suffice(const std::vector<Plane>& planes);

  // The corner that is farthest along the normal of one of the planes.
  const Vector& farthest(const Vector& normal) const;
};

}  // namespace transect::skeleton::partial
