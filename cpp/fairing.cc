#include "transect/cpp/fairing.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/remesh.h>
#include <CGAL/Surface_mesh.h>

#include <limits>
#include <stdexcept>
#include <vector>

#include "transect/src/ffi/fairing.rs.h"

namespace transect::fairing {

namespace {

namespace PMP = CGAL::Polygon_mesh_processing;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Polyhedron = CGAL::Surface_mesh<Kernel::Point_3>;
using Vertex = Polyhedron::Vertex_index;
// The number of an input vertex, or that of none.
using Origins = Polyhedron::Property_map<Vertex, uint32_t>;

constexpr uint32_t kNew = std::numeric_limits<uint32_t>::max();

// Whether the triangles make a manifold.
bool add_triangles(Polyhedron& mesh, rust::Slice<const uint32_t> triangles) {
  const size_t count = mesh.number_of_vertices();
  for (size_t i = 0; i + 2 < triangles.size(); i += 3) {
    const uint32_t a = triangles[i], b = triangles[i + 1], c = triangles[i + 2];
    if (a >= count || b >= count || c >= count) throw std::out_of_range("vertex index");
    const auto face = mesh.add_face(Vertex(a), Vertex(b), Vertex(c));
    if (face == Polyhedron::null_face()) return false;
  }
  return true;
}

// Whether any triangle has an area; without one there is nothing to project on.
bool has_area(const Polyhedron& mesh) {
  for (const auto face : mesh.faces()) {
    const auto h = mesh.halfedge(face);
    const auto& a = mesh.point(mesh.source(h));
    const auto& b = mesh.point(mesh.target(h));
    const auto& c = mesh.point(mesh.target(mesh.next(h)));
    if (!CGAL::collinear(a, b, c)) return true;
  }
  return false;
}

// The vertices that triangles have, in their order, and the triangles.
Patch to_patch(const Polyhedron& mesh, const Origins& origins) {
  Patch patch;
  std::vector<uint32_t> numbers(mesh.num_vertices(), kNew);
  for (const Vertex vertex : mesh.vertices()) {
    if (mesh.is_isolated(vertex)) continue;
    numbers[vertex] = static_cast<uint32_t>(patch.origins.size());
    patch.origins.push_back(origins[vertex]);
    for (int axis = 0; axis < 3; ++axis) patch.points.push_back(mesh.point(vertex)[axis]);
  }
  for (const auto face : mesh.faces()) {
    for (const Vertex vertex : mesh.vertices_around_face(mesh.halfedge(face))) {
      patch.triangles.push_back(numbers[vertex]);
    }
  }
  return patch;
}

}  // namespace

Patch remesh(rust::Slice<const double> points, rust::Slice<const uint32_t> triangles,
             rust::Slice<const uint8_t> pinned, double edge_length, uint32_t iterations) {
  Polyhedron mesh;
  Origins origins = mesh.add_property_map<Vertex, uint32_t>("v:origin", kNew).first;
  auto is_pinned = mesh.add_property_map<Vertex, bool>("v:pinned", false).first;
  for (size_t i = 0; i + 2 < points.size(); i += 3) {
    const Vertex vertex = mesh.add_vertex(Kernel::Point_3(points[i], points[i + 1], points[i + 2]));
    origins[vertex] = static_cast<uint32_t>(i / 3);
    is_pinned[vertex] = pinned.at(i / 3) != 0;
  }
  if (!add_triangles(mesh, triangles) || !has_area(mesh)) return Patch();
  // No relaxation: CGAL 5.5 reads a halfedge that is none where all triangles
  // around a vertex come to have no area. Smoothing does as much.
  PMP::isotropic_remeshing(mesh.faces(), edge_length, mesh,
                           CGAL::parameters::number_of_iterations(iterations)
                               .number_of_relaxation_steps(0)
                               .vertex_is_constrained_map(is_pinned)
                               .protect_constraints(true));
  return to_patch(mesh, origins);
}

}  // namespace transect::fairing
