#include "transect/cpp/decimation.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_simplification/Edge_collapse_visitor_base.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>
#include <CGAL/version.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "transect/src/ffi/decimation.rs.h"

#if CGAL_VERSION_NR >= CGAL_VERSION_NUMBER(6, 0, 0)
#include <optional>
#else
#include <boost/optional.hpp>
#endif

namespace transect::decimation {

namespace {

namespace SMS = CGAL::Surface_mesh_simplification;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Vector = Kernel::Vector_3;
using Polyhedron = CGAL::Surface_mesh<Point>;
using Vertex = Polyhedron::Vertex_index;
using Edge = Polyhedron::Edge_index;

#if CGAL_VERSION_NR >= CGAL_VERSION_NUMBER(6, 0, 0)
template <typename T>
using Optional = std::optional<T>;
#else
template <typename T>
using Optional = boost::optional<T>;
#endif

constexpr uint32_t kNoName = std::numeric_limits<uint32_t>::max();
// A triangle's normal turns by no more than the angle of this cosine in one step.
constexpr double kUpright = 0.5;
// How much the middle of an edge draws what its planes leave free, against these.
constexpr double kMiddle = 1e-3;
// How much the square of an edge's length counts, against that of the distance from planes:
// where all is flat short edges go first.
constexpr double kShort = 1e-4;
// Collapses between two questions whether to go on.
constexpr size_t kStep = 1024;

// The squared distances of a point from planes, each as often as its triangle has area: x' A x +
// 2 b' x + c (Garland and Heckbert 1997). CGAL's own of the kind need Eigen.
struct Quadric {
  double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
  double bx = 0, by = 0, bz = 0;
  double c = 0;
  double area = 0;

  static Quadric of(const Point& p, const Point& q, const Point& r) {
    Vector n = CGAL::cross_product(q - p, r - p);
    const double length = std::sqrt(n.squared_length());
    if (length == 0) return {};
    n = n / length;
    const double d = -(n * (p - CGAL::ORIGIN)), a = length / 2;
    return {a * n.x() * n.x(),
            a * n.x() * n.y(),
            a * n.x() * n.z(),
            a * n.y() * n.y(),
            a * n.y() * n.z(),
            a * n.z() * n.z(),
            a * d * n.x(),
            a * d * n.y(),
            a * d * n.z(),
            a * d * d,
            a};
  }

  Quadric operator+(const Quadric& o) const {
    return {xx + o.xx, xy + o.xy, xz + o.xz, yy + o.yy, yz + o.yz,    zz + o.zz,
            bx + o.bx, by + o.by, bz + o.bz, c + o.c,   area + o.area};
  }

  double at(const Point& p) const {
    const double x = p.x(), y = p.y(), z = p.z();
    const double value = x * (xx * x + 2 * (xy * y + xz * z + bx)) +
                         y * (yy * y + 2 * (yz * z + by)) + z * (zz * z + 2 * bz) + c;
    return std::max(value, 0.0);
  }

  // Where it is least, but for a little that draws to `middle`.
  Point least(const Point& middle) const {
    const double k = kMiddle * area;
    if (!(k > 0)) return middle;
    const double a = xx + k, b = xy, d = xz, e = yy + k, f = yz, g = zz + k;
    const double u = k * middle.x() - bx, v = k * middle.y() - by, w = k * middle.z() - bz;
    const double ca = e * g - f * f, cb = d * f - b * g, cd = b * f - d * e;
    const double determinant = a * ca + b * cb + d * cd;
    const double ce = a * g - d * d, cf = b * d - a * f, cg = a * e - b * b;
    const Point found((ca * u + cb * v + cd * w) / determinant,
                      (cb * u + ce * v + cf * w) / determinant,
                      (cd * u + cf * v + cg * w) / determinant);
    const bool is_finite =
        std::isfinite(found.x()) && std::isfinite(found.y()) && std::isfinite(found.z());
    return is_finite ? found : middle;
  }
};

// What is known of every vertex, by its number.
struct State {
  Polyhedron mesh;
  std::vector<Quadric> quadrics;
  std::vector<uint32_t> names;
  // How far it may come from what it was made of, and how far it came, by the sum of its steps.
  std::vector<double> limits;
  std::vector<double> reached;
  // The same for the two that come together next.
  double next = 0;
  // The vertex that it became part of; itself where it is there.
  std::vector<uint32_t> into;

  // Quadrics are relative to a point of the mesh: far from the origin digits would cancel out.
  Vector base = CGAL::NULL_VECTOR;

