// The words of the exact reconstruction (Barequet and Vaxman 2009), shared by
// its files. No CGAL type crosses to Rust: see skeleton.h.
//
//   plane      n·x = d with a rational scale s within 2^-bits of 1/|n|, so that
//              s (n·x − d) is a signed distance in rational numbers
//   piece      a straight part of a contour that no other plane cuts, with the
//              labels left and right of it as seen from where n points
//   cell       a convex part of the box that no full section cuts
#pragma once

#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <gmpxx.h>

#include <cstdint>
#include <vector>

namespace transect::skeleton {

using Kernel = CGAL::Exact_predicates_exact_constructions_kernel;
using Number = Kernel::FT;
using Point = Kernel::Point_3;
using Vector = Kernel::Vector_3;
using Index = std::uint32_t;
using Label = std::uint32_t;

constexpr Index none = static_cast<Index>(-1);
constexpr Label outside = 0;
constexpr Label unknown = static_cast<Label>(-1);

struct Plane {
  Vector normal;
  Number offset;
  Number scale;

  // Positive in front of the plane; its sign is exact whatever the scale.
  Number distance(const Point& point) const {
    return scale * (normal * (point - CGAL::ORIGIN) - offset);
  }
};

// From a point to a point, by their indices; seen with the plane's normal
// pointing at the viewer.
struct Piece {
  Index from, to;
  Label left, right;
};

// The kernel's integers are GMP's, by one name or another.
template <class T>
auto gmp(const T& integer) -> decltype(mpz_srcptr(integer.backend().data())) {
  return integer.backend().data();
}
template <class T>
auto gmp(const T& integer) -> decltype(mpz_srcptr(integer.mpz())) {
  return integer.mpz();
}

enum class Kind : std::uint8_t { roof, wall };

// Counter-clockwise as seen from the front; the labels differ.
struct Triangle {
  Index corners[3];
  Label back, front;
  Kind kind;
  // The planes whose sections meet in a roof, or twice the plane of a wall.
  Index planes[2];
};

}  // namespace transect::skeleton
