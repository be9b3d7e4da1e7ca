#include "transect/cpp/skeleton/planar.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace transect::skeleton::partial {
namespace {

constexpr Label unpainted = static_cast<Label>(-2);

using Flat = Kernel::Point_2;

int turn(const Flat& a, const Flat& b, const Flat& c) {
  return static_cast<int>(CGAL::orientation(a, b, c));
}

// Convex polygons of triangles, which are merged across their common edges as long as
// they stay convex (Hertel and Mehlhorn).
class Pieces {
 public:
  explicit Pieces(std::vector<Flat> points) : points_(std::move(points)) {}

  void add(const std::vector<Index>& loop) {
    for (std::size_t i = 0; i < loop.size(); ++i) {
      left_of_[{loop[i], loop[(i + 1) % loop.size()]}] = static_cast<Index>(loops_.size());
    }
    loops_.push_back(loop);
  }

  std::vector<std::vector<Index>> merged() {
    for (const auto& [from, to] : inner_edges()) merge(from, to);
    std::vector<std::vector<Index>> result;
    for (const std::vector<Index>& loop : loops_) {
      if (!loop.empty()) result.push_back(without_straight(loop));
    }
    return result;
  }

 private:
  using Edge = std::pair<Index, Index>;

  // Those between two polygons, the longest first.
  std::vector<Edge> inner_edges() const {
    std::vector<std::pair<double, Edge>> found;
    for (const auto& [edge, left] : left_of_) {
      if (edge.first < edge.second && left_of_.count({edge.second, edge.first})) {
        const double length =
            CGAL::to_double(CGAL::squared_distance(points_[edge.first], points_[edge.second]));
        found.push_back({-length, edge});
      }
    }
    std::sort(found.begin(), found.end());
    std::vector<Edge> edges;
    for (const auto& [length, edge] : found) edges.push_back(edge);
    return edges;
  }

  void merge(Index from, Index to) {
    const Index left = left_of_.at({from, to}), right = left_of_.at({to, from});
    if (left == right) return;
    // The left loop from `to` on to `from`, then the right one from `from` on to `to`.
    std::vector<Index> loop = started(loops_[left], to);
    const std::vector<Index> rest = started(loops_[right], from);
    loop.insert(loop.end(), rest.begin() + 1, rest.end() - 1);
    loop = without_spikes(std::move(loop));
    for (std::size_t i = 0; i < loop.size(); ++i) {
      if (bend(loop, i) < 0) return;
    }
    for (std::size_t i = 0; i < loop.size(); ++i) {
      left_of_[{loop[i], loop[(i + 1) % loop.size()]}] = left;
    }
    loops_[left] = std::move(loop);
    loops_[right].clear();
  }

  // The polygons may have had further edges in common, in line with the first one.
  static std::vector<Index> without_spikes(std::vector<Index> loop) {
    for (std::size_t i = 0; i < loop.size();) {
      const std::size_t n = loop.size(), next = (i + 1) % n;
      if (n < 3 || loop[(i + n - 1) % n] != loop[next]) {
        ++i;
        continue;
      }
      // Both the tip and what follows it, which stands before it as well.
      loop.erase(loop.begin() + std::max(i, next));
      loop.erase(loop.begin() + std::min(i, next));
      i = 0;
    }
    return loop;
  }

  static std::vector<Index> started(std::vector<Index> loop, Index first) {
    std::rotate(loop.begin(), std::find(loop.begin(), loop.end(), first), loop.end());
    return loop;
  }

  int bend(const std::vector<Index>& loop, std::size_t i) const {
    const std::size_t n = loop.size();
    return turn(points_[loop[(i + n - 1) % n]], points_[loop[i]], points_[loop[(i + 1) % n]]);
  }

  std::vector<Index> without_straight(const std::vector<Index>& loop) const {
    std::vector<Index> corners;
    for (std::size_t i = 0; i < loop.size(); ++i) {
      if (bend(loop, i) > 0) corners.push_back(loop[i]);
    }
    return corners;
  }

  std::vector<Flat> points_;
  std::vector<std::vector<Index>> loops_;  // empty: merged into another
  std::map<Edge, Index> left_of_;
};

// Whether just one straight line leads through the point.
bool passes(const Flat& point, const std::set<Flat>& ways) {
  return ways.size() == 2 && CGAL::collinear(*ways.begin(), point, *ways.rbegin());
}

}  // namespace

