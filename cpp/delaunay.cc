#include "transect/cpp/delaunay.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Labeled_mesh_domain_3.h>
#include <CGAL/Mesh_complex_3_in_triangulation_3.h>
#include <CGAL/Mesh_criteria_3.h>
#include <CGAL/Mesh_domain_with_polyline_features_3.h>
#include <CGAL/Mesh_triangulation_3.h>
#include <CGAL/make_mesh_3.h>
#include <CGAL/refine_mesh_3.h>
#include <CGAL/version.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <map>
#include <stdexcept>
#include <string>
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

// Whether a point is in the ball of a vertex on a curve, where no others may
// be.
bool is_protected(const Triangulation& triangulation, const Triangulation::Weighted_point& point) {
  if (triangulation.dimension() < 3) {
    for (auto v = triangulation.finite_vertices_begin(); v != triangulation.finite_vertices_end();
         ++v) {
      const auto& ball = triangulation.point(v);
      if (CGAL::squared_distance(ball.point(), point.point()) <= ball.weight()) return true;
    }
    return false;
  }
  Triangulation::Locate_type type;
  int i, j;
  const Cell cell = triangulation.locate(point, type, i, j);
  if (triangulation.side_of_power_sphere(cell, point, true) != CGAL::ON_BOUNDED_SIDE) return true;
  std::vector<Vertex> around;
  triangulation.vertices_on_conflict_zone_boundary(point, cell, std::back_inserter(around));
  for (const Vertex v : around) {
    if (triangulation.is_infinite(v)) continue;
    const auto& ball = triangulation.point(v);
    if (CGAL::squared_distance(ball.point(), point.point()) <= ball.weight()) return true;
  }
  return false;
}

void insert_seeds(Complex& complex, const Domain& domain, rust::Slice<const double> seeds,
                  rust::Slice<const uint32_t> sides) {
  Triangulation& triangulation = complex.triangulation();
  for (size_t seed = 0; 3 * seed + 2 < seeds.size(); ++seed) {
    const Triangulation::Weighted_point point(point_at(seeds, seed));
    if (is_protected(triangulation, point)) continue;
    const Vertex vertex = triangulation.insert(point);
    if (vertex == Vertex()) continue;
    const int one = static_cast<int>(sides[2 * seed]),
              other = static_cast<int>(sides[2 * seed + 1]);
    const std::pair<int, int> patch(std::min(one, other), std::max(one, other));
    complex.set_dimension(vertex, 2);
    complex.set_index(vertex, domain.index_from_surface_patch_index(patch));
  }
}

// The label of every cell is that of its dual point, as in CGAL's facets.
class Labels {
 public:
  Labels(const Triangulation& triangulation, const Oracle& oracle)
      : triangulation_(triangulation), oracle_(oracle) {}

  uint32_t operator()(const Cell& cell) {
    if (triangulation_.is_infinite(cell)) return 0;
    const auto [place, is_new] = known_.try_emplace(cell, 0);
    if (is_new) {
      const Point centre = triangulation_.dual(cell);
      place->second = oracle_.label_at(centre.x(), centre.y(), centre.z());
    }
    return place->second;
  }

 private:
  const Triangulation& triangulation_;
  const Oracle& oracle_;
  std::unordered_map<Cell, uint32_t, CGAL::Handle_hash_function> known_;
};

class Extraction {
 public:
  Extraction(const Triangulation& triangulation, const Oracle& oracle)
      : triangulation_(triangulation), label_(triangulation, oracle) {}

  Facets facets() {
    for (auto f = triangulation_.finite_facets_begin(); f != triangulation_.finite_facets_end();
         ++f) {
      add(*f);
    }
    for (auto e = triangulation_.finite_edges_begin(); e != triangulation_.finite_edges_end();
         ++e) {
      add_ring(*e);
    }
    return std::move(result_);
  }

