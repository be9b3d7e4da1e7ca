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

int exact_side(const Kernel::Plane_3& plane, const Point& p) {
  const Product one(Product(plane.a(), p.x()), Product(plane.b(), p.y()));
  const Product two(Product(plane.c(), p.z()), Product(plane.d(), 1));
  return CGAL::sign(Integer(one.above * two.below + two.above * one.below));
}

std::vector<int> signs(const std::vector<Point>& points, const Kernel::Plane_3& plane) {
  std::vector<int> result;
  result.reserve(points.size());
  for (const Point& point : points) result.push_back(side(plane, point));
  return result;
}

Number value(const Kernel::Plane_3& plane, const Point& p) {
  return plane.a() * p.x() + plane.b() * p.y() + plane.c() * p.z() + plane.d();
}

// Where the segment from a to b crosses the plane, which separates its ends.
Point crossing(const Kernel::Plane_3& plane, const Point& a, const Point& b) {
  const Number at_a = value(plane, a), at_b = value(plane, b);
  const Point point = a + (b - a) * (at_a / (at_a - at_b));
  CGAL::exact(point);  // keeps the tree of pending operations flat
  return point;
}

// The numerators over a common denominator, which comes last.
template <std::size_t N>
std::array<mpz_class, N + 1> common(const std::array<Number, N>& numbers) {
  std::array<mpz_class, N + 1> result;
  std::array<mpz_class, N> below;
  result[N] = 1;
  for (std::size_t i = 0; i < N; ++i) {
    Integer numerator, denominator;
    Parts::Decompose()(CGAL::exact(numbers[i]), numerator, denominator);
    result[i] = mpz_class(gmp(numerator));
    below[i] = mpz_class(gmp(denominator));
    result[N] = lcm(result[N], below[i]);
  }
  for (std::size_t i = 0; i < N; ++i) result[i] *= result[N] / below[i];
  return result;
}

Number ratio(const mpz_class& above, const mpz_class& below) {
  return Number(Parts::Compose()(Integer(above.get_mpz_t()), Integer(below.get_mpz_t())));
}

double rounded_ratio(const mpz_class& above, const mpz_class& below) {
  long a, b;
  const double numerator = mpz_get_d_2exp(&a, above.get_mpz_t());
  const double denominator = mpz_get_d_2exp(&b, below.get_mpz_t());
  return std::ldexp(numerator / denominator, static_cast<int>(a - b));
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
        kept.loop.push_back(cut(a, b, facet));
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
    if (moved_[old] == none) {
      moved_[old] = static_cast<Index>(part_.corners.size());
      part_.corners.push_back(whole_.corners[old]);
    }
    return moved_[old];
  }

  // An edge is met twice, from both of its facets.
  Index cut(Index a, Index b, const Facet& facet) {
    const auto [at, fresh] = cuts_.try_emplace(std::minmax(a, b));
    auto& [corner, first] = at->second;
    if (fresh) {
      corner = static_cast<Index>(part_.corners.size());
      first = facet.plane;
      part_.corners.emplace_back();
    } else {
      part_.corners[corner] =
          std::make_shared<Corner>(Halfspace::meeting(*first, *facet.plane, plane_));
    }
    return corner;
  }

  const Polytope& whole_;
  const Halfspace& plane_;
  std::vector<int> signs_;
  std::vector<Index> moved_;
  std::map<std::pair<Index, Index>, std::pair<Index, const Halfspace*>> cuts_;
  // The cap's edges are the facets' edges on the plane, the other way round.
  std::map<Index, Index> next_on_cap_;
  Polytope part_;
};

}  // namespace

Corner::Corner(mpz_class x, mpz_class y, mpz_class z, mpz_class w)
    : x_(std::move(x)), y_(std::move(y)), z_(std::move(z)), w_(std::move(w)) {
  if (w_ < 0) {
    for (mpz_class* number : {&x_, &y_, &z_, &w_}) *number = -*number;
  }
  rough_ = {rounded_ratio(x_, w_), rounded_ratio(y_, w_), rounded_ratio(z_, w_)};
}

Corner::Corner(const Point& point) : point_(point) {
  auto whole = common<3>({point.x(), point.y(), point.z()});
  x_ = std::move(whole[0]);
  y_ = std::move(whole[1]);
  z_ = std::move(whole[2]);
  w_ = std::move(whole[3]);
  rough_ = rough_place(point);  // exact by now
}

const Point& Corner::point() const {
  if (!point_) point_ = Point(ratio(x_, w_), ratio(y_, w_), ratio(z_, w_));
  return *point_;
}

WholeLinear::WholeLinear(const Vector& u, const Number& c) {
  auto all = common<4>({u.x(), u.y(), u.z(), c});
  for (int i = 0; i < 3; ++i) this->u[i] = std::move(all[i]);
  this->c = std::move(all[3]);
  below = std::move(all[4]);
}

