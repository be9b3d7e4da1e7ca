// What surfaces start from: the walls of a cell and the convex parts of what is known on
// the partial sections in it. Around a site, space is divided into *zones*, in each of
// which the distance is linear. A zone belongs to the face of the site (a prism), to one
// of its edges (a wedge) or to a corner:
//
//   every point of a zone is  p + α v + β w  (or p + a sum over the corners of a facet of
//   the gauge)  with p, its foot, on that face, edge or corner and v, w corners of the
//   gauge
//
// and has the label of its foot. So labels change across planes spanned by v, w, which
// continue from zone to zone (the paper's stretching), and the way to the foot has one
// label: nothing floats freely in a cell.
#pragma once

#include <array>
#include <memory>
#include <utility>

#include "transect/cpp/skeleton/gauge.h"
#include "transect/cpp/skeleton/partial.h"
#include "transect/cpp/skeleton/planar.h"
#include "transect/cpp/skeleton/polytope.h"

namespace transect::skeleton::partial {

// u·x − c
struct Linear {
  Vector u;
  Number c;

  Number at(const Point& x) const { return u * (x - CGAL::ORIGIN) - c; }
};

// Behind it, a is less than b.
inline Halfspace less(const Linear& a, const Linear& b) {
  const Vector u = a.u - b.u;
  return Halfspace(u.x(), u.y(), u.z(), b.c - a.c);
}

// The same in doubles, where they can decide.
struct Rough {
  double u[3], c;

  explicit Rough(const Linear& exact);
  // The value and more than the error of the value.
  std::pair<double, double> at(const std::array<double, 3>& x) const;
};

struct Zone {
  Linear distance;
  // The zone is behind all of them, within the cell.
  std::vector<Halfspace> bounds;
  // The face, a polygon, an edge, or a corner.
  std::vector<Point> foot;
  // v and w, along which the distance grows by one; both are v for a face or a corner.
  Vector rays[2];
  // The labels on an edge or at a corner.
  PlanarMap::Along labels;
};

// A piece of a contour between two labels.
struct Segment {
  Point from, to;
  Label left, right;
};

// A plane with labels on it.
struct Face {
  Index plane;
  std::vector<Segment> segments;
  PlanarMap map;
};

struct Site {
  std::shared_ptr<const Face> face;
  std::vector<Point> corners;  // counter-clockwise about the plane's normal
  Vector normal;
  std::vector<Zone> zones;  // one for a wall
};

// How many sites the patches make.
std::size_t count_sites(const PartialCell& cell);

// The cell as a polytope. The half-spaces must outlive it.
Polytope body(const PartialCell& cell, std::vector<Halfspace>& halfspaces);

Gauge gauge(const PartialCell& cell);

// Walls first.
std::vector<Site> sites(const PartialCell& cell, const Gauge& gauge);

}  // namespace transect::skeleton::partial
