#include "transect/cpp/skeleton/heights.h"

#include <map>

namespace transect::skeleton {
namespace {

std::vector<Site> sites_of(const Scene& scene, const Cells& cells, Index cell) {
  std::vector<Site> sites;
  for (Index index : cells.cells[cell].facets) {
    const Facet& facet = cells.facets[index];
    const Plane& plane = scene.planes[facet.plane];
    const int side = facet.front == cell ? 1 : -1;
    const Vector inward = Number(side) * plane.normal;
    const Vector rise = inward / (plane.scale * plane.normal.squared_length());
    sites.push_back({facet.plane, side, &facet, inward, rise});
  }
  return sites;
}

}  // namespace

Heights::Heights(const Scene& scene, const Cells& cells, Index cell)
    : scene_(scene), sites_(sites_of(scene, cells, cell)) {
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
  if (scene_.points.side(point, sites_[other].plane) == 0) return Number(0);
  return (*this)(own, other, scene_.points[point]);
}

Point Heights::foot(Index own, const Point& point) const {
  return point - distance(own, point) * sites_[own].rise;
}

bool Heights::labels_differ() const {
  for (const Site& site : sites_) {
    if (!site.is_uniform() || site.facet->label != sites_.front().facet->label) return true;
  }
  return false;
}

bool scales_suffice(const Scene& scene, const Cells& cells) {
  std::map<std::pair<std::pair<Index, int>, std::pair<Index, int>>, bool> known;
  for (Index cell = 0; cell < cells.cells.size(); ++cell) {
    const std::vector<Site> sites = sites_of(scene, cells, cell);
    for (const Site& own : sites) {
      for (const Site& other : sites) {
        if (&own == &other) continue;
        const auto [found, is_new] =
            known.insert({{{own.plane, own.side}, {other.plane, other.side}}, true});
        if (!is_new) continue;
        const Plane &a = scene.planes[own.plane], &b = scene.planes[other.plane];
        if (a.scale * a.normal.squared_length() <= b.scale * (own.inward * other.inward)) {
          return false;
        }
      }
    }
  }
  return true;
}

}  // namespace transect::skeleton
