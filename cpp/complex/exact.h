// The words of the cell complex, shared by its files. No CGAL type crosses to Rust: see
// complex.h in the folder above.
//
//   place      an exact point that something ends in, with all planes it is known to be on
//   facet      a convex polygon on one plane that no other plane cuts
//   cell       a convex part of the box that no plane cuts
//   piece      what lies of an edge of a section in one facet
//   mark       a place on a facet's border, not a corner of it, where pieces on its plane
//              end, on either side of the border
#pragma once

#include <CGAL/Exact_predicates_exact_constructions_kernel.h>

#include <array>
#include <cstdint>
#include <vector>

namespace transect::complex {

using Kernel = CGAL::Exact_predicates_exact_constructions_kernel;
using Number = Kernel::FT;
using Point = Kernel::Point_3;
using Point2 = Kernel::Point_2;
using Vector = Kernel::Vector_3;
using Id = std::uint32_t;
using Label = std::uint32_t;

constexpr Id none = static_cast<Id>(-1);

struct Plane {
  std::array<double, 3> rough_normal{};
  double rough_offset = 0;
  Vector normal;
  Number offset;
  // The two axes that are kept to see the plane from where its normal points,
  // counter-clockwise staying so, and the one that is dropped.
  std::array<int, 3> axes{};

  Plane() = default;
  Plane(const std::array<double, 3>& normal, double offset);

  Point2 seen(const Point& point) const { return {point[axes[0]], point[axes[1]]}; }
  // Positive in front of the plane.
  Number value(const Point& point) const { return normal * (point - CGAL::ORIGIN) - offset; }
};

struct Place {
  Point exact;
  std::array<double, 3> rough{};
  double error = 0;        // of each coordinate
  std::vector<Id> planes;  // ascending

  Place() = default;
  // Coordinates are rounded to 1e-14 of `size` or better.
  Place(Point point, std::vector<Id> planes, double size);

  bool is_on(Id plane) const;
};

// On which side of a plane a place lies (−1, 0, 1), from its coordinates alone.
int side_of(const Place& place, const Plane& plane);

// The planes in both ascending lists.
std::vector<Id> common(const std::vector<Id>& one, const std::vector<Id>& other);
std::size_t count_common(const std::vector<Id>& one, const std::vector<Id>& other);

// Whether two planes at least go through both.
inline bool share_line(const Place& one, const Place& other) {
  return count_common(one.planes, other.planes) > 1;
}

}  // namespace transect::complex
