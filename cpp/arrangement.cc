#include "transect/cpp/arrangement.h"

#include <CGAL/Arr_consolidated_curve_data_traits_2.h>
#include <CGAL/Arr_extended_dcel.h>
#include <CGAL/Arr_segment_traits_2.h>
#include <CGAL/Arrangement_2.h>
#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <CGAL/Interval_nt.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "transect/src/ffi/arrangement.rs.h"

namespace transect::arrangement {
namespace {

using Kernel = CGAL::Exact_predicates_exact_constructions_kernel;
using Rational = Kernel::Exact_kernel::FT;
using Interval = CGAL::Interval_nt<false>;
using Traits =
    CGAL::Arr_consolidated_curve_data_traits_2<CGAL::Arr_segment_traits_2<Kernel>, std::uint32_t>;
using Dcel = CGAL::Arr_extended_dcel<Traits, std::uint32_t, std::uint32_t, std::uint32_t>;
using Arrangement = CGAL::Arrangement_2<Traits, Dcel>;
using Curve = Traits::X_monotone_curve_2;
using BaseCurve = Traits::Base_x_monotone_curve_2;

// A point on the plane, by its two kept coordinates.
struct Exact {
  Rational u, v;
};

Kernel::Point_2 lazy(const Exact& point) { return {Kernel::FT(point.u), Kernel::FT(point.v)}; }

// n . x - o of another plane, as a function of the two kept coordinates on
// this one, times a positive number: its sign is the side on which a point of
// this plane lies.
struct SideFunction {
  Rational a, b, c;
  Interval around_a, around_b, around_c;

  SideFunction(const Rational& a, const Rational& b, const Rational& c)
      : a(a),
        b(b),
        c(c),
        around_a(CGAL::to_interval(a)),
        around_b(CGAL::to_interval(b)),
        around_c(CGAL::to_interval(c)) {}

  Rational at(const Exact& point) const {
    Rational value = a * point.u;
    value += b * point.v;
    value += c;
    return value;
  }

  // Needs an Interval::Protector.
  Interval around(const Interval& u, const Interval& v) const {
    return around_a * u + around_b * v + around_c;
  }
};

// Planes as four numbers each, normal and offset.
struct Planes {
  rust::Slice<const double> numbers;

  std::size_t count() const { return numbers.size() / 4; }
  double operator()(std::size_t plane, std::size_t which) const {
    return numbers[4 * plane + which];
  }
  Rational product(std::size_t p, std::size_t i, std::size_t q, std::size_t j) const {
    return Rational(Rational((*this)(p, i)) * Rational((*this)(q, j)));
  }
  // The minor of coordinates i and j of the two planes' quadruples.
  Rational minor(std::size_t p, std::size_t q, std::size_t i, std::size_t j) const {
    return Rational(product(p, i, q, j) - product(p, j, q, i));
  }
  bool coincide(std::size_t p, std::size_t q) const {
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = i + 1; j < 4; ++j) {
        if (surely_not_zero(p, q, i, j)) return false;
        if (CGAL::sign(minor(p, q, i, j)) != CGAL::ZERO) return false;
      }
    }
    return true;
  }

 private:
  // Whether doubles suffice to tell that the minor is not zero.
  bool surely_not_zero(std::size_t p, std::size_t q, std::size_t i, std::size_t j) const {
    const double left = (*this)(p, i) * (*this)(q, j), right = (*this)(p, j) * (*this)(q, i);
    return std::abs(left - right) > 1e-14 * (std::abs(left) + std::abs(right));
  }
};

void require_finite(rust::Slice<const double> numbers) {
  for (double number : numbers) {
    if (!std::isfinite(number)) throw std::invalid_argument("a coordinate is not a finite number");
  }
}

// A corner of the box's outline on the plane, and the box plane that the side
// from it to the next corner lies on.
struct OutlineCorner {
  Exact point;
  std::uint32_t side;
};
using Outline = std::vector<OutlineCorner>;

