// Surfaces, gathered by their planes: what lies in one plane is merged, and every edge is
// split at all points of the cell's surfaces that lie on it. So triangles fit together
// although each plane is triangulated on its own.
#pragma once

#include <gmpxx.h>

#include <array>
#include <functional>
#include <map>
#include <optional>

#include "transect/cpp/skeleton/partial.h"
#include "transect/cpp/skeleton/planar.h"
#include "transect/cpp/skeleton/polytope.h"

namespace transect::skeleton::partial {

// What the two sides of a surface are; the front is where the normal points.
struct Sides {
  Label back, front;
  Kind kind;
  Index planes[2];

  Sides flipped() const { return {front, back, kind, {planes[1], planes[0]}}; }
  bool operator==(const Sides& other) const;
};

// The coefficients of a plane in whole numbers without a common factor, the first that is
// not 0 positive.
using PlaneKey = std::array<mpz_class, 4>;

struct PlaneName {
  PlaneKey key;
  bool flipped;  // whether the key's normal is opposite
};
PlaneName plane_name(const Halfspace& plane);

// A convex part of a plane, and the lines on it where sides change.
struct Tile {
  Polygon polygon;
  std::vector<Polygon> lines;
  std::function<Sides(const Point&)> sides;  // at a point on no line
};

// Between two points, with what is to its left and right; nothing or two sides that differ.
struct Seam {
  Point from, to;
  std::optional<Sides> left, right;
};

// The tiles' outlines, as far as something begins, ends or changes there. Tiles must not
// overlap.
std::vector<Seam> seams(const Kernel::Plane_3& plane, const std::vector<Tile>& tiles);

// All points by their coordinates.
class PointNames {
 public:
  explicit PointNames(const std::vector<Point>& points);

  Index name(const Point& point);
  // Of a point that has one.
  Index at(const Point& point) const { return names_.at(point); }
  const std::vector<Point>& points() const { return points_; }

 private:
  std::map<Point, Index> names_;
  std::vector<Point> points_;
};

// To find points on a segment.
class PointIndex {
 public:
  explicit PointIndex(const std::vector<Point>& points);

  // In order, without the ends.
  std::vector<Point> between(const Point& from, const Point& to) const;

 private:
  struct Entry {
    double low, high;
    Index point;
  };
  const std::vector<Point>& points_;
  std::vector<Entry> sorted_[3];  // along each axis
  double width_[3];               // of the widest entry
};

std::vector<Triangle> triangulate(const Kernel::Plane_3& plane, const std::vector<Seam>& seams,
                                  const PointIndex& index, const PointNames& names);

}  // namespace transect::skeleton::partial
