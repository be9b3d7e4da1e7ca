#include "transect/cpp/delaunay.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Labeled_mesh_domain_3.h>
#include <CGAL/Mesh_complex_3_in_triangulation_3.h>
#include <CGAL/Mesh_criteria_3.h>
#include <CGAL/Mesh_domain_with_polyline_features_3.h>
#include <CGAL/Mesh_triangulation_3.h>
#include <CGAL/Spatial_sort_traits_adapter_3.h>
#include <CGAL/make_mesh_3.h>
#include <CGAL/property_map.h>
#include <CGAL/refine_mesh_3.h>
#include <CGAL/spatial_sort.h>
#include <CGAL/version.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numeric>
#include <stdexcept>
#include <string>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>

#include "transect/src/ffi/delaunay.rs.h"

namespace transect::delaunay {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Domain = CGAL::Mesh_domain_with_polyline_features_3<CGAL::Labeled_mesh_domain_3<Kernel>>;
// Sequential: CGAL's parallel refinement gives another mesh on every run.
using Triangulation = CGAL::Mesh_triangulation_3<Domain, CGAL::Default, CGAL::Sequential_tag>::type;
using Complex = CGAL::Mesh_complex_3_in_triangulation_3<Triangulation, Domain::Corner_index,
                                                        Domain::Curve_index>;
using Vertex = Triangulation::Vertex_handle;
using Cell = Triangulation::Cell_handle;
using Facet = Triangulation::Facet;

// CGAL's criteria, less what would not come to an end: facets that are small
// already. Every point that is inserted is then at least that far from all
// others, so that refinement stops; the limit keeps it from filling memory.
class Facet_criteria : public CGAL::Mesh_facet_criteria_3<Triangulation> {
  using Base = CGAL::Mesh_facet_criteria_3<Triangulation>;

 public:
  explicit Facet_criteria(const transect::delaunay::Criteria& criteria)
      : Base(criteria.angle, criteria.size, criteria.distance),
        smallest_(criteria.smallest * criteria.smallest),
        most_vertices_(criteria.most_vertices) {}

  Is_facet_bad operator()(const Triangulation& triangulation,
                          const Triangulation::Facet& facet) const {
    if (triangulation.number_of_vertices() > most_vertices_) {
      throw std::length_error(
          "more than " + std::to_string(most_vertices_) +
          " vertices are needed: use a larger --facet-size or --facet-distance");
    }
    const Point& centre = facet.first->get_facet_surface_center(facet.second);
    const Point corner = triangulation.point(facet.first, (facet.second + 1) % 4).point();
    if (CGAL::squared_distance(centre, corner) < smallest_) return Is_facet_bad();
    return Base::operator()(triangulation, facet);
  }