  bool is_named(Vertex v) const { return names[v] != kNoName; }
  Quadric sum(Vertex v0, Vertex v1) const { return quadrics[v0] + quadrics[v1]; }
  double error(const Quadric& quadric, const Point& place) const {
    return quadric.at(place - base);
  }
  // How far the vertex comes that an edge becomes: as its ends have, and one step more. A step is
  // how far they are from the triangles that come, and the middles of new edges from those that
  // were.
  template <typename Profile>
  double far(const Profile& profile, const Point& place) const {
    std::vector<Kernel::Triangle_3> before, after;
    std::vector<Point> middles{place};
    const auto& triangles = profile.triangles();
    for (size_t i = 0; i < triangles.size(); ++i) {
      const auto& corners = triangles[i];
      const Point &p = mesh.point(corners.v0), &q = mesh.point(corners.v1),
                  &r = mesh.point(corners.v2);
      before.emplace_back(p, q, r);
      if (i < at_edge(profile)) continue;
      after.emplace_back(p, place, r);
      middles.push_back(CGAL::midpoint(p, place));
      middles.push_back(CGAL::midpoint(r, place));
    }
    double step = std::max(nearest(profile.p0(), after), nearest(profile.p1(), after));
    for (const Point& middle : middles) step = std::max(step, nearest(middle, before));
    return std::max(reached[profile.v0()], reached[profile.v1()]) + std::sqrt(step);
  }
  // The square of the distance to the nearest of some triangles.
  static double nearest(const Point& point, const std::vector<Kernel::Triangle_3>& triangles) {
    double least = std::numeric_limits<double>::infinity();
    for (const auto& own : triangles) least = std::min(least, CGAL::squared_distance(point, own));
    return least;
  }
  // CGAL lists the triangles at the edge first, then those that remain; the second corner is the
  // one that moves.
  template <typename Profile>
  static size_t at_edge(const Profile& profile) {
    return (profile.left_face_exists() ? 1 : 0) + (profile.right_face_exists() ? 1 : 0);
  }
  uint32_t there(uint32_t v) {
    while (into[v] != v) v = into[v] = into[into[v]];
    return v;
  }
};

// Where two vertices come together: the one with a name stays where it is.
struct Placement {
  const State* state;

  template <typename Profile>
  Optional<Point> operator()(const Profile& profile) const {
    const bool first = state->is_named(profile.v0()), second = state->is_named(profile.v1());
    if (first && second) return {};
    if (first) return profile.p0();
    if (second) return profile.p1();
    const Point middle = CGAL::midpoint(profile.p0(), profile.p1());
    return state->sum(profile.v0(), profile.v1()).least(middle - state->base) + state->base;
  }
};

struct Cost {
  const State* state;

  template <typename Profile>
  Optional<double> operator()(const Profile& profile, const Optional<Point>& place) const {
    if (!place) return {};
    const Quadric sum = state->sum(profile.v0(), profile.v1());
    const double length = CGAL::squared_distance(profile.p0(), profile.p1());
    return state->error(sum, *place) + kShort * sum.area * length;
  }
};

// What must not be: a triangle that turns over, a vertex too far from its planes, a new edge
// between two names (another patch could have one between the same).
struct Filter {
  const State* state;

  template <typename Profile>
  Optional<Point> operator()(const Profile& profile, const Optional<Point>& place) const {
    if (!place || is_too_far(profile, *place) || turns_over(profile, *place) ||
        joins_names(profile)) {
      return {};
    }
    return place;
  }

  template <typename Profile>
  bool is_too_far(const Profile& profile, const Point& place) const {
    const double limit = std::min(state->limits[profile.v0()], state->limits[profile.v1()]);
    return std::isfinite(limit) && state->far(profile, place) > limit;
  }

  template <typename Profile>
  bool turns_over(const Profile& profile, const Point& place) const {
    const auto& triangles = profile.triangles();
    for (size_t i = State::at_edge(profile); i < triangles.size(); ++i) {
      const Point& p = state->mesh.point(triangles[i].v0);
      const Point& q = state->mesh.point(triangles[i].v1);
      const Point& r = state->mesh.point(triangles[i].v2);
      const Vector before = CGAL::cross_product(p - q, r - q);
      const Vector after = CGAL::cross_product(p - place, r - place);
      const double lengths = std::sqrt(before.squared_length() * after.squared_length());
      if (!(before * after > kUpright * lengths)) return true;
    }
    return false;
  }

  template <typename Profile>
  bool joins_names(const Profile& profile) const {
    if (!state->is_named(profile.v0()) && !state->is_named(profile.v1())) return false;
    const Vertex free = state->is_named(profile.v0()) ? profile.v1() : profile.v0();
    const Vertex named = free == profile.v0() ? profile.v1() : profile.v0();
    const Polyhedron& mesh = state->mesh;
    for (const auto h : CGAL::halfedges_around_target(free, mesh)) {
      const Vertex other = mesh.source(h);
      if (other == named || !state->is_named(other)) continue;
      if (state->names[other] == state->names[named]) return true;
      if (!mesh.halfedge(other, named).is_valid()) return true;
    }
    return false;
  }
};

// Ends when few enough triangles are left, or nobody wants more.
struct Stop {
  const State* state;
  size_t wanted;
  const Watch* watch;
  size_t* steps;

  template <typename Profile>
  bool operator()(double, const Profile&, size_t, size_t) const {
    if (state->mesh.number_of_faces() <= wanted) return true;
    return ++*steps % kStep == 0 && !watch->goes_on();
  }
};

struct Visitor : SMS::Edge_collapse_visitor_base<Polyhedron> {
  State* state;

