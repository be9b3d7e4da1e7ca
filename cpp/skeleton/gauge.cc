#include "transect/cpp/skeleton/gauge.h"

#include <CGAL/Polyhedron_3.h>
#include <CGAL/convex_hull_3.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>

namespace transect::skeleton::partial {
namespace {

using Hull = CGAL::Polyhedron_3<Kernel>;

// Directions nearer than this (the cosine of 26 degrees) to a corner fill no gap.
constexpr double near = 0.9;

double cosine(const Vector& a, const Vector& b) {
  const auto product = [](const Vector& u, const Vector& v) { return CGAL::to_double(u * v); };
  return product(a, b) / std::sqrt(product(a, a) * product(b, b));
}

// The 26 neighbours of a cube, drawn a little inside the unit ball.
std::vector<Vector> neighbours() {
  const int lengths[4] = {0, 1024, 724, 591};  // 1024/√count, rounded down
  std::vector<Vector> result;
  for (int count = 1; count <= 3; ++count) {
    for (int code = 0; code < 27; ++code) {
      const int x = code % 3 - 1, y = code / 3 % 3 - 1, z = code / 9 - 1;
      if (x * x + y * y + z * z != count) continue;
      const Number length = Number(lengths[count]) / 1024;
      result.push_back(Vector(x * length, y * length, z * length));
    }
  }
  return result;
}

// The scale, rounded to a number of bits. Few bits make small numbers, and what would
// coincide but for the irrational lengths of normals (in symmetric input) misses by more
// than a rounded coordinate does.
Number scale(const Plane& plane, int bits) {
  if (bits > std::numeric_limits<double>::digits) return plane.scale;
  int exponent;
  const double mantissa = std::frexp(CGAL::to_double(plane.scale), &exponent);
  return std::ldexp(std::round(std::ldexp(mantissa, bits)), exponent - bits);
}

// s n and −s n, once for parallel planes.
std::vector<Vector> normals(const std::vector<Plane>& planes, int bits) {
  std::vector<Vector> result;
  for (const Plane& plane : planes) {
    const auto parallel = [&](const Vector& other) {
      return CGAL::cross_product(other, plane.normal) == CGAL::NULL_VECTOR;
    };
    if (std::any_of(result.begin(), result.end(), parallel)) continue;
    const Vector corner = plane.normal * scale(plane, bits);
    result.push_back(corner);
    result.push_back(-corner);
  }
  return result;
}

// Whether each of the first corners is the farthest along itself.
bool farthest_each(const std::vector<Vector>& corners, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = 0; j < corners.size(); ++j) {
      if (i != j && corners[i] * corners[j] >= corners[i] * corners[i]) return false;
    }
  }
  return true;
}

// More than any scale is rounded to.
constexpr int all_bits = 96;

std::vector<Vector> all_corners(const std::vector<Plane>& planes) {
  for (int bits : {24, 48, all_bits}) {
    std::vector<Vector> corners = normals(planes, bits);
    const std::size_t count = corners.size();
    for (const Vector& direction : neighbours()) {
      const auto close = [&](const Vector& corner) { return cosine(corner, direction) > near; };
      if (std::none_of(corners.begin(), corners.end(), close)) corners.push_back(direction);
    }
    if (farthest_each(corners, count)) return corners;
  }
  throw std::domain_error("two planes are too close to parallel for their scales");
}

}  // namespace

Gauge::Gauge(const std::vector<Plane>& planes) {
  corners = all_corners(planes);
  std::map<Point, Index> names;
  std::vector<Point> points;
  for (const Vector& corner : corners) {
    names.emplace(CGAL::ORIGIN + corner, static_cast<Index>(points.size()));
    points.push_back(CGAL::ORIGIN + corner);
  }
  Hull hull;
  CGAL::convex_hull_3(points.begin(), points.end(), hull);

  // The hull's triangles; those in one plane are one facet.
  std::map<Point, Index> polars;
  std::map<const void*, Index> facet_of;
  for (auto face = hull.facets_begin(); face != hull.facets_end(); ++face) {
    const auto edge = face->halfedge();
    const Kernel::Plane_3 plane(edge->vertex()->point(), edge->next()->vertex()->point(),
                                edge->next()->next()->vertex()->point());
    const Vector polar = plane.orthogonal_vector() / -plane.d();
    const auto [at, fresh] =
        polars.try_emplace(CGAL::ORIGIN + polar, static_cast<Index>(facets.size()));
    if (fresh) facets.push_back({polar, {}});
    facet_of[&*face] = at->second;
    std::vector<Index>& own = facets[at->second].corners;
    auto around = face->facet_begin();
    for (std::size_t i = 0; i < face->facet_degree(); ++i, ++around) {
      const Index corner = names.at(around->vertex()->point());
      if (std::find(own.begin(), own.end(), corner) == own.end()) own.push_back(corner);
    }
  }
  for (auto edge = hull.edges_begin(); edge != hull.edges_end(); ++edge) {
    const Index left = facet_of.at(&*edge->facet());
    const Index right = facet_of.at(&*edge->opposite()->facet());
    if (left == right) continue;
    edges.push_back(
        {{names.at(edge->vertex()->point()), names.at(edge->opposite()->vertex()->point())},
         {left, right}});
  }
}

bool Gauge::scales_suffice(const std::vector<Plane>& planes) {
  const std::vector<Vector> corners = normals(planes, all_bits);
  return farthest_each(corners, corners.size());
}

const Vector& Gauge::farthest(const Vector& normal) const {
  return *std::max_element(corners.begin(), corners.end(), [&](const Vector& a, const Vector& b) {
    return normal * a < normal * b;
  });
}

}  // namespace transect::skeleton::partial
