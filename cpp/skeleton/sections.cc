#include "transect/cpp/skeleton/sections.h"

#include <CGAL/Fraction_traits.h>

#include <algorithm>

#include "transect/cpp/above.h"

namespace transect::skeleton {
namespace {

using Rational = Kernel::Exact_kernel::FT;
using Fraction = CGAL::Fraction_traits<Rational>;
using Integer = Fraction::Numerator_type;

Rational power_of_two(int exponent) {
  Rational power(1);
  const Rational step = exponent < 0 ? Rational(Rational(1) / Rational(2)) : Rational(2);
  for (int i = std::abs(exponent); i > 0; --i) power *= step;
  return power;
}

// The multiple of a power of two at or below a positive number.
Rational truncated(const Rational& number, int exponent) {
  const Rational unit = power_of_two(exponent);
  Fraction::Numerator_type above;
  Fraction::Denominator_type below;
  Fraction::Decompose()(Rational(number / unit), above, below);
  return Rational(Rational(CGAL::div(above, Integer(below))) * unit);
}

// Where a piece crosses a plane, and how far along.
struct Cut {
  Number along;
  Index point;
};

std::vector<Cut> cuts_of(Scene& scene, Index own, const Piece& piece) {
  std::vector<Cut> cuts;
  for (Index plane = 0; plane < scene.sections.size(); ++plane) {
    if (scene.points.side(piece.from, plane) * scene.points.side(piece.to, plane) >= 0) continue;
    const Plane& other = scene.planes[plane];
    const Point from = scene.points[piece.from], to = scene.points[piece.to];
    const Number at_from = other.normal * (from - CGAL::ORIGIN) - other.offset;
    const Number along = at_from / (other.normal * (from - to));
    const auto same = std::find_if(cuts.begin(), cuts.end(), [&](const Cut& cut) {
      return scene.points.side(cut.point, plane) == 0;
    });
    if (same != cuts.end()) continue;  // a third plane through the same point
    cuts.push_back({along, scene.points.add(from + along * (to - from), {own, plane})});
  }
  std::sort(cuts.begin(), cuts.end(),
            [](const Cut& one, const Cut& other) { return one.along < other.along; });
  return cuts;
}

}  // namespace

Number scale_of(const Vector& normal, unsigned bits) {
  const Rational squared = normal.squared_length().exact();
  // Powers of two keep the start within the range of doubles.
  double largest = 0;
  for (int axis = 0; axis < 3; ++axis) {
    largest = std::max(largest, std::abs(CGAL::to_double(normal[axis])));
  }
  int exponent;
  std::frexp(largest, &exponent);
  const Rational unit = power_of_two(-exponent);
  const double start = 1 / std::sqrt(CGAL::to_double(Rational(squared * Rational(unit * unit))));
  Rational scale = Rational(Rational(start) * unit);
  if (Rational(squared * Rational(scale * scale)) == Rational(1)) return Number(scale);
  // Newton's iteration for 1/√q doubles the number of good bits.
  for (unsigned good = 50; good < bits + 4; good *= 2) {
    const Rational rest = Rational(Rational(3) - Rational(squared * Rational(scale * scale)));
    scale = truncated(Rational(Rational(scale * rest) / Rational(2)),
                      -exponent - static_cast<int>(2 * good) - 2);
  }
  return Number(truncated(scale, -exponent - static_cast<int>(bits) - 2));
}

void cut_pieces(Scene& scene) {
  for (Index plane = 0; plane < scene.sections.size(); ++plane) {
    std::vector<Piece> pieces;
    for (const Piece& piece : scene.sections[plane].pieces) {
      Index from = piece.from;
      for (const Cut& cut : cuts_of(scene, plane, piece)) {
        pieces.push_back({from, cut.point, piece.left, piece.right});
        from = cut.point;
      }
      pieces.push_back({from, piece.to, piece.left, piece.right});
    }
    scene.sections[plane].pieces = std::move(pieces);
  }
}

Label label_at(const Scene& scene, Index section, const Point& point) {
  const View view(scene.planes[section].normal);
  const auto start = view(point);
  const CGAL::Bbox_2 box = start.bbox();
  Above above(start, scene.sections[section].background);
  for (const Piece& piece : scene.sections[section].pieces) {
    const Point &from = scene.points[piece.from], &to = scene.points[piece.to];
    const CGAL::Bbox_3 ends = from.bbox() + to.bbox();
    if (ends.max(view.first) < box.xmin() || ends.min(view.first) > box.xmax()) continue;
    if (ends.max(view.second) < box.ymin()) continue;
    above.pass(view(from), view(to), piece.left, piece.right);
  }
  return above.label();
}

}  // namespace transect::skeleton