 private:
  double smallest_;
  size_t most_vertices_;
};

using Mesh_criteria =
    CGAL::Mesh_criteria_3<Triangulation, CGAL::Mesh_edge_criteria_3<Triangulation>, Facet_criteria>;

Domain make_domain(const Oracle& oracle, rust::Slice<const double> bounds, double error) {
  const CGAL::Bbox_3 box(bounds[0], bounds[1], bounds[2], bounds[3], bounds[4], bounds[5]);
  // CGAL bisects down to a length relative to half the box's diagonal.
  const double diagonal = std::sqrt(CGAL::to_double(CGAL::squared_distance(
      Point(box.xmin(), box.ymin(), box.zmin()), Point(box.xmax(), box.ymax(), box.zmax()))));
  const double relative = 2 * error / diagonal;
  const auto label = [&oracle](const Point& point) {
    return static_cast<int>(oracle.label_at(point.x(), point.y(), point.z()));
  };
#if CGAL_VERSION_NR < 1050601000
  return Domain(std::function<int(const Point&)>(label), box, relative);
#else
  return Domain(label, box, CGAL::parameters::relative_error_bound(relative));
#endif
}

Point point_at(rust::Slice<const double> points, size_t index) {
  return Point(points[3 * index], points[3 * index + 1], points[3 * index + 2]);
}

void add_curves(Domain& domain, rust::Slice<const double> points,
                rust::Slice<const uint32_t> ends) {
  std::vector<std::vector<Point>> curves;
  size_t start = 0;
  for (const uint32_t end : ends) {
    curves.emplace_back();
    for (; start < end; ++start) curves.back().push_back(point_at(points, start));
  }
  domain.add_features(curves.begin(), curves.end());
}

// Puts points of the surface into the triangulation, but for those in the ball
// of a vertex on a curve, where no others may be, and those that are there.
void insert_seeds(Complex& complex, const Domain& domain, rust::Slice<const double> seeds,
                  rust::Slice<const uint32_t> sides) {
  Triangulation& triangulation = complex.triangulation();
  std::vector<Point> points;
  for (size_t seed = 0; 3 * seed < seeds.size(); ++seed) points.push_back(point_at(seeds, seed));
  std::vector<size_t> order(points.size());
  std::iota(order.begin(), order.end(), 0);
  using Places = CGAL::Pointer_property_map<Point>::type;
  CGAL::spatial_sort(
      order.begin(), order.end(),
      CGAL::Spatial_sort_traits_adapter_3<Kernel, Places>(CGAL::make_property_map(points)));
  Cell near;
  for (const size_t seed : order) {
    const Triangulation::Weighted_point point(points[seed]);
    const Vertex nearest = triangulation.nearest_power_vertex(points[seed], near);
    if (nearest != Vertex()) {
      const auto& ball = triangulation.point(nearest);
      if (CGAL::squared_distance(ball.point(), points[seed]) <= ball.weight()) continue;
      near = nearest->cell();
    }
    const Vertex vertex = triangulation.insert(point, near);
    if (vertex == Vertex()) continue;
    near = vertex->cell();
    const int one = static_cast<int>(sides[2 * seed]),
              other = static_cast<int>(sides[2 * seed + 1]);
    const std::pair<int, int> patch(std::min(one, other), std::max(one, other));
    complex.set_dimension(vertex, 2);
    complex.set_index(vertex, domain.index_from_surface_patch_index(patch));
  }
}

// The facets between cells of different labels. The label of every cell is
// that of its dual point, as refinement left it.
class Extraction {
 public:
  explicit Extraction(const Triangulation& triangulation) : triangulation_(triangulation) {}

  Facets facets() {
    for (auto f = triangulation_.finite_facets_begin(); f != triangulation_.finite_facets_end();
         ++f) {
      add(*f);
    }
    add_rings();
    return std::move(result_);
  }

 private:
  uint32_t label(const Cell& cell) const {
    return triangulation_.is_infinite(cell) ? 0 : static_cast<uint32_t>(cell->subdomain_index());
  }

  // The corners of facet i of a cell, in the order of vertex_triple_index,
  // turn counter-clockwise as seen from inside the cell.
  void add(const Facet& facet) {
    const auto [cell, i] = facet;
    const uint32_t front = label(cell), back = label(cell->neighbor(i));
    if (front == back) return;
    facets_.push_back(facet);
    for (int corner = 0; corner < 3; ++corner) {
      const int place = Triangulation::vertex_triple_index(i, corner);
      result_.triangles.push_back(number(cell->vertex(place)));
    }
    result_.sides.push_back(back);
    result_.sides.push_back(front);
  }

  // The edges of four or more of the facets, and these in turn.
  void add_rings() {
    struct Side {
      std::array<uint32_t, 2> ends;
      uint32_t facet;
      bool operator<(const Side& other) const {
        return std::tie(ends, facet) < std::tie(other.ends, other.facet);
      }
    };
    std::vector<Side> sides;
    for (size_t at = 0; at < result_.triangles.size(); ++at) {
      const size_t facet = at / 3;
      const uint32_t start = result_.triangles[at],
                     end = result_.triangles[3 * facet + (at + 1) % 3];
      sides.push_back({{std::min(start, end), std::max(start, end)}, static_cast<uint32_t>(facet)});
    }
    std::sort(sides.begin(), sides.end());
    for (size_t first = 0, last; first < sides.size(); first = last) {
      std::vector<uint32_t> around;
      for (last = first; last < sides.size() && sides[last].ends == sides[first].ends; ++last) {
        around.push_back(sides[last].facet);
      }
      if (around.size() >= 4 && repeats(around)) add_ring(sides[first].ends, around);
    }
  }

