#include "transect/cpp/skeleton/heights.h"

#include <set>
#include <utility>

namespace transect::skeleton {
namespace {

Site site_of(const Scene& scene, const CellPlane& wall) {
  const Plane& plane = scene.planes[wall.plane];
  const Vector inward = Number(wall.side) * plane.normal;
  const Vector rise = inward / (plane.scale * plane.normal.squared_length());
  return {wall.plane, wall.side, &wall, inward, rise};
}

}  // namespace

Heights::Heights(const Scene& scene, const Content& content) : scene_(scene), content_(content) {
  for (const CellPlane& wall : content.cell.walls) sites_.push_back(site_of(scene, wall));
  for (const Site& own : sites_) {
    factors_.emplace_back();
    for (const Site& other : sites_) {
      const Number c = scene.planes[other.plane].scale * (other.inward * own.rise);
      factors_.back().push_back(&own == &other ? Number(0) : 1 / (1 - c));
    }
  }
}

Number Heights::operator()(Index own, Index other, const Point& foot) const {
  return distance(other, foot) * factors_[own][other];
}

Number Heights::over(Index own, Index other, Index point) const {
  return is_on(other, point) ? Number(0) : (*this)(own, other, this->point(point));
}

Point Heights::foot(Index own, const Point& point) const {
  return point - distance(own, point) * sites_[own].rise;
}

bool scales_suffice(const Scene& scene, const Cells& cells) {
  using Side = std::pair<Index, int>;
  std::set<std::pair<Side, Side>> known;
  for (Index cell = 0; cell < cells.cells.size(); ++cell) {
    std::vector<Side> sides;
    for (Index index : cells.cells[cell].facets) {
      const Facet& facet = cells.facets[index];
      sides.push_back({facet.plane, facet.front == cell ? 1 : -1});
    }
    for (const Side& own : sides) {
      for (const Side& other : sides) {
        if (own == other || !known.insert({own, other}).second) continue;
        const Plane &a = scene.planes[own.first], &b = scene.planes[other.first];
        const Number product = Number(own.second * other.second) * (a.normal * b.normal);
        if (a.scale * a.normal.squared_length() <= b.scale * product) return false;
      }
    }
  }
  return true;
}

}  // namespace transect::skeleton
