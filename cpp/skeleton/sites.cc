#include "transect/cpp/skeleton/sites.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <stdexcept>

namespace transect::skeleton::partial {
namespace {

std::vector<Point> corners(const PartialCell& cell, const CellPlane& wall) {
  std::vector<Point> result;
  for (Index corner : wall.corners) result.push_back(cell.points[corner]);
  return result;
}

// The side of a wall on which the cell is not.
Halfspace beyond(const PartialCell& cell, const CellPlane& wall) {
  const Plane& plane = (*cell.planes)[wall.plane];
  const Vector out = plane.normal * Number(-wall.side);
  return Kernel::Plane_3(out.x(), out.y(), out.z(), plane.offset * wall.side);
}

// The part of a plane within the cell, counter-clockwise about the plane's normal.
std::vector<Point> border(const PartialCell& cell, const CellPlane& patch) {
  std::vector<Halfspace> halfspaces;
  Polytope inside = body(cell, halfspaces);
  const Plane& plane = (*cell.planes)[patch.plane];
  const Halfspace behind(
      Kernel::Plane_3(plane.normal.x(), plane.normal.y(), plane.normal.z(), -plane.offset));
  const Polytope::Sides sides = inside.sides(behind);
  if (!sides.behind || !sides.front) {
    throw std::invalid_argument("a partial section does not cut its cell");
  }
  inside.clip(behind);
  return inside.polygon(inside.facets.back());
}

std::shared_ptr<const Face> face(const PartialCell& cell, const CellPlane& on,
                                 const std::vector<Point>& border) {
  std::vector<Segment> segments;
  std::vector<CGAL::Bbox_3> boxes;
  for (const Piece& piece : on.pieces) {
    if (piece.left == piece.right || piece.left == unknown || piece.right == unknown) continue;
    segments.push_back({cell.points[piece.from], cell.points[piece.to], piece.left, piece.right});
    boxes.push_back(segments.back().from.bbox() + segments.back().to.bbox());
  }
  const Plane& plane = (*cell.planes)[on.plane];
  PlanarMap map(plane, border, cell.points, on.pieces, on.label);
  return std::make_shared<Face>(
      Face{on.plane, std::move(segments), std::move(boxes), std::move(map)});
}

// The part of a polygon on the inner side of one of a box's six faces.
std::vector<Place> clipped(const std::vector<Place>& polygon, const CGAL::Bbox_3& box, int face) {
  const int axis = face / 2;
  const auto inside = [&](const Place& p) {
    return face % 2 ? box.max(axis) - p[axis] : p[axis] - box.min(axis);
  };
  std::vector<Place> kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const auto &from = polygon[i], &to = polygon[(i + 1) % polygon.size()];
    const double a = inside(from), b = inside(to);
    if (a >= 0) kept.push_back(from);
    if ((a >= 0) == (b >= 0)) continue;
    Place crossing;
    for (int k = 0; k < 3; ++k) crossing[k] = from[k] + a / (a - b) * (to[k] - from[k]);
    kept.push_back(crossing);
  }
  return kept;
}

// Whether a convex polygon is not much wider than rounding errors of what is in the box.
bool is_narrow(const std::vector<Place>& polygon, const CGAL::Bbox_3& box) {
  double size = 0, area = 0, length = 0;
  for (int i = 0; i < 3; ++i) size = std::max({size, std::abs(box.min(i)), std::abs(box.max(i))});
  const auto& o = polygon[0];
  for (std::size_t i = 1; i < polygon.size(); ++i) {
    const auto &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
    const double a[3] = {p[0] - o[0], p[1] - o[1], p[2] - o[2]};
    const double b[3] = {q[0] - o[0], q[1] - o[1], q[2] - o[2]};
    area +=
        std::hypot(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]);
    length = std::max(length, std::hypot(a[0], a[1], a[2]));
  }
  return area < 1e-10 * size * length;
}

// The part of a convex polygon in a box.
std::vector<Place> within_box(const std::vector<Point>& polygon, const CGAL::Bbox_3& box) {
  std::vector<Place> left;
  for (const Point& corner : polygon) left.push_back(rough_place(corner));
  for (int side = 0; side < 6 && !left.empty(); ++side) left = clipped(left, box, side);
  return left;
}