 private:
  // The corners of facet i of a cell, in the order of vertex_triple_index,
  // turn counter-clockwise as seen from inside the cell.
  void add(const Facet& facet) {
    const auto [cell, i] = facet;
    const uint32_t front = label_(cell), back = label_(cell->neighbor(i));
    if (front == back) return;
    index_[key(facet)] = static_cast<uint32_t>(result_.sides.size() / 2);
    for (int corner = 0; corner < 3; ++corner) {
      const int place = Triangulation::vertex_triple_index(i, corner);
      result_.triangles.push_back(number(cell->vertex(place)));
    }
    result_.sides.push_back(back);
    result_.sides.push_back(front);
  }

  void add_ring(const Triangulation::Edge& edge) {
    std::vector<uint32_t> ring;
    auto first = triangulation_.incident_facets(edge);
    auto facet = first;
    do {
      const auto found = index_.find(key(*facet));
      if (found != index_.end()) ring.push_back(found->second);
    } while (++facet != first);
    if (ring.size() < 4 || !repeats(ring)) return;
    const auto [cell, i, j] = edge;
    result_.rings.push_back(number(cell->vertex(i)));
    result_.rings.push_back(number(cell->vertex(j)));
    result_.rings.push_back(static_cast<uint32_t>(ring.size()));
    for (const uint32_t facet : ring) result_.rings.push_back(facet);
  }

  // Whether a label has more than two of these facets.
  bool repeats(const std::vector<uint32_t>& ring) const {
    std::map<uint32_t, int> count;
    for (const uint32_t facet : ring) {
      if (++count[result_.sides[2 * facet]] > 2) return true;
      if (++count[result_.sides[2 * facet + 1]] > 2) return true;
    }
    return false;
  }

  // A facet has two names, one from each of its cells.
  static std::pair<size_t, int> name(const Cell& cell, int i) { return {cell->time_stamp(), i}; }
  static std::pair<size_t, int> key(const Facet& facet) {
    const Cell other = facet.first->neighbor(facet.second);
    return std::min(name(facet.first, facet.second), name(other, other->index(facet.first)));
  }

  uint32_t number(const Vertex& vertex) {
    const auto [place, is_new] =
        numbers_.try_emplace(vertex, static_cast<uint32_t>(result_.points.size() / 3));
    if (is_new) {
      const Point& point = triangulation_.point(vertex).point();
      for (const double coordinate : {point.x(), point.y(), point.z()}) {
        result_.points.push_back(coordinate);
      }
    }
    return place->second;
  }

  const Triangulation& triangulation_;
  Labels label_;
  std::map<std::pair<size_t, int>, uint32_t> index_;
  std::unordered_map<Vertex, uint32_t, CGAL::Handle_hash_function> numbers_;
  Facets result_;
};

}  // namespace

Facets refine(const Oracle& oracle, rust::Slice<const double> bounds,
              rust::Slice<const double> seeds, rust::Slice<const uint32_t> seed_sides,
              rust::Slice<const double> curve_points, rust::Slice<const uint32_t> curve_ends,
              const Criteria& criteria) {
  Domain domain = make_domain(oracle, bounds, criteria.error);
  add_curves(domain, curve_points, curve_ends);
  const Mesh_criteria mesh_criteria(CGAL::Mesh_edge_criteria_3<Triangulation>(criteria.edge),
                                    Facet_criteria(criteria),
                                    CGAL::Mesh_cell_criteria_3<Triangulation>(0.0, 0.0));
  Complex complex;
  if (!curve_ends.empty()) {
    CGAL::Mesh_3::internal::init_c3t3_with_features(complex, domain, mesh_criteria);
  }
  insert_seeds(complex, domain, seeds, seed_sides);
  namespace parameters = CGAL::parameters;
  CGAL::refine_mesh_3(complex, domain, mesh_criteria, parameters::no_exude(),
                      parameters::no_perturb(), parameters::no_reset_c3t3());
  return Extraction(complex.triangulation(), oracle).facets();
}

}  // namespace transect::delaunay
