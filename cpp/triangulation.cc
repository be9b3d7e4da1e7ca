#include "transect/cpp/triangulation.h"

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Delaunay_mesh_face_base_2.h>
#include <CGAL/Delaunay_mesh_size_criteria_2.h>
#include <CGAL/Delaunay_mesh_vertex_base_2.h>
#include <CGAL/Delaunay_mesher_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <vector>

#include "transect/src/ffi/triangulation.rs.h"

namespace transect::triangulation {
namespace {

using Index = std::uint32_t;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Vertex = CGAL::Delaunay_mesh_vertex_base_2<Kernel>;
using Face = CGAL::Delaunay_mesh_face_base_2<Kernel>;
using Structure = CGAL::Triangulation_data_structure_2<Vertex, Face>;
// Coordinates are rounded, so constraints may cross where they should touch.
using Delaunay =
    CGAL::Constrained_Delaunay_triangulation_2<Kernel, Structure, CGAL::Exact_predicates_tag>;
using Criteria = CGAL::Delaunay_mesh_size_criteria_2<Delaunay>;
using Mesher = CGAL::Delaunay_mesher_2<Delaunay, Criteria>;
using FaceHandle = Delaunay::Face_handle;
using Point = Kernel::Point_2;

constexpr Index none = static_cast<Index>(-1);

// Angles of at least 20.7 degrees, where the input lets them: CGAL's bound
// for which refinement is known to end.
constexpr double aspect = 0.125;

struct Segment {
  Point start, end;
};

// Whether a point lies inside the closed polygons made of some segments, by
// the parity of crossings of the ray to the right.
bool inside(const Point& point, const std::vector<Segment>& segments) {
  bool odd = false;
  for (const Segment& segment : segments) {
    const bool below = segment.start.y() <= point.y();
    if (below == (segment.end.y() <= point.y())) continue;
    const auto turn = CGAL::orientation(segment.start, segment.end, point);
    if (turn == (below ? CGAL::LEFT_TURN : CGAL::RIGHT_TURN)) odd = !odd;
  }
  return odd;
}

// Faces that are connected without crossing a constraint, all finite.
std::vector<FaceHandle> component(const Delaunay& delaunay, FaceHandle first,
                                  std::map<FaceHandle, Index>& visited, Index mark) {
  std::vector<FaceHandle> faces{first};
  visited[first] = mark;
  for (std::size_t next = 0; next < faces.size(); ++next) {
    for (int side = 0; side < 3; ++side) {
      const FaceHandle other = faces[next]->neighbor(side);
      if (faces[next]->is_constrained(side) || delaunay.is_infinite(other)) continue;
      if (visited.emplace(other, mark).second) faces.push_back(other);
    }
  }
  return faces;
}

double area(const FaceHandle& face) {
  return CGAL::area(face->vertex(0)->point(), face->vertex(1)->point(), face->vertex(2)->point());
}

// A point in each connected part of each region, and the regions' numbers.
struct Seeds {
  std::vector<Point> points;
  std::vector<Index> regions;
};

Seeds seeds(const Delaunay& delaunay, const std::map<Index, std::vector<Segment>>& borders) {
  Seeds seeds;
  std::map<FaceHandle, Index> visited;
  for (auto face = delaunay.finite_faces_begin(); face != delaunay.finite_faces_end(); ++face) {
    if (visited.count(face) != 0) continue;
    const auto faces = component(delaunay, face, visited, 0);
    const auto widest = *std::max_element(
        faces.begin(), faces.end(), [](const auto& a, const auto& b) { return area(a) < area(b); });
    const Point middle = CGAL::centroid(widest->vertex(0)->point(), widest->vertex(1)->point(),
                                        widest->vertex(2)->point());
    for (const auto& [region, segments] : borders) {
      if (!inside(middle, segments)) continue;
      seeds.points.push_back(middle);
      seeds.regions.push_back(region);
      break;
    }
  }
  return seeds;
}

// Refines, but for ever only in theory: in rounded arithmetic nobody proves
// that refinement ends, and what is there after many steps serves as well.
void refine(Delaunay& delaunay, const Seeds& seeds, double spacing, std::size_t steps) {
  Mesher mesher(delaunay, Criteria(aspect, spacing));
  mesher.set_seeds(seeds.points.begin(), seeds.points.end(), true);
  mesher.init();
  for (std::size_t step = 0; step < steps && !mesher.is_refinement_done(); ++step) {
    if (!mesher.step_by_step_refine_mesh()) break;
  }
}

void write(const Delaunay& delaunay, const Seeds& seeds,
           const std::map<Delaunay::Vertex_handle, Index>& inputs, Triangulation& out) {
  std::map<Delaunay::Vertex_handle, Index> numbers;
  for (auto vertex = delaunay.finite_vertices_begin(); vertex != delaunay.finite_vertices_end();
       ++vertex) {
    numbers.emplace(vertex, static_cast<Index>(numbers.size()));
    out.points.push_back(vertex->point().x());
    out.points.push_back(vertex->point().y());
    const auto input = inputs.find(vertex);
    out.inputs.push_back(input == inputs.end() ? none : input->second);
  }
  std::map<FaceHandle, Index> visited;
  for (std::size_t seed = 0; seed < seeds.points.size(); ++seed) {
    const FaceHandle first = delaunay.locate(seeds.points[seed]);
    if (delaunay.is_infinite(first) || visited.count(first) != 0) continue;
    for (const FaceHandle& face : component(delaunay, first, visited, 0)) {
      for (int corner = 0; corner < 3; ++corner) {
        out.triangles.push_back(numbers.at(face->vertex(corner)));
      }
      out.regions.push_back(seeds.regions[seed]);
    }
  }
}

}  // namespace

Triangulation triangulate(rust::Slice<const double> points, rust::Slice<const Index> segments,
                          rust::Slice<const Index> regions, double spacing) {
  for (double number : points) {
    if (!std::isfinite(number)) throw std::invalid_argument("a coordinate is not a finite number");
  }
  Delaunay delaunay;
  std::vector<Delaunay::Vertex_handle> vertices;
  std::map<Delaunay::Vertex_handle, Index> inputs;
  for (std::size_t i = 0; i + 1 < points.size(); i += 2) {
    vertices.push_back(delaunay.insert(Point(points[i], points[i + 1])));
    inputs.emplace(vertices.back(), static_cast<Index>(i / 2));
  }
  std::map<Index, std::vector<Segment>> borders;
  for (std::size_t i = 0; i < regions.size(); ++i) {
    const auto start = vertices.at(segments[2 * i]), end = vertices.at(segments[2 * i + 1]);
    if (start == end) continue;
    delaunay.insert_constraint(start, end);
    borders[regions[i]].push_back({start->point(), end->point()});
  }
  const Seeds found = seeds(delaunay, borders);
  // Far more than any region in good order takes.
  const std::size_t steps = 100000 + 100 * regions.size();
  refine(delaunay, found, spacing, steps);
  Triangulation out;
  write(delaunay, found, inputs, out);
  return out;
}

}  // namespace transect::triangulation
