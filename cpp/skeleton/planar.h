// The labels of one plane within a cell, as a triangulation.
#pragma once

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Triangulation_face_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <map>
#include <set>

#include "transect/cpp/skeleton/exact.h"

namespace transect::skeleton::partial {

// Two coordinates of the points of a plane: the one in which the normal is largest is
// dropped, and the others stand in an order that keeps the sense of rotation.
class Chart {
 public:
  Chart(const Vector& normal, const Number& offset);

  Kernel::Point_2 down(const Point& point) const { return {point[first_], point[second_]}; }
  Kernel::Vector_2 down(const Vector& way) const { return {way[first_], way[second_]}; }
  Point up(const Kernel::Point_2& point) const;

 private:
  Vector normal_;
  Number offset_;
  int first_, second_, dropped_;
};

// Lines of a plane, by what their points are joined to: in an order that does not hang on
// that of a triangulation's edges, which is that of addresses.
using Ways = std::map<Kernel::Point_2, std::set<Kernel::Point_2>>;

// A line that goes straight on from corner to corner; the one after `from` is `second`.
struct StraightLine {
  Kernel::Point_2 from, second, to;
};
std::vector<StraightLine> straight_lines(const Ways& ways);

template <class VertexInfo, class FaceInfo>
using Triangulation = CGAL::Constrained_Delaunay_triangulation_2<
    Kernel,
    CGAL::Triangulation_data_structure_2<
        CGAL::Triangulation_vertex_base_with_info_2<VertexInfo, Kernel>,
        CGAL::Triangulation_face_base_with_info_2<
            FaceInfo, Kernel, CGAL::Constrained_triangulation_face_base_2<Kernel>>>,
    CGAL::Exact_intersections_tag>;

class PlanarMap {
 public:
  // The border is a convex polygon that holds the pieces, counter-clockwise about the
  // normal.
  PlanarMap(const Plane& plane, const std::vector<Point>& border, const std::vector<Point>& points,
            const std::vector<Piece>& pieces, Label label);

  // The label at a point of the plane, or of its border; where labels meet, a little
  // further along the way.
  Label at(const Point& point, const Vector& way) const;

  // The convex polygons that known regions consist of, counter-clockwise, without
  // corners on straight edges.
  std::vector<std::vector<Point>> known() const;

  // What meets on an edge of a known polygon: labels from end to end, each but the first
  // from a point on.
  struct Along {
    std::vector<Point> changes;
    std::vector<Label> labels;
  };
  // The way leads from the edge into the polygon.
  Along along(const Point& from, const Point& to, const Vector& way) const;
  // Whether all is known on both sides of an edge of a known polygon.
  bool is_inner(const Point& from, const Point& to) const;
  // Ways from a corner of a known polygon that all others lie between, on which something is
  // known.
  std::vector<Vector> known_ways(const Point& corner) const;

 private:
  using Labels = Triangulation<Index, Label>;

  std::vector<Point> stops(const Point& from, const Point& to) const;
  void paint(const std::vector<Point>& points, const std::vector<Piece>& pieces, Label label);
  void flood();
  Labels known_outlines() const;

  Chart chart_;
  Labels labels_;
};

}  // namespace transect::skeleton::partial
