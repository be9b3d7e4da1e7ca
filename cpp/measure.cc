#include "transect/cpp/measure.h"

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Box_intersection_d/Box_with_info_d.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/box_intersection_d.h>
#include <CGAL/version.h>
#include <openvdb/version.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "transect/src/ffi/measure.rs.h"

namespace transect::measure {

namespace {

namespace PMP = CGAL::Polygon_mesh_processing;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Polyhedron = CGAL::Surface_mesh<Kernel::Point_3>;
using Face = Polyhedron::Face_index;
using ComponentOf = Polyhedron::Property_map<Face, size_t>;

// A mesh, and how many triangles did not fit because an edge or a vertex had
// no place left for them.
std::pair<Polyhedron, uint64_t> polyhedron(rust::Slice<const double> points,
                                           rust::Slice<const uint32_t> triangles) {
  Polyhedron mesh;
  const size_t count = points.size() / 3;
  mesh.reserve(count, triangles.size() / 2, triangles.size() / 3);
  for (size_t i = 0; i < count; ++i) {
    mesh.add_vertex(Kernel::Point_3(points[3 * i], points[3 * i + 1], points[3 * i + 2]));
  }
  uint64_t left_out = 0;
  for (size_t i = 0; i + 2 < triangles.size(); i += 3) {
    const uint32_t a = triangles[i], b = triangles[i + 1], c = triangles[i + 2];
    if (a >= count || b >= count || c >= count) throw std::out_of_range("vertex index");
    using Vertex = Polyhedron::Vertex_index;
    const bool degenerate = a == b || b == c || c == a;
    if (degenerate || mesh.add_face(Vertex(a), Vertex(b), Vertex(c)) == Polyhedron::null_face()) {
      ++left_out;
    }
  }
  return {std::move(mesh), left_out};
}

double largest_of(const Kernel::Point_3& point) {
  return std::max({std::abs(point.x()), std::abs(point.y()), std::abs(point.z())});
}

// V, E and F of each connected component add up to its Euler characteristic.
std::vector<Component> components(const Polyhedron& mesh, const ComponentOf& component_of,
                                  size_t count) {
  std::vector<Component> components(count, Component{0, 0, 0, {0, 0, 0}, {0, 0, 0}});
  std::vector<CGAL::Bbox_3> boxes(count);
  // Relative to a vertex: far from the origin, digits would cancel.
  const Kernel::Point_3 base =
      mesh.is_empty() ? Kernel::Point_3(0, 0, 0) : mesh.point(*mesh.vertices_begin());
  for (const Face face : mesh.faces()) {
    const size_t id = component_of[face];
    components[id].euler += 1;
    const auto h = mesh.halfedge(face);
    const auto& a = mesh.point(mesh.target(h));
    const auto& b = mesh.point(mesh.target(mesh.next(h)));
    const auto& c = mesh.point(mesh.source(h));
    // By the triangle's own edges, whose product is as small as its area.
    const auto doubled = CGAL::cross_product(b - a, c - a);
    components[id].volume += (a - base) * doubled / 6;
    const double largest = std::max({largest_of(a), largest_of(b), largest_of(c)});
    components[id].rounding += std::numeric_limits<double>::epsilon() * largest *
                               std::sqrt((b - a).squared_length() * (c - a).squared_length());
    boxes[id] += a.bbox() + b.bbox() + c.bbox();
  }
  for (const auto edge : mesh.edges()) {
    auto h = mesh.halfedge(edge);
    if (mesh.is_border(h)) h = mesh.opposite(h);
    components[component_of[mesh.face(h)]].euler -= 1;
  }
  for (const auto vertex : mesh.vertices()) {
    if (mesh.is_isolated(vertex)) continue;
    auto h = mesh.halfedge(vertex);
    if (mesh.is_border(h)) h = mesh.opposite(h);
    components[component_of[mesh.face(h)]].euler += 1;
  }
  for (size_t id = 0; id < count; ++id) {
    const auto& box = boxes[id];
    components[id].min = {box.xmin(), box.ymin(), box.zmin()};
    components[id].max = {box.xmax(), box.ymax(), box.zmax()};
  }
  return components;
}

using Corners = std::array<Kernel::Point_3, 3>;

// Puts the corners that two triangles have at the same places first, in the
// same order. How many there are.
int match(Corners& one, Corners& other) {
  int count = 0;
  for (int i = 0; i < 3; ++i) {
    const auto same = std::find(other.begin() + count, other.end(), one[i]);
    if (same == other.end()) continue;
    std::swap(other[count], *same);
    std::swap(one[count], one[i]);
    ++count;
  }
  return count;
}

// What a triangle without area is: its longest side.
Kernel::Segment_3 longest_side(const Corners& own) {
  const Kernel::Segment_3 sides[3] = {{own[0], own[1]}, {own[1], own[2]}, {own[2], own[0]}};
  return *std::max_element(sides, sides + 3, [](const auto& one, const auto& other) {
    return one.squared_length() < other.squared_length();
  });
}

// A triangle as crossings are looked for.
struct Facet {
  Corners corners;
  bool has_area;
};

// Whether two triangles without a common corner have a common point.
bool meet(const Facet& one, const Facet& other) {
  if (!one.has_area && !other.has_area) return false;
  if (!one.has_area) return meet(other, one);
  const auto triangle = [](const Corners& own) {
    return Kernel::Triangle_3(own[0], own[1], own[2]);
  };
  if (other.has_area) return CGAL::do_intersect(triangle(one.corners), triangle(other.corners));
  const Kernel::Segment_3 side = longest_side(other.corners);
  if (side.is_degenerate()) return triangle(one.corners).has_on(side.source());
  return CGAL::do_intersect(side, triangle(one.corners));
}

// Whether two triangles meet other than in a corner or an edge that both have at the same
// place. Decided exactly. From a common corner on, everything else that both have leads out
// of one of them through the side opposite to it; two triangles at a common edge meet
// elsewhere only when one is folded onto the other.
bool cross(const Facet& one, const Facet& other) {
  Corners first = one.corners, second = other.corners;
  const int common = match(first, second);
  if (common == 0) return meet(one, other);
  if (common == 3) return true;
  if (!one.has_area || !other.has_area) return false;
  if (common == 1) {
    const Kernel::Triangle_3 a(first[0], first[1], first[2]), b(second[0], second[1], second[2]);
    return CGAL::do_intersect(Kernel::Segment_3(first[1], first[2]), b) ||
           CGAL::do_intersect(Kernel::Segment_3(second[1], second[2]), a);
  }
  return CGAL::coplanar(first[0], first[1], first[2], second[2]) &&
         CGAL::coplanar_orientation(first[0], first[1], first[2], second[2]) != CGAL::NEGATIVE;
}

}  // namespace

rust::String library_versions() {
  return std::string("CGAL ") + CGAL_VERSION_STR + ", OpenVDB " + OPENVDB_LIBRARY_VERSION_STRING;
}

Facts measure(rust::Slice<const double> points, rust::Slice<const uint32_t> triangles) {
  auto [mesh, left_out] = polyhedron(points, triangles);
  const ComponentOf component_of = mesh.add_property_map<Face, size_t>("component", 0).first;
  const size_t count = PMP::connected_components(mesh, component_of);
  Facts facts;
  facts.left_out = left_out;
  facts.closed = left_out == 0 && CGAL::is_closed(mesh);
  facts.area = CGAL::to_double(PMP::area(mesh));
  for (const Component& component : components(mesh, component_of, count)) {
    facts.components.push_back(component);
  }
  return facts;
}

rust::Vec<uint32_t> crossings(rust::Slice<const double> points,
                              rust::Slice<const uint32_t> triangles,
                              rust::Slice<const uint32_t> asked) {
  using Box = CGAL::Box_intersection_d::Box_with_info_d<double, 3, uint32_t>;
  const size_t count = points.size() / 3;
  std::vector<Facet> facets;
  std::vector<Box> boxes;
  for (size_t i = 0; i + 2 < triangles.size(); i += 3) {
    Facet facet;
    CGAL::Bbox_3 box;
    for (size_t j = 0; j < 3; ++j) {
      const size_t at = triangles[i + j];
      if (at >= count) throw std::out_of_range("vertex index");
      facet.corners[j] = Kernel::Point_3(points[3 * at], points[3 * at + 1], points[3 * at + 2]);
      box += facet.corners[j].bbox();
    }
    facet.has_area = !CGAL::collinear(facet.corners[0], facet.corners[1], facet.corners[2]);
    boxes.emplace_back(box, static_cast<uint32_t>(facets.size()));
    facets.push_back(facet);
  }
  std::vector<std::pair<uint32_t, uint32_t>> near;
  const auto add = [&](const Box& one, const Box& other) {
    if (one.info() != other.info()) near.push_back(std::minmax(one.info(), other.info()));
  };
  if (asked.empty()) {
    CGAL::box_self_intersection_d(boxes.begin(), boxes.end(), add);
  } else {
    std::vector<Box> some;
    for (const uint32_t triangle : asked) some.push_back(boxes.at(triangle));
    CGAL::box_intersection_d(some.begin(), some.end(), boxes.begin(), boxes.end(), add);
  }
  std::sort(near.begin(), near.end());
  near.erase(std::unique(near.begin(), near.end()), near.end());
  std::vector<char> do_cross(near.size());
  tbb::parallel_for(size_t{0}, near.size(), [&](size_t i) {
    do_cross[i] = cross(facets[near[i].first], facets[near[i].second]);
  });
  rust::Vec<uint32_t> out;
  for (size_t i = 0; i < near.size(); ++i) {
    if (!do_cross[i]) continue;
    out.push_back(near[i].first);
    out.push_back(near[i].second);
  }
  return out;
}

struct Tree::Impl {
  using Plain = CGAL::Simple_cartesian<double>;
  using Triangles = std::vector<Plain::Triangle_3>;
  using Primitive = CGAL::AABB_triangle_primitive<Plain, Triangles::const_iterator>;