// Each line is met from both ends and taken from the smaller one.
std::vector<StraightLine> straight_lines(const Ways& ways) {
  std::vector<StraightLine> lines;
  for (const auto& [start, seconds] : ways) {
    if (passes(start, seconds)) continue;
    for (const Flat& second : seconds) {
      Flat last = start, next = second;
      for (auto at = ways.find(next); passes(next, at->second); at = ways.find(next)) {
        const Flat &one = *at->second.begin(), &other = *at->second.rbegin();
        const Flat further = one == last ? other : one;
        last = next;
        next = further;
      }
      if (start < next) lines.push_back({start, second, next});
    }
  }
  return lines;
}

Chart::Chart(const Vector& normal, const Number& offset) : normal_(normal), offset_(offset) {
  dropped_ = 0;
  for (int axis = 1; axis < 3; ++axis) {
    if (CGAL::abs(normal[axis]) > CGAL::abs(normal[dropped_])) dropped_ = axis;
  }
  first_ = (dropped_ + 1) % 3;
  second_ = (dropped_ + 2) % 3;
  if (normal[dropped_] < 0) std::swap(first_, second_);
}

Point Chart::up(const Kernel::Point_2& point) const {
  Number coordinates[3];
  coordinates[first_] = point.x();
  coordinates[second_] = point.y();
  coordinates[dropped_] =
      (offset_ - normal_[first_] * point.x() - normal_[second_] * point.y()) / normal_[dropped_];
  return {coordinates[0], coordinates[1], coordinates[2]};
}

PlanarMap::PlanarMap(const Plane& plane, const std::vector<Point>& border,
                     const std::vector<Point>& points, const std::vector<Piece>& pieces,
                     Label label)
    : chart_(plane.normal, plane.offset) {
  for (std::size_t i = 0; i < border.size(); ++i) {
    labels_.insert_constraint(chart_.down(border[i]), chart_.down(border[(i + 1) % border.size()]));
  }
  for (const Piece& piece : pieces) {
    labels_.insert_constraint(chart_.down(points[piece.from]), chart_.down(points[piece.to]));
  }
  paint(points, pieces, label);
}

// Every region has a piece on its border, unless there is no piece at all.
void PlanarMap::paint(const std::vector<Point>& points, const std::vector<Piece>& pieces,
                      Label label) {
  for (auto face : labels_.all_face_handles()) {
    face->info() = pieces.empty() ? label : unpainted;
  }
  std::map<Flat, Labels::Vertex_handle> vertices;
  for (auto vertex : labels_.finite_vertex_handles()) vertices[vertex->point()] = vertex;
  for (const Piece& piece : pieces) {
    const auto from = vertices.at(chart_.down(points[piece.from]));
    const auto to = vertices.at(chart_.down(points[piece.to]));
    // The piece may be split where another one ends on it.
    for (auto at = from; at != to;) {
      Labels::Vertex_handle next;
      Labels::Face_handle right;
      int index;
      labels_.includes_edge(at, to, next, right, index);
      right->info() = piece.right;
      right->neighbor(index)->info() = piece.left;
      at = next;
    }
  }
  flood();
}

void PlanarMap::flood() {
  std::vector<Labels::Face_handle> fresh;
  for (auto face : labels_.finite_face_handles()) {
    if (face->info() != unpainted) fresh.push_back(face);
  }
  while (!fresh.empty()) {
    const auto face = fresh.back();
    fresh.pop_back();
    for (int i = 0; i < 3; ++i) {
      const auto next = face->neighbor(i);
      if (face->is_constrained(i) || labels_.is_infinite(next) || next->info() != unpainted) {
        continue;
      }
      next->info() = face->info();
      fresh.push_back(next);
    }
  }
}

Label PlanarMap::at(const Point& point, const Vector& way) const {
  const Flat here = chart_.down(point);
  const Kernel::Vector_2 on = chart_.down(way);
  Labels::Locate_type type;
  int index;
  const auto face = labels_.locate(here, type, index);
  if (type == Labels::FACE) return face->info();
  if (type == Labels::EDGE) {
    const Flat& a = face->vertex(labels_.ccw(index))->point();
    const Flat& b = face->vertex(labels_.cw(index))->point();
    const auto other = face->neighbor(index);
    const bool inside = CGAL::orientation(b - a, on) != CGAL::RIGHT_TURN;
    const bool use = labels_.is_infinite(other) || (inside && !labels_.is_infinite(face));
    return (use ? face : other)->info();
  }
  // At a vertex: the face whose corner the way points into.
  auto around = labels_.incident_faces(face->vertex(index)), first = around;
  Label label = unknown;
  do {
    if (labels_.is_infinite(around)) continue;
    const int own = around->index(face->vertex(index));
    const Flat& a = around->vertex(labels_.ccw(own))->point();
    const Flat& b = around->vertex(labels_.cw(own))->point();
    label = around->info();
    if (CGAL::orientation(a - here, on) != CGAL::RIGHT_TURN &&
        CGAL::orientation(on, b - here) != CGAL::RIGHT_TURN) {
      break;
    }
  } while (++around != first);
  return label;
}