// Where the segment crosses the line on which the values at its ends vanish.
Exact crossing(const Exact& from, const Exact& to, const Rational& at_from, const Rational& at_to) {
  const Rational t = at_from / Rational(at_from - at_to);
  return {Rational(from.u + Rational(t * Rational(to.u - from.u))),
          Rational(from.v + Rational(t * Rational(to.v - from.v)))};
}

// The part of the outline where the side function is not positive. Parts
// without area (a corner or a side) vanish.
Outline clipped(const Outline& outline, const SideFunction& side, std::uint32_t plane) {
  Outline kept;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const OutlineCorner& here = outline[i];
    const OutlineCorner& next = outline[(i + 1) % outline.size()];
    const Rational at_here = side.at(here.point), at_next = side.at(next.point);
    const int sign = CGAL::sign(at_here), sign_next = CGAL::sign(at_next);
    if (sign <= 0 && sign_next <= 0) kept.push_back(here);
    if (sign < 0 && sign_next > 0) kept.push_back(here);
    if (sign == 0 && sign_next > 0) kept.push_back({here.point, plane});
    if (sign * sign_next < 0) {
      const Exact point = crossing(here.point, next.point, at_here, at_next);
      kept.push_back({point, sign < 0 ? plane : here.side});
    }
  }
  if (kept.size() < 3) kept.clear();
  return kept;
}

// What is done to one plane.
class Plane {
 public:
  Plane(Planes planes, rust::Slice<const std::uint32_t> distinct, std::uint32_t own,
        rust::Slice<const std::uint32_t> axes)
      : planes_(planes), distinct_(distinct), own_(own), axes_{axes[0], axes[1], axes[2]} {
    sides_.reserve(planes.count());
    for (std::size_t other = 0; other < planes.count(); ++other) {
      sides_.push_back(side_function(other));
    }
  }

  void add_outline(rust::Slice<const double> bounds) {
    outline_ = rectangle(bounds);
    for (std::uint32_t end = 0; end < 2; ++end) {
      const std::uint32_t plane = box_plane(axes_[2], end);
      outline_ = clipped(outline_, sides_[plane], plane);
    }
    for (std::size_t i = 0; i < outline_.size(); ++i) {
      const OutlineCorner& next = outline_[(i + 1) % outline_.size()];
      add_line(outline_[i].side, outline_[i].point, next.point);
    }
  }

  bool misses_the_box() const { return outline_.empty(); }

  // The lines cut by the other sections' planes, where they cross the outline.
  void add_lines() {
    for (std::uint32_t other : distinct_) {
      if (other == own_ || is_box(other)) continue;
      const std::vector<Exact> ends = chord(sides_[other]);
      if (ends.size() == 2) add_line(other, ends[0], ends[1]);
    }
  }

  void add_edges(rust::Slice<const double> vertices, rust::Slice<const std::uint32_t> edges) {
    std::vector<Kernel::Point_2> points;
    points.reserve(vertices.size() / 2);
    for (std::size_t i = 0; i + 1 < vertices.size(); i += 2) {
      points.emplace_back(vertices[i], vertices[i + 1]);
    }
    for (std::size_t i = 0; i + 1 < edges.size(); i += 2) {
      const std::uint32_t name = static_cast<std::uint32_t>(planes_.count() + i / 2);
      curves_.emplace_back(BaseCurve(points.at(edges[i]), points.at(edges[i + 1])), name);
    }
  }

  Subdivision subdivide() {
    CGAL::insert(arrangement_, curves_.begin(), curves_.end());
    Subdivision out;
    number_faces(out);
    write_vertices(out);
    write_edges(out);
    write_corners(out);
    return out;
  }

 private:
  std::uint32_t box_plane(std::uint32_t axis, std::uint32_t end) const {
    return static_cast<std::uint32_t>(planes_.count()) - 6 + 2 * axis + end;
  }
  bool is_box(std::uint32_t plane) const { return plane + 6 >= planes_.count(); }

