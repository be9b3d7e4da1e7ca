#include "transect/cpp/triangulation.h"

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <stdexcept>
#include <tuple>
#include <utility>
#include <vector>

#include "transect/src/ffi/triangulation.rs.h"

namespace transect::triangulation {
namespace {

using Index = std::uint32_t;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
// Coordinates are rounded, so constraints may cross where they should touch.
using Delaunay =
    CGAL::Constrained_Delaunay_triangulation_2<Kernel, CGAL::Default, CGAL::Exact_predicates_tag>;
using FaceHandle = Delaunay::Face_handle;
using Point = Kernel::Point_2;

constexpr Index none = static_cast<Index>(-1);

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

// Whether a point is nearer to a segment than a distance.
bool near(const Point& point, const Segment& segment, double distance) {
  return CGAL::squared_distance(point, Kernel::Segment_2(segment.start, segment.end)) <
         distance * distance;
}

using Borders = std::map<Index, std::vector<Segment>>;

// The points of a triangular lattice in some regions that keep half a spacing
// from all their borders, by the regions. CGAL's own refinement makes better
// angles, but adds points at the scale of the smallest detail of the borders,
// and crashes where that is near the rounding of doubles.
std::vector<Point> lattice(const Borders& borders, double spacing) {
  std::vector<Point> points;
  for (const auto& [region, segments] : borders) {
    CGAL::Bbox_2 box;
    for (const Segment& segment : segments) box += segment.start.bbox() + segment.end.bbox();
    const double height = spacing * std::sqrt(0.75);
    for (double row = std::ceil(box.ymin() / height); row * height <= box.ymax(); ++row) {
      const double shift = std::fmod(std::abs(row), 2.0) == 0 ? 0.0 : 0.5;
      for (double column = std::ceil(box.xmin() / spacing - shift);
           (column + shift) * spacing <= box.xmax(); ++column) {
        const Point point((column + shift) * spacing, row * height);
        const auto is_near = [&](const Segment& segment) {
          return near(point, segment, spacing / 2);
        };
        if (std::any_of(segments.begin(), segments.end(), is_near)) continue;
        if (inside(point, segments)) points.push_back(point);
      }
    }
  }
  return points;
}

// Faces that are connected without crossing a constraint, all finite.
std::vector<FaceHandle> component(const Delaunay& delaunay, FaceHandle first,
                                  std::set<FaceHandle>& visited) {
  std::vector<FaceHandle> faces{first};
  visited.insert(first);
  for (std::size_t next = 0; next < faces.size(); ++next) {
    for (int side = 0; side < 3; ++side) {
      const FaceHandle face = faces[next], other = face->neighbor(side);
      if (delaunay.is_constrained({face, side}) || delaunay.is_infinite(other)) continue;
      if (visited.insert(other).second) faces.push_back(other);
    }
  }
  return faces;
}

double area(const FaceHandle& face) {
  return CGAL::area(face->vertex(0)->point(), face->vertex(1)->point(), face->vertex(2)->point());
}

// Whether a face is nothing but rounding: points of a straight border that are
// not quite on a line.
bool is_needle(const FaceHandle& face) {
  double longest = 0;
  for (int side = 0; side < 3; ++side) {
    longest = std::max(longest, CGAL::squared_distance(face->vertex(side)->point(),
                                                       face->vertex((side + 1) % 3)->point()));
  }
  return area(face) <= 1e-9 * longest;
}

// The region that connected faces lie in, by the middle of the widest one.
Index region_of(const std::vector<FaceHandle>& faces, const Borders& borders) {
  const auto widest = *std::max_element(
      faces.begin(), faces.end(), [](const auto& a, const auto& b) { return area(a) < area(b); });
  if (is_needle(widest)) return none;
  const Point middle = CGAL::centroid(widest->vertex(0)->point(), widest->vertex(1)->point(),
                                      widest->vertex(2)->point());
  for (const auto& [region, segments] : borders) {
    if (inside(middle, segments)) return region;
  }
  return none;
}

void write(const Delaunay& delaunay, const Borders& borders,
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
  std::set<FaceHandle> visited;
  for (auto face = delaunay.finite_faces_begin(); face != delaunay.finite_faces_end(); ++face) {
    if (visited.count(face) != 0) continue;
    const auto faces = component(delaunay, face, visited);
    const Index region = region_of(faces, borders);
    if (region == none) continue;
    for (const FaceHandle& own : faces) {
      for (int corner = 0; corner < 3; ++corner) {
        out.triangles.push_back(numbers.at(own->vertex(corner)));
      }
      out.regions.push_back(region);
    }
  }
}

}  // namespace

Triangulation triangulate(rust::Slice<const double> points, rust::Slice<const Index> segments,
                          rust::Slice<const Index> regions, double spacing) {
  for (double number : points) {
    if (!std::isfinite(number)) throw std::invalid_argument("a coordinate is not a finite number");
  }
  const auto point = [&](Index number) {
    return Point(points[2 * number], points[2 * number + 1]);
  };
  // Of several triangulations that are Delaunay the order decides: it is that of the places,
  // so that the same regions become the same triangles, however they are numbered.
  std::vector<Index> order(points.size() / 2);
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](Index a, Index b) {
    return std::make_tuple(point(a).x(), point(a).y(), a) <
           std::make_tuple(point(b).x(), point(b).y(), b);
  });
  Delaunay delaunay;
  std::vector<Delaunay::Vertex_handle> vertices(order.size());
  std::map<Delaunay::Vertex_handle, Index> inputs;
  for (const Index number : order) {
    vertices[number] = delaunay.insert(point(number));
    inputs.emplace(vertices[number], number);
  }
  std::vector<Index> rank(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) rank[order[i]] = static_cast<Index>(i);
  Borders borders;
  std::vector<std::pair<Index, Index>> constraints;
  for (std::size_t i = 0; i < regions.size(); ++i) {
    const auto start = vertices.at(segments[2 * i]), end = vertices.at(segments[2 * i + 1]);
    if (start == end) continue;
    constraints.push_back(std::minmax(rank[segments[2 * i]], rank[segments[2 * i + 1]]));
    borders[regions[i]].push_back({start->point(), end->point()});
  }
  std::sort(constraints.begin(), constraints.end());
  for (const auto& [start, end] : constraints) {
    delaunay.insert_constraint(vertices[order[start]], vertices[order[end]]);
  }
  std::vector<Point> inner = lattice(borders, spacing);
  std::sort(inner.begin(), inner.end());
  delaunay.insert(inner.begin(), inner.end());
  Triangulation out;
  write(delaunay, borders, inputs, out);
  return out;
}

}  // namespace transect::triangulation
