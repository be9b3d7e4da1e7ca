// Points that belong to planes, and the side of every plane on which they lie.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "transect/cpp/skeleton/exact.h"

namespace transect::skeleton {

using Sides = std::vector<std::int8_t>;

class Points {
 public:
  explicit Points(const std::vector<Plane>& planes) : planes_(planes) {
    for (const Plane& plane : planes) {
      rough_.push_back({CGAL::to_double(plane.normal.x()), CGAL::to_double(plane.normal.y()),
                        CGAL::to_double(plane.normal.z()), CGAL::to_double(plane.offset)});
    }
  }

  std::size_t size() const { return points_.size(); }
  const Point& operator[](Index point) const { return points_[point]; }
  std::int8_t side(Index point, Index plane) const { return sides_[point][plane]; }
  const Sides& sides(Index point) const { return sides_[point]; }

  // `known` are planes that the point is on.
  Index add(const Point& point, const std::vector<Index>& known) {
    point.exact();  // shared by threads from now on, and the same for all of them
    Sides sides(planes_.size(), 2);
    for (Index plane : known) sides[plane] = 0;
    for (Index plane = 0; plane < planes_.size(); ++plane) {
      if (sides[plane] == 2) sides[plane] = side_of(point, plane);
    }
    points_.push_back(point);
    sides_.push_back(std::move(sides));
    return static_cast<Index>(points_.size() - 1);
  }

  // Which side of a plane any point is on.
  std::int8_t side_of(const Point& point, Index plane) const {
    point.exact();  // else coordinates may be off by more than rounding
    const auto& [a, b, c, d] = rough_[plane];
    const double x = a * CGAL::to_double(point.x()), y = b * CGAL::to_double(point.y()),
                 z = c * CGAL::to_double(point.z());
    const double value = x + y + z - d;
    // Products, sums and coordinates are each rounded by less than 2^-52.
    const double error = 4e-15 * (std::abs(x) + std::abs(y) + std::abs(z) + std::abs(d));
    if (std::abs(value) > error) return value > 0 ? 1 : -1;
    const Plane& exact = planes_[plane];
    return static_cast<std::int8_t>(
        CGAL::sign(exact.normal * (point - CGAL::ORIGIN) - exact.offset));
  }

 private:
  const std::vector<Plane>& planes_;
  std::vector<std::array<double, 4>> rough_;
  std::vector<Point> points_;
  std::vector<Sides> sides_;
};

// The two axes that are kept to see a plane as seen from where a normal points,
// counter-clockwise staying so; the axis in which it is largest is dropped.
struct View {
  int first, second, dropped;

  explicit View(const Vector& normal) {
    const double size[3] = {std::abs(CGAL::to_double(normal.x())),
                            std::abs(CGAL::to_double(normal.y())),
                            std::abs(CGAL::to_double(normal.z()))};
    dropped = size[0] >= size[1] && size[0] >= size[2] ? 0 : size[1] >= size[2] ? 1 : 2;
    first = (dropped + 1) % 3;
    second = (dropped + 2) % 3;
    if (CGAL::is_negative(normal[dropped])) std::swap(first, second);
  }

  Kernel::Point_2 operator()(const Point& point) const { return {point[first], point[second]}; }
};

}  // namespace transect::skeleton