  void add_ring(const std::array<uint32_t, 2>& ends, const std::vector<uint32_t>& around) {
    const auto [cell, opposite] = facets_[around[0]];
    const int i = cell->index(vertices_[ends[0]]), j = cell->index(vertices_[ends[1]]);
    for (const uint32_t number : {ends[0], ends[1], static_cast<uint32_t>(around.size())}) {
      result_.rings.push_back(number);
    }
    const auto first = triangulation_.incident_facets(cell, i, j, facets_[around[0]]);
    auto facet = first;
    do {
      const Facet mirror = triangulation_.mirror_facet(*facet);
      for (const uint32_t found : around) {
        if (facets_[found] == *facet || facets_[found] == mirror) result_.rings.push_back(found);
      }
    } while (++facet != first);
  }

  // Whether a label has more than two of these facets.
  bool repeats(const std::vector<uint32_t>& around) const {
    std::map<uint32_t, int> count;
    for (const uint32_t facet : around) {
      if (++count[result_.sides[2 * facet]] > 2) return true;
      if (++count[result_.sides[2 * facet + 1]] > 2) return true;
    }
    return false;
  }

  uint32_t number(const Vertex& vertex) {
    const auto [place, is_new] =
        numbers_.try_emplace(vertex, static_cast<uint32_t>(vertices_.size()));
    if (is_new) {
      vertices_.push_back(vertex);
      const Point& point = triangulation_.point(vertex).point();
      for (const double coordinate : {point.x(), point.y(), point.z()}) {
        result_.points.push_back(coordinate);
      }
    }
    return place->second;
  }

  const Triangulation& triangulation_;
  // Of every triangle, and of every point of the result.
  std::vector<Facet> facets_;
  std::vector<Vertex> vertices_;
  std::unordered_map<Vertex, uint32_t, CGAL::Handle_hash_function> numbers_;
  Facets result_;
};

}  // namespace

struct Refinement::State {
  Domain domain;
  Mesh_criteria criteria;
  Complex complex;
};

Refinement::Refinement(const Oracle& oracle, rust::Slice<const double> bounds,
                       rust::Slice<const double> curve_points,
                       rust::Slice<const uint32_t> curve_ends, const Criteria& criteria)
    : state_(new State{make_domain(oracle, bounds, criteria.error),
                       Mesh_criteria(CGAL::Mesh_edge_criteria_3<Triangulation>(criteria.edge),
                                     Facet_criteria(criteria),
                                     CGAL::Mesh_cell_criteria_3<Triangulation>(0.0, 0.0)),
                       Complex()}) {
  auto& [domain, mesh_criteria, complex] = *state_;
  add_curves(domain, curve_points, curve_ends);
  if (!curve_ends.empty()) {
    CGAL::Mesh_3::internal::init_c3t3_with_features(complex, domain, mesh_criteria);
  }
}

Refinement::~Refinement() = default;

Facets Refinement::refine(rust::Slice<const double> seeds, rust::Slice<const uint32_t> sides) {
  auto& [domain, mesh_criteria, complex] = *state_;
  insert_seeds(complex, domain, seeds, sides);
  namespace parameters = CGAL::parameters;
  CGAL::refine_mesh_3(complex, domain, mesh_criteria, parameters::no_exude(),
                      parameters::no_perturb(), parameters::no_reset_c3t3());
  return Extraction(complex.triangulation()).facets();
}

std::unique_ptr<Refinement> new_refinement(const Oracle& oracle, rust::Slice<const double> bounds,
                                           rust::Slice<const double> curve_points,
                                           rust::Slice<const uint32_t> curve_ends,
                                           const Criteria& criteria) {
  return std::make_unique<Refinement>(oracle, bounds, curve_points, curve_ends, criteria);
}

}  // namespace transect::delaunay
