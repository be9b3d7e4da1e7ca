#include "transect/cpp/partition.h"

#include <CGAL/Arr_consolidated_curve_data_traits_2.h>
#include <CGAL/Arr_extended_dcel.h>
#include <CGAL/Arr_segment_traits_2.h>
#include <CGAL/Arrangement_2.h>
#include <CGAL/Exact_predicates_exact_constructions_kernel.h>

#include <map>
#include <stdexcept>
#include <utility>
#include <vector>

#include "transect/src/ffi/partition.rs.h"

namespace transect::partition {

namespace {

using Index = std::uint32_t;
using Kernel = CGAL::Exact_predicates_exact_constructions_kernel;
using Segments = CGAL::Arr_segment_traits_2<Kernel>;
using Traits = CGAL::Arr_consolidated_curve_data_traits_2<Segments, Index>;
using Dcel = CGAL::Arr_extended_dcel<Traits, Index, Index, Index>;
using Arrangement = CGAL::Arrangement_2<Traits, Dcel>;
using Halfedge = Arrangement::Halfedge_handle;

constexpr Index none = static_cast<Index>(-1);

// Input points by their coordinates, which are doubles.
using Lookup = std::map<std::pair<double, double>, Index>;

Lookup lookup(rust::Slice<const double> points) {
  Lookup found;
  for (std::size_t i = 0; i + 1 < points.size(); i += 2)
    found.emplace(std::make_pair(points[i], points[i + 1]), static_cast<Index>(i / 2));
  return found;
}

Arrangement arrange(rust::Slice<const double> points, rust::Slice<const Index> segments) {
  std::vector<Kernel::Point_2> corners;
  corners.reserve(points.size() / 2);
  for (std::size_t i = 0; i + 1 < points.size(); i += 2)
    corners.emplace_back(points[i], points[i + 1]);
  std::vector<Traits::Curve_2> curves;
  curves.reserve(segments.size() / 2);
  for (std::size_t i = 0; i + 1 < segments.size(); i += 2) {
    if (segments[i] >= corners.size() || segments[i + 1] >= corners.size())
      throw std::out_of_range("a segment of the partition has no such point");
    const Segments::Curve_2 segment(corners[segments[i]], corners[segments[i + 1]]);
    curves.emplace_back(segment, static_cast<Index>(i / 2));
  }
  Arrangement arrangement;
  CGAL::insert(arrangement, curves.begin(), curves.end());
  return arrangement;
}

// The input point at an exact point, which is rounded on the way.
Index rounded(const Kernel::Point_2& point, const Lookup& inputs, double& x, double& y) {
  const auto& near = CGAL::approx(point);
  if (near.x().is_point() && near.y().is_point()) {  // a double: no need for rationals
    x = near.x().inf();
    y = near.y().inf();
    const auto found = inputs.find({x, y});
    return found == inputs.end() ? none : found->second;
  }
  const auto& exact = CGAL::exact(point);
  x = CGAL::to_double(exact.x());
  y = CGAL::to_double(exact.y());
  const auto found = inputs.find({x, y});
  return found != inputs.end() && exact.x() == x && exact.y() == y ? found->second : none;
}

void write_vertices(Arrangement& arrangement, const Lookup& inputs, Partition& out) {
  Index count = 0;
  for (auto vertex = arrangement.vertices_begin(); vertex != arrangement.vertices_end(); ++vertex) {
    double x = 0, y = 0;
    out.inputs.push_back(rounded(vertex->point(), inputs, x, y));
    out.points.push_back(x);
    out.points.push_back(y);
    vertex->set_data(count++);
  }
}

// Faces by number; the unbounded one is 0.
void number_faces(Arrangement& arrangement, Partition& out) {
  out.faces = 1;
  for (auto face = arrangement.faces_begin(); face != arrangement.faces_end(); ++face)
    face->set_data(face->is_unbounded() ? 0 : out.faces++);
}

void write_edges(Arrangement& arrangement, Partition& out) {
  Index count = 0;
  for (auto edge = arrangement.edges_begin(); edge != arrangement.edges_end(); ++edge, ++count) {
    const bool forward = edge->direction() == CGAL::ARR_LEFT_TO_RIGHT;
    const Halfedge along = forward ? Halfedge(edge) : edge->twin();
    along->set_data(2 * count);
    along->twin()->set_data(2 * count + 1);
    out.edges.push_back(along->source()->data());
    out.edges.push_back(along->target()->data());
    out.edges.push_back(along->face()->data());
    out.edges.push_back(along->twin()->face()->data());
    for (const Index segment : edge->curve().data()) out.covers.push_back(segment);
    out.cover_ends.push_back(static_cast<Index>(out.covers.size()));
  }
}

void write_walk(Arrangement::Ccb_halfedge_circulator start, bool outer, Partition& out) {
  auto halfedge = start;
  do {
    out.walks.push_back(halfedge->data());
  } while (++halfedge != start);
  out.walk_ends.push_back(static_cast<Index>(out.walks.size()));
  out.walk_faces.push_back(start->face()->data());
  out.walk_outer.push_back(outer);
}

void write_walks(Arrangement& arrangement, Partition& out) {
  for (auto face = arrangement.faces_begin(); face != arrangement.faces_end(); ++face) {
    for (auto walk = face->outer_ccbs_begin(); walk != face->outer_ccbs_end(); ++walk)
      write_walk(*walk, true, out);
    for (auto walk = face->inner_ccbs_begin(); walk != face->inner_ccbs_end(); ++walk)
      write_walk(*walk, false, out);
  }
}

}  // namespace

Partition partition(rust::Slice<const double> points, rust::Slice<const Index> segments) {
  Arrangement arrangement = arrange(points, segments);
  Partition out{};
  write_vertices(arrangement, lookup(points), out);
  number_faces(arrangement, out);
  write_edges(arrangement, out);
  write_walks(arrangement, out);
  return out;
}

}  // namespace transect::partition
