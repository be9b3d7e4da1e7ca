#include "transect/cpp/skeleton/sheets.h"

#include <CGAL/Constrained_triangulation_plus_2.h>

#include <algorithm>
#include <set>
#include <utility>

namespace transect::skeleton::partial {
namespace {

using Flat = Kernel::Point_2;
// Faces know their region, vertices what became of them.
using Mesh = CGAL::Constrained_triangulation_plus_2<Triangulation<Index, Index>>;
using Vertex = Mesh::Vertex_handle;
using Face = Mesh::Face_handle;

Chart chart(const Kernel::Plane_3& plane) { return {plane.orthogonal_vector(), -plane.d()}; }

// Numbers the parts that constraints divide the plane into; returns one face of each.
// The part outside is the first one. Without triangles there is none: the face of nothing has
// no neighbours, and what it is said to be is anything.
std::vector<Face> number_regions(Mesh& mesh) {
  if (mesh.dimension() < 2) return {};
  for (Face face : mesh.all_face_handles()) face->info() = none;
  std::vector<Face> first;
  const auto spread = [&](Face start) {
    if (start->info() != none) return;
    const Index region = static_cast<Index>(first.size());
    first.push_back(start);
    std::vector<Face> fresh{start};
    start->info() = region;
    while (!fresh.empty()) {
      const Face face = fresh.back();
      fresh.pop_back();
      for (int i = 0; i < 3; ++i) {
        if (face->is_constrained(i) || face->neighbor(i)->info() != none) continue;
        face->neighbor(i)->info() = region;
        fresh.push_back(face->neighbor(i));
      }
    }
  };
  spread(mesh.infinite_face());
  for (Face face : mesh.finite_face_handles()) spread(face);
  return first;
}

// Overlays tiles and follows the lines between different sides.
class Overlay {
 public:
  Overlay(const Kernel::Plane_3& plane, const std::vector<Tile>& tiles) : chart_(chart(plane)) {
    for (const Tile& tile : tiles) {
      outlines_.emplace_back();
      boxes_.emplace_back();
      for (const Point& corner : tile.polygon) {
        outlines_.back().push_back(chart_.down(corner));
        boxes_.back() += outlines_.back().back().bbox();
      }
      insert(outlines_.back());
      for (const Polygon& line : tile.lines) insert({chart_.down(line[0]), chart_.down(line[1])});
    }
    const std::vector<Face> regions = number_regions(mesh_);
    sides_.resize(regions.size());
    for (std::size_t i = 1; i < regions.size(); ++i) sides_[i] = sides(tiles, regions[i]);
  }

  std::vector<Seam> seams() const {
    Ways ways;
    for (const auto& edge : mesh_.constrained_edges()) {
      if (left(edge) == right(edge)) continue;
      const auto [from, to] = ends(edge);
      ways[from->point()].insert(to->point());
      ways[to->point()].insert(from->point());
    }
    std::map<Flat, Vertex> vertices;
    for (Vertex vertex : mesh_.finite_vertex_handles()) vertices[vertex->point()] = vertex;
    std::vector<Seam> seams;
    for (const StraightLine& line : straight_lines(ways)) {
      seams.push_back(seam(line, vertices.at(line.from), vertices.at(line.second)));
    }
    return seams;
  }

 private:
  using Edge = Mesh::Edge;

  void insert(const std::vector<Flat>& loop) {
    for (std::size_t i = 0; i + (loop.size() == 2) < loop.size(); ++i) {
      mesh_.insert_constraint(loop[i], loop[(i + 1) % loop.size()]);
    }
  }

  std::optional<Sides> sides(const std::vector<Tile>& tiles, Face face) const {
    const Flat inside = CGAL::centroid(face->vertex(0)->point(), face->vertex(1)->point(),
                                       face->vertex(2)->point());
    const CGAL::Bbox_2 box = inside.bbox();
    for (std::size_t i = 0; i < tiles.size(); ++i) {
      if (!CGAL::do_overlap(boxes_[i], box) || !holds(outlines_[i], inside)) continue;
      const Sides found = tiles[i].sides(chart_.up(inside));
      return found.back == found.front ? std::nullopt : std::optional<Sides>(found);
    }
    return {};
  }

  static bool holds(const std::vector<Flat>& outline, const Flat& point) {
    for (std::size_t i = 0; i < outline.size(); ++i) {
      if (!CGAL::left_turn(outline[i], outline[(i + 1) % outline.size()], point)) return false;
    }
    return true;
  }

  static std::pair<Vertex, Vertex> ends(const Edge& edge) {
    return {edge.first->vertex(Mesh::ccw(edge.second)), edge.first->vertex(Mesh::cw(edge.second))};
  }
  const std::optional<Sides>& left(const Edge& edge) const { return sides_[edge.first->info()]; }
  const std::optional<Sides>& right(const Edge& edge) const {
    return sides_[edge.first->neighbor(edge.second)->info()];
  }

  // Sides are the same all along the line.
  Seam seam(const StraightLine& line, Vertex from, Vertex second) const {
    Face face;
    int index;
    mesh_.is_edge(from, second, face, index);
    const Edge edge(face, index);
    const bool along = ends(edge).first == from;
    const auto &on_left = along ? left(edge) : right(edge),
               &on_right = along ? right(edge) : left(edge);
    Seam seam{chart_.up(line.from), chart_.up(line.to), on_left, on_right};
    CGAL::exact(seam.from);
    CGAL::exact(seam.to);
    return seam;
  }

