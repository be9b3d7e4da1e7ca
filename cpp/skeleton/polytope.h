// Convex polygons and polytopes, clipped by planes. All of it is exact.
//
// A partition makes many polytopes and throws most of them away. Their corners are where
// three planes meet, by whole numbers with a common denominator: nothing is reduced, and
// nothing grows from cut to cut.
#pragma once

#include <gmpxx.h>

#include <array>
#include <memory>
#include <optional>

#include "transect/cpp/skeleton/exact.h"

namespace transect::skeleton::partial {

using Place = std::array<double, 3>;
using Polygon = std::vector<Point>;

// What is not exact yet may be off by a hundred-thousandth.
inline Place rough_place(const Point& point) {
  CGAL::exact(point);
  return {CGAL::to_double(point.x()), CGAL::to_double(point.y()), CGAL::to_double(point.z())};
}

// (x/w, y/w, z/w), w > 0.
class Corner {
 public:
  Corner(mpz_class x, mpz_class y, mpz_class z, mpz_class w);
  explicit Corner(const Point& point);

  const Place& rough() const { return rough_; }  // rounded
  const Point& point() const;

 private:
  friend class Halfspace;
  mpz_class x_, y_, z_, w_;
  Place rough_;
  mutable std::optional<Point> point_;
};

// u·x − c in whole numbers over a common denominator.
struct WholeLinear {
  mpz_class u[3], c, below;

  WholeLinear(const Vector& u, const Number& c);
};

// What is on the negative side of a plane, or on it.
class Halfspace {
 public:
  Halfspace(const Kernel::Plane_3& plane);
  // Where one is less than the other. Not for several threads at once.
  Halfspace(const WholeLinear& less, const WholeLinear& more);
  // Of a x + b y + c z + d.
  explicit Halfspace(const std::array<mpz_class, 4>& coefficients);

  const Kernel::Plane_3& plane() const;
  // Of a x + b y + c z + d, in whole numbers without a common factor.
  std::array<const mpz_class*, 4> coefficients() const {
    return {&whole_->a, &whole_->b, &whole_->c, &whole_->d};
  }
  // Negative behind the plane, 0 on it.
  int side(const Corner& corner) const;
  // Where three planes meet that meet in one point.
  static Corner meeting(const Halfspace& p, const Halfspace& q, const Halfspace& r);

 private:
  // a x + b y + c z + d in whole numbers, and rounded by a common factor.
  struct Whole {
    mpz_class a, b, c, d;
    double rough[4];

    explicit Whole(const std::array<mpz_class, 4>& all);
    explicit Whole(const std::array<mpz_class, 5>& all);  // over the last one
  };

  mutable std::optional<Kernel::Plane_3> plane_;  // when asked for
  std::shared_ptr<const Whole> whole_;
};

// Exact as the kernel's own, but without reducing fractions, since corners of polygons are
// on planes all the time.
int side(const Kernel::Plane_3& plane, const Point& point);

// Clips a polygon or a segment; false if nothing but a part of the border is left.
bool clip(Polygon& polygon, const Kernel::Plane_3& plane);

// A convex polygon in a plane.
struct Outline {
  std::vector<std::shared_ptr<const Corner>> corners;
  // Each by the edge from a corner to the next; the polygon is behind all of them.
  std::vector<Halfspace> sides;

  // False if nothing but a part of the border is left.
  bool clip(const Halfspace& plane, const Halfspace& by);
  Polygon polygon() const;
  // Around it, and more than rounding errors.
  CGAL::Bbox_3 box() const;
};

struct Facet {
  const Halfspace* plane;   // the polytope is behind it
  std::vector<Index> loop;  // counter-clockwise, seen from outside
};

struct Polytope {
  std::vector<std::shared_ptr<const Corner>> corners;
  std::vector<Facet> facets;

  struct Sides {
    bool behind, front;  // whether a corner is strictly behind, in front
  };
  Sides sides(const Halfspace& plane) const;
  // False if nothing is left. The plane must outlive the polytope.
  bool clip(const Halfspace& plane);
  Polygon polygon(const Facet& facet) const;
  // Of every facet.
  std::vector<Outline> outlines() const;
  std::vector<Place> places() const;
  // With corners of its own, for another thread.
  Polytope apart() const;
  Point centre() const;
  double volume() const;  // rounded
};

CGAL::Bbox_3 bounds(const std::vector<Place>& places);

}  // namespace transect::skeleton::partial