  Triangles triangles;
  // Their numbers before those without area were left out.
  std::vector<uint32_t> numbers;
  CGAL::AABB_tree<CGAL::AABB_traits<Plain, Primitive>> tree;

  Impl(rust::Slice<const double> points, rust::Slice<const uint32_t> corners) {
    const size_t count = points.size() / 3;
    const auto point = [&points, count](size_t i) {
      if (i >= count) throw std::out_of_range("vertex index");
      return Plain::Point_3(points[3 * i], points[3 * i + 1], points[3 * i + 2]);
    };
    for (size_t i = 0; i + 2 < corners.size(); i += 3) {
      const Plain::Triangle_3 triangle(point(corners[i]), point(corners[i + 1]),
                                       point(corners[i + 2]));
      if (triangle.is_degenerate()) continue;
      triangles.push_back(triangle);
      numbers.push_back(static_cast<uint32_t>(i / 3));
    }
    if (triangles.empty()) throw std::invalid_argument("a mesh without area has no distances");
    tree.insert(triangles.cbegin(), triangles.cend());
    tree.build();
    tree.accelerate_distance_queries();
  }
};

Tree::Tree(std::unique_ptr<const Impl> impl) : impl_(std::move(impl)) {}

Tree::~Tree() = default;

std::unique_ptr<Tree> new_tree(rust::Slice<const double> points,
                               rust::Slice<const uint32_t> triangles) {
  return std::make_unique<Tree>(std::make_unique<const Tree::Impl>(points, triangles));
}

rust::Vec<double> distances(const Tree& tree, rust::Slice<const double> points) {
  rust::Vec<double> distances;
  distances.reserve(points.size() / 3);
  for (size_t i = 0; i + 2 < points.size(); i += 3) {
    const Tree::Impl::Plain::Point_3 point(points[i], points[i + 1], points[i + 2]);
    distances.push_back(std::sqrt(tree.impl().tree.squared_distance(point)));
  }
  return distances;
}

rust::Vec<uint32_t> nearest_triangles(const Tree& tree, rust::Slice<const double> points) {
  const Tree::Impl& impl = tree.impl();
  rust::Vec<uint32_t> numbers;
  numbers.reserve(points.size() / 3);
  for (size_t i = 0; i + 2 < points.size(); i += 3) {
    const Tree::Impl::Plain::Point_3 point(points[i], points[i + 1], points[i + 2]);
    const auto triangle = impl.tree.closest_point_and_primitive(point).second;
    numbers.push_back(impl.numbers[triangle - impl.triangles.cbegin()]);
  }
  return numbers;
}

}  // namespace transect::measure