  // With x_d = (o_i - n_i,u u - n_i,v v) / n_i,d put into n_j . x - o_j, times
  // |n_i,d|.
  SideFunction side_function(std::size_t other) const {
    const auto [u, v, d] = axes_;
    const std::size_t p = planes_(own_, d) > 0 ? own_ : other;  // swapped, minors change sign
    const std::size_t q = planes_(own_, d) > 0 ? other : own_;
    return {planes_.minor(p, q, d, u), planes_.minor(p, q, d, v), planes_.minor(p, q, 3, d)};
  }

  // The box in the kept coordinates, counter-clockwise in (u, v).
  Outline rectangle(rust::Slice<const double> bounds) const {
    const auto [u, v, d] = axes_;
    const Rational u0(bounds[2 * u]), u1(bounds[2 * u + 1]);
    const Rational v0(bounds[2 * v]), v1(bounds[2 * v + 1]);
    return {{{u0, v0}, box_plane(v, 0)},
            {{u1, v0}, box_plane(u, 1)},
            {{u1, v1}, box_plane(v, 1)},
            {{u0, v1}, box_plane(u, 0)}};
  }

  void add_line(std::uint32_t plane, const Exact& from, const Exact& to) {
    const SideFunction& side = sides_[plane];
    const Kernel::Line_2 line(Kernel::FT(side.a), Kernel::FT(side.b), Kernel::FT(side.c));
    curves_.emplace_back(BaseCurve(line, lazy(from), lazy(to)), plane);
  }

  // The points where a line meets the outline: none, one, or two.
  std::vector<Exact> chord(const SideFunction& line) const {
    std::vector<Rational> values;
    for (const OutlineCorner& corner : outline_) values.push_back(line.at(corner.point));
    std::vector<Exact> points;
    for (std::size_t i = 0; i < outline_.size(); ++i) {
      const std::size_t next = (i + 1) % outline_.size();
      const int sign = CGAL::sign(values[i]), sign_next = CGAL::sign(values[next]);
      if (sign == 0) points.push_back(outline_[i].point);
      if (sign * sign_next < 0) {
        points.push_back(
            crossing(outline_[i].point, outline_[next].point, values[i], values[next]));
      }
    }
    return points;
  }

  void number_faces(Subdivision& out) {
    arrangement_.unbounded_face()->set_data(0);
    std::uint32_t number = 1;
    for (auto face = arrangement_.faces_begin(); face != arrangement_.faces_end(); ++face) {
      if (!face->is_unbounded()) face->set_data(number++);
    }
    out.faces = number;
  }

  // Rounds exact coordinates: the same point has the same doubles whatever
  // else is in the arrangement.
  void write_vertices(Subdivision& out) {
    out.points.reserve(2 * arrangement_.number_of_vertices());
    std::uint32_t number = 0;
    for (auto vertex = arrangement_.vertices_begin(); vertex != arrangement_.vertices_end();
         ++vertex) {
      vertex->set_data(number++);
      const auto& point = CGAL::exact(vertex->point());
      out.points.push_back(CGAL::to_double(point.x()));
      out.points.push_back(CGAL::to_double(point.y()));
    }
  }

  void write_edges(Subdivision& out) {
    out.edges.reserve(4 * arrangement_.number_of_edges());
    out.curve_starts.push_back(0);
    for (auto edge = arrangement_.edges_begin(); edge != arrangement_.edges_end(); ++edge) {
      Arrangement::Halfedge_handle half = edge;
      if (half->direction() == CGAL::ARR_RIGHT_TO_LEFT) half = half->twin();
      out.edges.push_back(half->source()->data());
      out.edges.push_back(half->target()->data());
      out.edges.push_back(half->face()->data());
      out.edges.push_back(half->twin()->face()->data());
      for (std::uint32_t name : names(edge->curve())) out.curves.push_back(name);
      out.curve_starts.push_back(static_cast<std::uint32_t>(out.curves.size()));
    }
  }

  static std::vector<std::uint32_t> names(const Curve& curve) {
    std::vector<std::uint32_t> names(curve.data().begin(), curve.data().end());
    std::sort(names.begin(), names.end());
    return names;
  }