Point middle(const std::vector<Place>& polygon) {
  double sum[3] = {0, 0, 0};
  for (const auto& corner : polygon) {
    for (int i = 0; i < 3; ++i) sum[i] += corner[i] / static_cast<double>(polygon.size());
  }
  return {sum[0], sum[1], sum[2]};
}

// Around all feet on a face, and more than rounding errors.
CGAL::Bbox_3 around_feet(const Zone& zone, const Rough& distance,
                         const std::vector<Place>& places) {
  const Place ray = rough_place(CGAL::ORIGIN + zone.rays[0]);
  std::vector<Place> feet;
  for (const Place& place : places) {
    const double height = distance.at(place).first;
    feet.push_back(
        {place[0] - ray[0] * height, place[1] - ray[1] * height, place[2] - ray[2] * height});
  }
  const CGAL::Bbox_3 box = bounds(feet);
  double size = 0;
  for (int i = 0; i < 3; ++i) size = std::max({size, std::abs(box.min(i)), std::abs(box.max(i))});
  const double slack = 1e-9 * size;
  return {box.xmin() - slack, box.ymin() - slack, box.zmin() - slack,
          box.xmax() + slack, box.ymax() + slack, box.zmax() + slack};
}

// Labels change across planes that are parallel to those of both rays.
Shown shown_on_edge(const Zone& zone, const std::vector<Place>& places) {
  const auto& [stops, labels] = zone.labels;
  if (stops.empty()) return {false, labels[0]};
  const Vector along = zone.foot[1] - zone.foot[0];
  Vector across = CGAL::cross_product(zone.rays[0], zone.rays[1]);
  if (across * along < 0) across = -across;
  const Rough past(Linear{across, 0});
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Place& place : places) {
    const auto [value, error] = past.at(place);
    low = std::min(low, value - error);
    high = std::max(high, value + error);
  }
  Shown all;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (i > 0) {
      const auto [value, error] = past.at(rough_place(stops[i - 1]));
      if (value - error > high) break;
    }
    if (i < stops.size()) {
      const auto [value, error] = past.at(rough_place(stops[i]));
      if (value + error < low) continue;
    }
    all.add(labels[i]);
  }
  return all;
}

// The zones around one site.
class Zones {
 public:
  Zones(const Gauge& gauge, const std::vector<Point>& corners, const Vector& normal)
      : gauge_(gauge), corners_(corners), normal_(normal) {}

