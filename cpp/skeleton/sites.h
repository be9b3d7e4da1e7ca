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
#include <optional>
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

// The same in doubles, where they can decide.
struct Rough {
  double u[3], c;

  explicit Rough(const Linear& exact);
  // The value and more than the error of the value.
  std::pair<double, double> at(const Place& x) const;
};

struct Zone {
  Linear distance;
  // The face, a polygon, an edge, or a corner.
  std::vector<Point> foot;
  // v and w, along which the distance grows by one; both are v for a face or a corner.
  Vector rays[2];
  // The labels on an edge or at a corner.
  PlanarMap::Along labels;
  // Beyond the edge, or farther from the corner, another site is as near: nothing is nearest
  // to this zone.
  bool is_inner = false;
};

// A piece of a contour between two labels.
struct Segment {
  Point from, to;
  Label left, right;
};

// The labels of a part of space, as far as doubles can tell.
struct Shown {
  bool is_mixed = false;  // possibly more than one
  std::optional<Label> only;

  void add(Label label) {
    is_mixed = is_mixed || (only && *only != label);
    only = label;
  }
};

// A plane with labels on it.
struct Face {
  Index plane;
  std::vector<Segment> segments;
  std::vector<CGAL::Bbox_3> boxes;  // of the segments
  PlanarMap map;

  // What a convex polygon in the plane may show in a box.
  Shown within(const CGAL::Bbox_3& box, const std::vector<Point>& polygon) const;
};

struct Site {
  std::shared_ptr<const Face> face;
  std::vector<Point> corners;  // counter-clockwise about the plane's normal
  Vector normal;
  std::vector<Zone> zones;  // one for a wall, one for each side of a plane
  // Of a plane, where what is known on it ends.
  std::vector<std::array<Place, 2>> outline;

  bool is_wall() const { return zones.size() == 1; }
  // All of a patch's plane in the cell: it stands in for the patch's sites, which follow it,
  // where all feet on it are known. There the nearest of them is as far as the plane.
  bool is_plane() const { return zones.size() == 2; }
};

// What a zone may show between some places.
Shown shown(const Site& site, const Zone& zone, const Rough& distance,
            const std::vector<Place>& places);

// Whether all feet on a plane from between some places are known, as far as doubles can tell.
bool knows_all(const Site& plane, const Rough& distance, const std::vector<Place>& places);

// The cell as a polytope. The half-spaces must outlive it.
Polytope body(const PartialCell& cell, std::vector<Halfspace>& halfspaces);

Gauge gauge(const PartialCell& cell);

// Walls first, then patch by patch its plane and its sites.
std::vector<Site> sites(const PartialCell& cell, const Gauge& gauge);

}  // namespace transect::skeleton::partial