  Chart chart_;
  Mesh mesh_;
  std::vector<std::vector<Flat>> outlines_;  // of tiles
  std::vector<CGAL::Bbox_2> boxes_;          // of outlines
  std::vector<std::optional<Sides>> sides_;  // by region
};

}  // namespace

bool Sides::operator==(const Sides& other) const {
  return back == other.back && front == other.front && kind == other.kind &&
         planes[0] == other.planes[0] && planes[1] == other.planes[1];
}

PlaneName plane_name(const Halfspace& plane) {
  const auto whole = plane.coefficients();
  std::size_t lead = 0;
  while (*whole[lead] == 0) ++lead;
  PlaneName name{{}, *whole[lead] < 0};
  for (std::size_t i = 0; i < whole.size(); ++i) {
    name.key[i] = name.flipped ? mpz_class(-*whole[i]) : *whole[i];
  }
  return name;
}

std::vector<Seam> seams(const Kernel::Plane_3& plane, const std::vector<Tile>& tiles) {
  return Overlay(plane, tiles).seams();
}

PointNames::PointNames(const std::vector<Point>& points) : points_(points) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    names_.emplace(points[i], static_cast<Index>(i));
  }
}

Index PointNames::name(const Point& point) {
  const auto [at, fresh] = names_.try_emplace(point, static_cast<Index>(points_.size()));
  if (fresh) points_.push_back(point);
  return at->second;
}

PointIndex::PointIndex(const std::vector<Point>& points) : points_(points) {
  for (int axis = 0; axis < 3; ++axis) {
    width_[axis] = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto [low, high] = CGAL::to_interval(points[i][axis]);
      sorted_[axis].push_back({low, high, static_cast<Index>(i)});
      width_[axis] = std::max(width_[axis], high - low);
    }
    std::sort(sorted_[axis].begin(), sorted_[axis].end(),
              [](const Entry& a, const Entry& b) { return a.low < b.low; });
  }
}

std::vector<Point> PointIndex::between(const Point& from, const Point& to) const {
  using Iterator = std::vector<Entry>::const_iterator;
  const CGAL::Bbox_3 box = from.bbox() + to.bbox();
  Iterator first, last;
  for (int axis = 0; axis < 3; ++axis) {
    const auto before = [](const Entry& entry, double at) { return entry.low < at; };
    const auto& all = sorted_[axis];
    const Iterator low =
        std::lower_bound(all.begin(), all.end(), box.min(axis) - 2 * width_[axis], before);
    const Iterator high =
        std::upper_bound(low, all.end(), box.max(axis),
                         [](double at, const Entry& entry) { return at < entry.low; });
    if (axis == 0 || high - low < last - first) {
      first = low;
      last = high;
    }
  }
  const Kernel::Segment_3 segment(from, to);
  std::vector<Point> found;
  for (; first != last; ++first) {
    const Point& point = points_[first->point];
    if (!CGAL::do_overlap(point.bbox(), box) || !segment.has_on(point)) continue;
    if (point != from && point != to) found.push_back(point);
  }
  const Vector along = to - from;
  std::sort(found.begin(), found.end(), [&](const Point& a, const Point& b) {
    return along * (a - from) < along * (b - from);
  });
  return found;
}

std::vector<Triangle> triangulate(const Kernel::Plane_3& plane, const std::vector<Seam>& seams,
                                  const PointIndex& index, const PointNames& names) {
  const Chart flat = chart(plane);
  Mesh mesh;
  const auto vertex = [&](const Point& point) {
    const Vertex at = mesh.insert(flat.down(point));
    at->info() = names.at(point);
    return at;
  };
  // What is to the left of an edge.
  std::map<std::pair<Vertex, Vertex>, std::optional<Sides>> left;
  for (const Seam& seam : seams) {
    std::vector<Point> stops = index.between(seam.from, seam.to);
    stops.push_back(seam.to);
    Vertex from = vertex(seam.from);
    for (const Point& stop : stops) {
      const Vertex to = vertex(stop);
      mesh.insert_constraint(from, to);
      left[{from, to}] = seam.left;
      left[{to, from}] = seam.right;
      from = to;
    }
  }
  std::vector<std::optional<Sides>> sides(number_regions(mesh).size());
  for (Face face : mesh.finite_face_handles()) {
    for (int i = 0; i < 3; ++i) {
      const auto at = left.find({face->vertex(Mesh::ccw(i)), face->vertex(Mesh::cw(i))});
      if (at != left.end()) sides[face->info()] = at->second;
    }
  }
  std::vector<Triangle> triangles;
  for (Face face : mesh.finite_face_handles()) {
    if (const auto& at = sides[face->info()]) {
      triangles.push_back(
          {{face->vertex(0)->info(), face->vertex(1)->info(), face->vertex(2)->info()},
           at->back,
           at->front,
           at->kind,
           {at->planes[0], at->planes[1]}});
    }
  }
  return triangles;
}

}  // namespace transect::skeleton::partial