// A triangulation of the lines between known and unknown alone, so that contours divide
// no polygon.
PlanarMap::Labels PlanarMap::known_outlines() const {
  const auto is_known = [&](Labels::Face_handle face) {
    return !labels_.is_infinite(face) && face->info() != unknown;
  };
  Ways ways;
  for (const auto& [face, index] : labels_.finite_edges()) {
    if (is_known(face) == is_known(face->neighbor(index))) continue;
    const Flat& a = face->vertex(labels_.ccw(index))->point();
    const Flat& b = face->vertex(labels_.cw(index))->point();
    ways[a].insert(b);
    ways[b].insert(a);
  }
  Labels outlines;
  for (const StraightLine& line : straight_lines(ways)) {
    outlines.insert_constraint(line.from, line.to);
  }
  return outlines;
}

std::vector<std::vector<Point>> PlanarMap::known() const {
  const Labels outlines = known_outlines();
  std::map<Labels::Vertex_handle, Index> names;
  std::vector<Flat> points;
  for (auto vertex : outlines.finite_vertex_handles()) {
    names[vertex] = static_cast<Index>(points.size());
    points.push_back(vertex->point());
  }
  Pieces pieces(points);
  for (auto face : outlines.finite_face_handles()) {
    const auto corner = [&](int i) { return face->vertex(i); };
    const Flat inside = CGAL::centroid(corner(0)->point(), corner(1)->point(), corner(2)->point());
    if (at(chart_.up(inside), CGAL::NULL_VECTOR) == unknown) continue;
    pieces.add({names[corner(0)], names[corner(1)], names[corner(2)]});
  }
  std::vector<std::vector<Point>> polygons;
  for (const std::vector<Index>& loop : pieces.merged()) {
    polygons.emplace_back();
    for (Index corner : loop) polygons.back().push_back(chart_.up(points[corner]));
  }
  return polygons;
}

// The points on an edge, from end to end.
std::vector<Point> PlanarMap::stops(const Point& from, const Point& to) const {
  std::vector<Point> stops{from, to};
  const Kernel::Segment_2 edge(chart_.down(from), chart_.down(to));
  for (auto vertex : labels_.finite_vertex_handles()) {
    const Flat& point = vertex->point();
    if (point != edge.source() && point != edge.target() && edge.has_on(point)) {
      stops.push_back(chart_.up(point));
    }
  }
  const Vector length = to - from;
  std::sort(stops.begin(), stops.end(), [&](const Point& a, const Point& b) {
    return length * (a - from) < length * (b - from);
  });
  return stops;
}

bool PlanarMap::is_inner(const Point& from, const Point& to) const {
  const std::vector<Point> stops = this->stops(from, to);
  for (std::size_t i = 0; i + 1 < stops.size(); ++i) {
    Labels::Locate_type type;
    int index;
    const auto face =
        labels_.locate(chart_.down(CGAL::midpoint(stops[i], stops[i + 1])), type, index);
    if (type == Labels::FACE) continue;
    const auto other = face->neighbor(index);
    if (labels_.is_infinite(face) || labels_.is_infinite(other) || face->info() == unknown ||
        other->info() == unknown) {
      return false;
    }
  }
  return true;
}

std::vector<Vector> PlanarMap::known_ways(const Point& corner) const {
  Labels::Locate_type type;
  int index;
  const auto face = labels_.locate(chart_.down(corner), type, index);
  std::vector<Vector> ways;
  if (type != Labels::VERTEX) return ways;
  const auto vertex = face->vertex(index);
  auto around = labels_.incident_faces(vertex), first = around;
  do {
    if (labels_.is_infinite(around) || around->info() == unknown) continue;
    const int own = around->index(vertex);
    for (int other : {labels_.ccw(own), labels_.cw(own)}) {
      ways.push_back(chart_.up(around->vertex(other)->point()) - corner);
    }
  } while (++around != first);
  return ways;
}

PlanarMap::Along PlanarMap::along(const Point& from, const Point& to, const Vector& way) const {
  const std::vector<Point> stops = this->stops(from, to);
  Along along;
  for (std::size_t i = 0; i + 1 < stops.size(); ++i) {
    const Label label = at(CGAL::midpoint(stops[i], stops[i + 1]), way);
    if (!along.labels.empty() && along.labels.back() == label) continue;
    if (!along.labels.empty()) along.changes.push_back(stops[i]);
    along.labels.push_back(label);
  }
  return along;
}

}  // namespace transect::skeleton::partial
