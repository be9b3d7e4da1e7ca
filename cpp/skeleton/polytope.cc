#include "transect/cpp/skeleton/polytope.h"

#include <CGAL/Fraction_traits.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace transect::skeleton::partial {
namespace {

// A double and more than its error, whatever way is rounded.
struct Near {
  double value, error;

  explicit Near(const Number& number) {
    const auto [low, high] = CGAL::to_interval(number);
    value = low;
    error = high - low;
  }
  Near(double value, double error) : value(value), error(error + 1e-15 * std::abs(value)) {}
  Near operator+(const Near& other) const {
    return {value + other.value, 1.000001 * (error + other.error)};
  }
  Near operator*(const Near& other) const {
    return {value * other.value, 1.000001 * (std::abs(value) * other.error +
                                             error * (std::abs(other.value) + other.error))};
  }
};

using Rational = Kernel::Exact_kernel::FT;
using Parts = CGAL::Fraction_traits<Rational>;
using Integer = Parts::Numerator_type;

// A product of two numbers as a fraction that need not be reduced.
struct Product {
  Integer above, below;

  Product(const Number& a, const Number& b) {
    Integer a_above, a_below, b_above, b_below;
    Parts::Decompose()(CGAL::exact(a), a_above, a_below);
    Parts::Decompose()(CGAL::exact(b), b_above, b_below);
    above = a_above * b_above;
    below = a_below * b_below;
  }
  Product(const Product& a, const Product& b)
      : above(a.above * b.below + b.above * a.below), below(a.below * b.below) {}
};

int exact_side(const Halfspace& plane, const Point& p) {
  const Product one(Product(plane.a(), p.x()), Product(plane.b(), p.y()));
  const Product two(Product(plane.c(), p.z()), Product(plane.d(), 1));
  return CGAL::sign(Integer(one.above * two.below + two.above * one.below));
}

std::vector<int> signs(const std::vector<Point>& points, const Halfspace& plane) {
  std::vector<int> result;
  result.reserve(points.size());
  for (const Point& point : points) result.push_back(side(plane, point));
  return result;
}

Number value(const Halfspace& plane, const Point& p) {
  return plane.a() * p.x() + plane.b() * p.y() + plane.c() * p.z() + plane.d();
}

// Cuts the facets of one polytope and closes the cut with a new facet.
class Cut {
 public:
  Cut(const Polytope& whole, const Halfspace& plane, std::vector<int> signs)
      : whole_(whole), plane_(plane), signs_(std::move(signs)), moved_(signs_.size(), none) {}

  Polytope result() {
    for (const Facet& facet : whole_.facets) add(facet);
    Facet cap{&plane_, {}};
    const Index first = next_on_cap_.begin()->first;
    for (Index at = first; cap.loop.empty() || at != first; at = next_on_cap_.at(at)) {
      cap.loop.push_back(at);
    }
    part_.facets.push_back(std::move(cap));
    return std::move(part_);
  }

 private:
  void add(const Facet& facet) {
    Facet kept{facet.plane, {}};
    std::vector<bool> on;
    const std::size_t count = facet.loop.size();
    for (std::size_t i = 0; i < count; ++i) {
      const Index a = facet.loop[i], b = facet.loop[(i + 1) % count];
      if (signs_[a] <= 0) {
        kept.loop.push_back(moved(a));
        on.push_back(signs_[a] == 0);
      }
      if (signs_[a] * signs_[b] < 0) {
        kept.loop.push_back(cut(a, b));
        on.push_back(true);
      }
    }
    if (kept.loop.size() < 3) return;
    for (std::size_t i = 0; i < on.size(); ++i) {
      const std::size_t j = (i + 1) % on.size();
      if (on[i] && on[j]) next_on_cap_[kept.loop[j]] = kept.loop[i];
    }
    part_.facets.push_back(std::move(kept));
  }

  Index moved(Index old) {
    if (moved_[old] == none) moved_[old] = keep(whole_.points[old]);
    return moved_[old];
  }

  Index cut(Index a, Index b) {
    const auto [at, fresh] = cuts_.try_emplace(std::minmax(a, b), none);
    if (fresh) at->second = keep(crossing(plane_, whole_.points[a], whole_.points[b]));
    return at->second;
  }

  Index keep(const Point& point) {
    part_.points.push_back(point);
    return static_cast<Index>(part_.points.size() - 1);
  }

  const Polytope& whole_;
  const Halfspace& plane_;
  std::vector<int> signs_;
  std::vector<Index> moved_;
  std::map<std::pair<Index, Index>, Index> cuts_;
  // The cap's edges are the facets' edges on the plane, the other way round.
  std::map<Index, Index> next_on_cap_;
  Polytope part_;
};

}  // namespace

int side(const Halfspace& plane, const Point& point) {
  Near sum = Near(plane.a()) * Near(point.x());
  sum = sum + Near(plane.b()) * Near(point.y());
  sum = sum + Near(plane.c()) * Near(point.z());
  sum = sum + Near(plane.d());
  if (std::abs(sum.value) > sum.error) return sum.value > 0 ? 1 : -1;
  return exact_side(plane, point);
}

Point crossing(const Halfspace& plane, const Point& a, const Point& b) {
  const Number at_a = value(plane, a), at_b = value(plane, b);
  const Point point = a + (b - a) * (at_a / (at_a - at_b));
  CGAL::exact(point);  // keeps the tree of pending operations flat
  return point;
}

bool clip(Polygon& polygon, const Halfspace& plane) {
  const std::vector<int> side = signs(polygon, plane);
  const auto behind = [](int sign) { return sign < 0; };
  const auto front = [](int sign) { return sign > 0; };
  if (std::none_of(side.begin(), side.end(), behind)) return false;
  if (std::none_of(side.begin(), side.end(), front)) return true;
  Polygon kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const std::size_t j = (i + 1) % polygon.size();
    if (side[i] <= 0) kept.push_back(polygon[i]);
    // A segment is a polygon of two corners, whose second edge is the first one again.
    if (polygon.size() == 2 && i == 1) break;
    if (side[i] * side[j] < 0) kept.push_back(crossing(plane, polygon[i], polygon[j]));
  }
  polygon = std::move(kept);
  return true;
}

Polytope::Sides Polytope::sides(const Halfspace& plane) const {
  Sides sides{false, false};
  for (const Point& point : points) {
    const int sign = side(plane, point);
    sides.behind |= sign < 0;
    sides.front |= sign > 0;
    if (sides.behind && sides.front) break;
  }
  return sides;
}

bool Polytope::clip(const Halfspace& plane) {
  std::vector<int> side = signs(points, plane);
  const auto [low, high] = std::minmax_element(side.begin(), side.end());
  if (*low >= 0) return false;
  if (*high > 0) *this = Cut(*this, plane, std::move(side)).result();
  return true;
}

Polygon Polytope::polygon(const Facet& facet) const {
  Polygon corners;
  for (Index corner : facet.loop) corners.push_back(points[corner]);
  return corners;
}

Point Polytope::centre() const {
  Vector sum = CGAL::NULL_VECTOR;
  for (const Point& point : points) sum += point - CGAL::ORIGIN;
  return CGAL::ORIGIN + sum / Number(static_cast<int>(points.size()));
}

}  // namespace transect::skeleton::partial