  // The planes on an edge.
  std::vector<std::uint32_t> lines(const Curve& curve) const {
    std::vector<std::uint32_t> lines = names(curve);
    lines.erase(std::lower_bound(lines.begin(), lines.end(), planes_.count()), lines.end());
    return lines;
  }

  // Edges on the same line have the same planes, so a corner is where edges
  // with different planes meet.
  bool is_corner(Arrangement::Vertex_const_handle vertex) const {
    std::vector<std::uint32_t> first;
    auto around = vertex->incident_halfedges();
    const auto begin = around;
    do {
      std::vector<std::uint32_t> here = lines(around->curve());
      if (here.empty()) continue;
      if (!first.empty() && here != first) return true;
      first = std::move(here);
    } while (++around != begin);
    return false;
  }

  void write_corners(Subdivision& out) {
    std::vector<Arrangement::Vertex_const_handle> corners;
    for (auto vertex = arrangement_.vertices_begin(); vertex != arrangement_.vertices_end();
         ++vertex) {
      if (!is_corner(vertex)) continue;
      corners.push_back(vertex);
      out.corners.push_back(vertex->data());
    }
    out.sides.reserve(corners.size() * planes_.count());
    for (const auto& corner : corners) write_sides(corner, out);
  }

  void write_sides(Arrangement::Vertex_const_handle corner, Subdivision& out) const {
    const Exact point{CGAL::exact(corner->point()).x(), CGAL::exact(corner->point()).y()};
    std::vector<std::int8_t> row(planes_.count(), 0);
    for (std::uint32_t other : write_certain_sides(point, row)) {
      row[other] = static_cast<std::int8_t>(CGAL::sign(sides_[other].at(point)));
    }
    for (std::int8_t sign : row) out.sides.push_back(sign);
  }

  // The signs that interval arithmetic can tell; returns the other planes.
  std::vector<std::uint32_t> write_certain_sides(const Exact& point,
                                                 std::vector<std::int8_t>& row) const {
    const Interval u(CGAL::to_interval(point.u)), v(CGAL::to_interval(point.v));
    std::vector<std::uint32_t> doubtful;
    const Interval::Protector protector;
    for (std::uint32_t other : distinct_) {
      if (other == own_) continue;
      const Interval value = sides_[other].around(u, v);
      if (value.inf() > 0) {
        row[other] = 1;
      } else if (value.sup() < 0) {
        row[other] = -1;
      } else {
        doubtful.push_back(other);
      }
    }
    return doubtful;
  }

  Planes planes_;
  rust::Slice<const std::uint32_t> distinct_;
  std::uint32_t own_;
  std::array<std::uint32_t, 3> axes_;
  std::vector<SideFunction> sides_;
  Outline outline_;
  std::vector<Curve> curves_;
  Arrangement arrangement_;
};

}  // namespace

rust::Vec<std::uint32_t> first_coincident(rust::Slice<const double> numbers) {
  require_finite(numbers);
  const Planes planes{numbers};
  rust::Vec<std::uint32_t> first;
  for (std::size_t plane = 0; plane < planes.count(); ++plane) {
    std::size_t found = 0;
    while (found < plane && !(first[found] == found && planes.coincide(found, plane))) ++found;
    first.push_back(static_cast<std::uint32_t>(found));
  }
  return first;
}

Subdivision subdivide(rust::Slice<const double> planes, rust::Slice<const std::uint32_t> distinct,
                      std::uint32_t own, rust::Slice<const std::uint32_t> axes,
                      rust::Slice<const double> bounds, rust::Slice<const double> vertices,
                      rust::Slice<const std::uint32_t> edges) {
  require_finite(planes);
  require_finite(bounds);
  require_finite(vertices);
  Plane plane(Planes{planes}, distinct, own, axes);
  plane.add_outline(bounds);
  if (plane.misses_the_box()) return Subdivision{};
  plane.add_lines();
  plane.add_edges(vertices, edges);
  return plane.subdivide();
}

}  // namespace transect::arrangement