  // Labels of edges and corners are those just inside the polygon.
  void read(const PlanarMap& map) {
    const Point inside = CGAL::centroid(corners_[0], corners_[1], corners_[2]);
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      on_edge_.push_back(map.along(corner(i), corner(i + 1), inside - corner(i)));
      is_inner_.push_back(map.is_inner(corner(i), corner(i + 1)));
      at_corner_.push_back({{}, {map.at(corner(i), inside - corner(i))}});
      known_ways_.push_back(map.known_ways(corner(i)));
    }
  }

  Zone prism(int side) const {
    const Vector ray = gauge_.farthest(normal_ * side);
    const Vector u = normal_ * side / (normal_ * side * ray);
    return {through(u, corners_[0]), corners_, {ray, ray}, {}};
  }

  std::vector<Zone> both_sides() const { return {prism(1), prism(-1)}; }

  void add_outline(std::vector<std::array<Place, 2>>& outline) const {
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      if (!is_inner_[i]) outline.push_back({rough_place(corner(i)), rough_place(corner(i + 1))});
    }
  }

  std::vector<Zone> all() const {
    std::vector<Zone> zones = both_sides();
    for (const Gauge::Facet& facet : gauge_.facets) zones.push_back(on_facet(facet));
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      for (const Gauge::Edge& edge : gauge_.edges) {
        if (auto zone = on_edges(i, edge)) zones.push_back(*zone);
      }
    }
    return zones;
  }

 private:
  static Linear through(const Vector& u, const Point& p) {
    Linear distance{u, u * (p - CGAL::ORIGIN)};
    CGAL::exact(distance.u);
    CGAL::exact(distance.c);
    return distance;
  }

  const Point& corner(std::size_t i) const { return corners_[i % corners_.size()]; }

  // Around a corner, or an edge that is parallel to the facet.
  Zone on_facet(const Gauge::Facet& facet) const {
    std::size_t best = 0;
    for (std::size_t i = 1; i < corners_.size(); ++i) {
      if (facet.polar * (corners_[i] - corners_[best]) > 0) best = i;
    }
    const Linear distance = through(facet.polar, corners_[best]);
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      if (distance.at(corner(i)) == 0 && distance.at(corner(i + 1)) == 0) {
        return parallel(distance, facet, i);
      }
    }
    const Vector& ray = gauge_.corners[facet.corners[0]];
    const bool is_inner = std::any_of(known_ways_[best].begin(), known_ways_[best].end(),
                                      [&](const Vector& way) { return facet.polar * way > 0; });
    return {distance, {corners_[best]}, {ray, ray}, at_corner_[best], is_inner};
  }

  // Feet follow the facet's corners that are farthest away from the edge to both sides;
  // of two such on a side, the first one, which the facet next to it takes too.
  Zone parallel(const Linear& distance, const Gauge::Facet& facet, std::size_t i) const {
    const Vector along = corner(i + 1) - corner(i);
    const Vector across = CGAL::cross_product(along, facet.polar);
    Index least = facet.corners[0], most = least;
    for (Index c : facet.corners) {
      const Number at = across * gauge_.corners[c];
      const Number low = across * gauge_.corners[least], high = across * gauge_.corners[most];
      if (at < low || (at == low && c < least)) least = c;
      if (at > high || (at == high && c < most)) most = c;
    }
    const Vector &low = gauge_.corners[least], &high = gauge_.corners[most];
    return {distance, {corner(i), corner(i + 1)}, {low, high}, on_edge_[i], is_inner_[i]};
  }

  // The facet that an edge of the site and one of the gauge span, if it is one of their
  // sum: its polar point is between those of the gauge's facets at the edge.
  std::optional<Zone> on_edges(std::size_t i, const Gauge::Edge& edge) const {
    const Vector along = corner(i + 1) - corner(i);
    const Vector& left = gauge_.facets[edge.facets[0]].polar;
    const Vector& right = gauge_.facets[edge.facets[1]].polar;
    const Number at_left = left * along, at_right = right * along;
    if (CGAL::sign(at_left) * CGAL::sign(at_right) >= 0) return {};
    const Number t = at_left / (at_left - at_right);
    const Linear distance = through(left + (right - left) * t, corner(i));
    if (distance.at(corner(i + 2)) >= 0) return {};
    const Vector &v = gauge_.corners[edge.corners[0]], &w = gauge_.corners[edge.corners[1]];
    return Zone{distance, {corner(i), corner(i + 1)}, {v, w}, on_edge_[i], is_inner_[i]};
  }

  const Gauge& gauge_;
  const std::vector<Point>& corners_;
  const Vector& normal_;
  std::vector<PlanarMap::Along> on_edge_, at_corner_;
  std::vector<bool> is_inner_;
  std::vector<std::vector<Vector>> known_ways_;
};

}  // namespace

Rough::Rough(const Linear& exact) : c(CGAL::to_double(CGAL::exact(exact.c))) {
  const Place rounded = rough_place(CGAL::ORIGIN + exact.u);
  std::copy(rounded.begin(), rounded.end(), u);
}

std::pair<double, double> Rough::at(const Place& x) const {
  double value = -c, sum = std::abs(c);
  for (int i = 0; i < 3; ++i) {
    value += u[i] * x[i];
    sum += std::abs(u[i] * x[i]);
  }
  // A few roundings, of 2^-53 each, and those of what was given.
  return {value, 1e-14 * sum};
}

Shown Face::within(const CGAL::Bbox_3& box, const std::vector<Point>& polygon) const {
  for (const CGAL::Bbox_3& segment : boxes) {
    if (CGAL::do_overlap(segment, box)) return {true, {}};
  }
  const std::vector<Place> left = within_box(polygon, box);
  if (left.empty()) return {false, {}};
  if (is_narrow(left, box)) return {true, {}};  // rounding might tell a wrong label
  const Label label = map.at(middle(left), CGAL::NULL_VECTOR);
  return {label == unknown, label};
}