Halfspace::Halfspace(const Kernel::Plane_3& plane)
    : plane_(plane),
      whole_(std::make_shared<Whole>(common<4>({plane.a(), plane.b(), plane.c(), plane.d()}))) {}

Halfspace::Halfspace(const WholeLinear& less, const WholeLinear& more)
    : whole_(std::make_shared<Whole>(
          std::array<mpz_class, 4>{less.u[0] * more.below - more.u[0] * less.below,
                                   less.u[1] * more.below - more.u[1] * less.below,
                                   less.u[2] * more.below - more.u[2] * less.below,
                                   more.c * less.below - less.c * more.below})) {}

Halfspace::Halfspace(const std::array<mpz_class, 4>& coefficients)
    : whole_(std::make_shared<Whole>(coefficients)) {}

const Kernel::Plane_3& Halfspace::plane() const {
  if (!plane_) {
    const auto& [a, b, c, d, rough] = *whole_;
    plane_ = Kernel::Plane_3(ratio(a, 1), ratio(b, 1), ratio(c, 1), ratio(d, 1));
  }
  return *plane_;
}

Halfspace::Whole::Whole(const std::array<mpz_class, 5>& all)
    : Whole(std::array<mpz_class, 4>{all[0], all[1], all[2], all[3]}) {}

Halfspace::Whole::Whole(const std::array<mpz_class, 4>& all) {
  mpz_class factor = gcd(gcd(all[0], all[1]), gcd(all[2], all[3]));
  if (factor == 0) factor = 1;  // all are 0 where distances are equal everywhere
  mpz_class* to[4] = {&a, &b, &c, &d};
  double mantissas[4];
  long exponents[4], largest = 0;
  for (int i = 0; i < 4; ++i) {
    *to[i] = all[i] / factor;
    mantissas[i] = mpz_get_d_2exp(&exponents[i], to[i]->get_mpz_t());
    if (i < 3) largest = std::max(largest, exponents[i]);
  }
  for (int i = 0; i < 4; ++i) {
    rough[i] = std::ldexp(mantissas[i], static_cast<int>(exponents[i] - largest));
  }
}

int Halfspace::side(const Corner& corner) const {
  const auto& [a, b, c, d, rough] = *whole_;
  const auto& [x, y, z] = corner.rough_;
  const double along[3] = {rough[0] * x, rough[1] * y, rough[2] * z};
  const double value = along[0] + along[1] + along[2] + rough[3];
  // Coefficients and coordinates are rounded by less than 2^-51, products and sums by 2^-53.
  const double error =
      4e-15 * (std::abs(along[0]) + std::abs(along[1]) + std::abs(along[2]) + std::abs(rough[3])) +
      1e-290;
  if (std::abs(value) > error) return value > 0 ? 1 : -1;
  return sgn(mpz_class(a * corner.x_ + b * corner.y_ + c * corner.z_ + d * corner.w_));
}

Corner Halfspace::meeting(const Halfspace& p, const Halfspace& q, const Halfspace& r) {
  const Whole &one = *p.whole_, &two = *q.whole_, &three = *r.whole_;
  const mpz_class x = two.b * three.c - two.c * three.b;
  const mpz_class y = two.c * three.a - two.a * three.c;
  const mpz_class z = two.a * three.b - two.b * three.a;
  // Two planes' normals and offsets by the third's.
  const mpz_class along_a = three.a * two.d - two.a * three.d;
  const mpz_class along_b = three.b * two.d - two.b * three.d;
  const mpz_class along_c = three.c * two.d - two.c * three.d;
  return {mpz_class(one.b * along_c - one.c * along_b - one.d * x),
          mpz_class(one.c * along_a - one.a * along_c - one.d * y),
          mpz_class(one.a * along_b - one.b * along_a - one.d * z),
          mpz_class(one.a * x + one.b * y + one.c * z)};
}

int side(const Kernel::Plane_3& plane, const Point& point) {
  Near sum = Near(plane.a()) * Near(point.x());
  sum = sum + Near(plane.b()) * Near(point.y());
  sum = sum + Near(plane.c()) * Near(point.z());
  sum = sum + Near(plane.d());
  if (std::abs(sum.value) > sum.error) return sum.value > 0 ? 1 : -1;
  return exact_side(plane, point);
}