  explicit Visitor(State* own) : state(own) {}

  template <typename Profile>
  void OnCollapsing(const Profile& profile, const Optional<Point>& place) {
    state->next = place ? state->far(profile, *place) : 0;
  }

  template <typename Profile>
  void OnCollapsed(const Profile& profile, Vertex stays) {
    const Vertex v0 = profile.v0(), v1 = profile.v1();
    const Vertex goes = stays == v0 ? v1 : v0;
    state->into[goes] = stays;
    state->quadrics[stays] = state->quadrics[v0] + state->quadrics[v1];
    state->limits[stays] = std::min(state->limits[v0], state->limits[v1]);
    if (state->is_named(goes)) state->names[stays] = state->names[goes];
    // Whatever moved came some way, if only by rounding: 0 says that nothing did.
    const double least = std::numeric_limits<double>::min();
    state->reached[stays] = std::max({state->next, state->reached[v0], state->reached[v1], least});
    state->next = 0;
  }
};

// Edges that are not touched: between two names, and those without length, which CGAL would make
// one point without asking, at a name.
struct Untouched {
  using key_type = Edge;
  using value_type = bool;
  using reference = bool;
  using category = boost::readable_property_map_tag;
  const State* state;

  friend bool get(const Untouched& map, Edge edge) {
    const Polyhedron& mesh = map.state->mesh;
    const Vertex v0 = mesh.vertex(edge, 0), v1 = mesh.vertex(edge, 1);
    const bool first = map.state->is_named(v0), second = map.state->is_named(v1);
    return (first && second) || ((first || second) && mesh.point(v0) == mesh.point(v1));
  }
};

void read(State& state, rust::Slice<const double> points, rust::Slice<const uint32_t> triangles,
          rust::Slice<const uint32_t> names, rust::Slice<const double> limits,
          rust::Slice<const double> reached) {
  const size_t count = points.size() / 3;
  if (names.size() != count || limits.size() != count || reached.size() != count)
    throw std::out_of_range("vertex count");
  for (size_t i = 0; i < count; ++i) {
    state.mesh.add_vertex(Point(points[3 * i], points[3 * i + 1], points[3 * i + 2]));
    state.into.push_back(static_cast<uint32_t>(i));
  }
  if (count > 0) state.base = state.mesh.point(Vertex(0)) - CGAL::ORIGIN;
  state.names.assign(names.begin(), names.end());
  state.limits.assign(limits.begin(), limits.end());
  state.reached.assign(reached.begin(), reached.end());
  state.quadrics.resize(count);
  for (size_t i = 0; i + 2 < triangles.size(); i += 3) {
    const uint32_t corners[3] = {triangles[i], triangles[i + 1], triangles[i + 2]};
    for (const uint32_t corner : corners) {
      if (corner >= count) throw std::out_of_range("vertex index");
    }
    const Vertex a(corners[0]), b(corners[1]), c(corners[2]);
    if (state.mesh.add_face(a, b, c) == Polyhedron::null_face()) {
      throw std::invalid_argument("the triangles are no manifold");
    }
    const auto relative = [&](Vertex v) { return state.mesh.point(v) - state.base; };
    const Quadric own = Quadric::of(relative(a), relative(b), relative(c));
    for (const uint32_t corner : corners) state.quadrics[corner] = state.quadrics[corner] + own;
  }
}

Simplified to_simplified(State& state) {
  Simplified made;
  std::vector<uint32_t> numbers(state.into.size(), 0);
  for (const Vertex vertex : state.mesh.vertices()) {
    numbers[vertex] = static_cast<uint32_t>(made.reached.size());
    for (int axis = 0; axis < 3; ++axis) made.points.push_back(state.mesh.point(vertex)[axis]);
    made.names.push_back(state.names[vertex]);
    made.reached.push_back(state.reached[vertex]);
  }
  for (uint32_t i = 0; i < state.into.size(); ++i) made.places.push_back(numbers[state.there(i)]);
  for (const auto face : state.mesh.faces()) {
    made.origins.push_back(static_cast<uint32_t>(face));
    for (const Vertex vertex : state.mesh.vertices_around_face(state.mesh.halfedge(face))) {
      made.triangles.push_back(numbers[vertex]);
    }
  }
  return made;
}

}  // namespace

Simplified simplify(rust::Slice<const double> points, rust::Slice<const uint32_t> triangles,
                    rust::Slice<const uint32_t> names, rust::Slice<const double> limits,
                    rust::Slice<const double> reached, std::size_t wanted, const Watch& watch) {
  State state;
  read(state, points, triangles, names, limits, reached);
  size_t steps = 0;
  Visitor visitor(&state);
  SMS::edge_collapse(state.mesh, Stop{&state, wanted, &watch, &steps},
                     CGAL::parameters::edge_is_constrained_map(Untouched{&state})
                         .get_cost(Cost{&state})
                         .get_placement(Placement{&state})
                         .filter(Filter{&state})
                         .visitor(visitor));
  return to_simplified(state);
}

}  // namespace transect::decimation