Shown shown(const Site& site, const Zone& zone, const Rough& distance,
            const std::vector<Place>& places) {
  if (zone.foot.size() == 1) return {false, zone.labels.labels[0]};
  if (zone.foot.size() == 2) return shown_on_edge(zone, places);
  return site.face->within(around_feet(zone, distance, places), site.corners);
}

bool knows_all(const Site& plane, const Rough& distance, const std::vector<Place>& places) {
  const CGAL::Bbox_3 box = around_feet(plane.zones[0], distance, places);
  const auto meets_box = [&](const std::array<Place, 2>& edge) {
    std::vector<Place> left(edge.begin(), edge.end());
    for (int side = 0; side < 6 && !left.empty(); ++side) left = clipped(left, box, side);
    return !left.empty();
  };
  if (std::any_of(plane.outline.begin(), plane.outline.end(), meets_box)) return false;
  const std::vector<Place> left = within_box(plane.corners, box);
  return !left.empty() && !is_narrow(left, box) &&
         plane.face->map.at(middle(left), CGAL::NULL_VECTOR) != unknown;
}

Polytope body(const PartialCell& cell, std::vector<Halfspace>& halfspaces) {
  Polytope body;
  std::vector<Index> names(cell.points.size(), none);
  halfspaces.reserve(cell.walls.size());
  for (const CellPlane& wall : cell.walls) {
    halfspaces.push_back(beyond(cell, wall));
    std::vector<Index> loop;
    for (Index corner : wall.corners) {
      if (names[corner] == none) {
        names[corner] = static_cast<Index>(body.corners.size());
        body.corners.push_back(std::make_shared<Corner>(cell.points[corner]));
      }
      loop.push_back(names[corner]);
    }
    // Seen from outside, which is where the normal points if the cell lies behind.
    if (wall.side > 0) std::reverse(loop.begin(), loop.end());
    body.facets.push_back({&halfspaces.back(), std::move(loop)});
  }
  return body;
}

Gauge gauge(const PartialCell& cell) {
  std::vector<Plane> planes;
  for (const CellPlane& wall : cell.walls) planes.push_back((*cell.planes)[wall.plane]);
  for (const CellPlane& patch : cell.patches) planes.push_back((*cell.planes)[patch.plane]);
  return Gauge(planes);
}

namespace {

// Its plane, and the convex parts of what is known on it.
std::vector<Site> patch_sites(const PartialCell& cell, const Gauge& gauge, const CellPlane& patch) {
  const std::vector<Point> all = border(cell, patch);
  const auto shared = face(cell, patch, all);
  const Vector& normal = (*cell.planes)[patch.plane].normal;
  std::vector<Site> sites{{shared, all, normal, Zones(gauge, all, normal).both_sides(), {}}};
  for (const std::vector<Point>& polygon : shared->map.known()) {
    Zones zones(gauge, polygon, normal);
    zones.read(shared->map);
    zones.add_outline(sites[0].outline);
    sites.push_back({shared, polygon, normal, zones.all(), {}});
  }
  return sites;
}

}  // namespace

std::vector<Site> sites(const PartialCell& cell, const Gauge& gauge) {
  std::vector<Site> sites;
  for (const CellPlane& wall : cell.walls) {
    const std::vector<Point> outline = corners(cell, wall);
    const Vector& normal = (*cell.planes)[wall.plane].normal;
    sites.push_back({face(cell, wall, outline), outline, normal, {}, {}});
    sites.back().zones.push_back(Zones(gauge, outline, normal).prism(wall.side));
  }
  std::vector<std::vector<Site>> of_patches(cell.patches.size());
  tbb::parallel_for(std::size_t{0}, of_patches.size(), [&](std::size_t i) {
    of_patches[i] = patch_sites(cell, gauge, cell.patches[i]);
  });
  for (std::vector<Site>& own : of_patches) {
    std::move(own.begin(), own.end(), std::back_inserter(sites));
  }
  return sites;
}

}  // namespace transect::skeleton::partial