bool clip(Polygon& polygon, const Kernel::Plane_3& plane) {
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

bool Outline::clip(const Halfspace& plane, const Halfspace& by) {
  std::vector<int> side;
  side.reserve(corners.size());
  for (const auto& corner : corners) side.push_back(by.side(*corner));
  const auto [low, high] = std::minmax_element(side.begin(), side.end());
  if (*low >= 0) return false;
  if (*high <= 0) return true;
  Outline kept;
  const auto add = [&](std::shared_ptr<const Corner> corner, const Halfspace& beyond) {
    kept.corners.push_back(std::move(corner));
    kept.sides.push_back(beyond);
  };
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const std::size_t j = (i + 1) % corners.size();
    if (side[i] < 0 || (side[i] == 0 && side[j] <= 0)) add(corners[i], sides[i]);
    if (side[i] == 0 && side[j] > 0) add(corners[i], by);
    if (side[i] * side[j] >= 0) continue;
    const auto crossing = std::make_shared<Corner>(Halfspace::meeting(plane, sides[i], by));
    add(crossing, side[i] < 0 ? by : sides[i]);
  }
  *this = std::move(kept);
  return true;
}

Polygon Outline::polygon() const {
  Polygon polygon;
  for (const auto& corner : corners) polygon.push_back(corner->point());
  return polygon;
}

CGAL::Bbox_3 Outline::box() const {
  CGAL::Bbox_3 box;
  for (const auto& corner : corners) {
    const auto& [x, y, z] = corner->rough();
    box += {x, y, z, x, y, z};
  }
  double size = 0;
  for (int i = 0; i < 3; ++i) size = std::max({size, std::abs(box.min(i)), std::abs(box.max(i))});
  const double slack = 1e-14 * size;
  return {box.xmin() - slack, box.ymin() - slack, box.zmin() - slack,
          box.xmax() + slack, box.ymax() + slack, box.zmax() + slack};
}

Polytope::Sides Polytope::sides(const Halfspace& plane) const {
  Sides sides{false, false};
  for (const auto& corner : corners) {
    const int sign = plane.side(*corner);
    sides.behind |= sign < 0;
    sides.front |= sign > 0;
    if (sides.behind && sides.front) break;
  }
  return sides;
}

bool Polytope::clip(const Halfspace& plane) {
  std::vector<int> side;
  side.reserve(corners.size());
  for (const auto& corner : corners) side.push_back(plane.side(*corner));
  const auto [low, high] = std::minmax_element(side.begin(), side.end());
  if (*low >= 0) return false;
  if (*high > 0) *this = Cut(*this, plane, std::move(side)).result();
  return true;
}

Polygon Polytope::polygon(const Facet& facet) const {
  Polygon polygon;
  for (Index corner : facet.loop) polygon.push_back(corners[corner]->point());
  return polygon;
}

std::vector<Outline> Polytope::outlines() const {
  std::map<std::pair<Index, Index>, const Halfspace*> left_of;
  const auto edges = [](const Facet& facet, auto use) {
    const std::size_t count = facet.loop.size();
    for (std::size_t i = 0; i < count; ++i) use(facet.loop[i], facet.loop[(i + 1) % count]);
  };
  for (const Facet& facet : facets) {
    edges(facet, [&](Index from, Index to) { left_of[{from, to}] = facet.plane; });
  }
  std::vector<Outline> outlines(facets.size());
  for (std::size_t i = 0; i < facets.size(); ++i) {
    edges(facets[i], [&](Index from, Index to) {
      outlines[i].corners.push_back(corners[from]);
      outlines[i].sides.push_back(*left_of.at({to, from}));
    });
  }
  return outlines;
}

std::vector<Place> Polytope::places() const {
  std::vector<Place> places;
  for (const auto& corner : corners) places.push_back(corner->rough());
  return places;
}

Polytope Polytope::apart() const {
  Polytope copy = *this;
  for (auto& corner : copy.corners) corner = std::make_shared<Corner>(*corner);
  return copy;
}

Point Polytope::centre() const {
  Vector sum = CGAL::NULL_VECTOR;
  for (const auto& corner : corners) sum += corner->point() - CGAL::ORIGIN;
  return CGAL::ORIGIN + sum / Number(static_cast<int>(corners.size()));
}

double Polytope::volume() const {
  const Place& o = corners[0]->rough();
  const auto from_first = [&](Index index) {
    const Place& p = corners[index]->rough();
    return Place{p[0] - o[0], p[1] - o[1], p[2] - o[2]};
  };
  double sum = 0;
  for (const Facet& facet : facets) {
    for (std::size_t i = 2; i < facet.loop.size(); ++i) {
      const Place a = from_first(facet.loop[0]), b = from_first(facet.loop[i - 1]),
                  c = from_first(facet.loop[i]);
      sum += a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
             a[2] * (b[0] * c[1] - b[1] * c[0]);
    }
  }
  return sum / 6;
}

CGAL::Bbox_3 bounds(const std::vector<Place>& places) {
  CGAL::Bbox_3 box;
  for (const Place& at : places) box += {at[0], at[1], at[2], at[0], at[1], at[2]};
  return box;
}

}  // namespace transect::skeleton::partial
