#include "transect/cpp/skeleton/distances.h"

#include <cmath>

namespace transect::skeleton::partial {

Distances::Distances(const std::vector<Site>& sites) : sites_(sites) {
  for (const Site& site : sites) {
    rough_.emplace_back();
    whole_.emplace_back();
    for (const Zone& zone : site.zones) {
      rough_.back().emplace_back(zone.distance);
      whole_.back().emplace_back(zone.distance.u, zone.distance.c);
    }
  }
}

const Halfspace& Bisectors::nearer(Owner owner, Owner rival) {
  const Halfspace*& at = known_[{owner.site, owner.zone, rival.site, rival.zone}];
  if (!at) {
    halfspaces_.emplace_back(distances_.whole(owner), distances_.whole(rival));
    at = &halfspaces_.back();
  }
  return *at;
}

Polytope::Sides Bisectors::sides(const Polytope& body, Owner owner, Owner rival) {
  const Rough &own = distances_.rough(owner), &other = distances_.rough(rival);
  Polytope::Sides sides{false, false};
  for (const auto& corner : body.corners) {
    const auto [a, error_a] = own.at(corner->rough());
    const auto [b, error_b] = other.at(corner->rough());
    const bool clear = std::abs(a - b) > error_a + error_b;
    const int sign = clear ? (a < b ? -1 : 1) : nearer(owner, rival).side(*corner);
    sides.behind |= sign < 0;
    sides.front |= sign > 0;
    if (sides.behind && sides.front) break;
  }
  return sides;
}

}  // namespace transect::skeleton::partial
