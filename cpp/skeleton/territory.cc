#include "transect/cpp/skeleton/territory.h"

#include <cmath>
#include <utility>

namespace transect::skeleton::partial {

Distances::Distances(const std::vector<Site>& sites) : sites_(sites) {
  for (const Site& site : sites) {
    rough_.emplace_back();
    for (const Zone& zone : site.zones) rough_.back().emplace_back(zone.distance);
  }
}

const Halfspace& Distances::nearer(Owner owner, Owner rival) {
  const Halfspace*& at = known_[{owner.site, owner.zone, rival.site, rival.zone}];
  if (!at) {
    halfspaces_.push_back(less(sites_[owner.site].zones[owner.zone].distance,
                               sites_[rival.site].zones[rival.zone].distance));
    at = &halfspaces_.back();
  }
  return *at;
}

Polytope::Sides Distances::sides(const Polytope& body, Owner owner, Owner rival) {
  const Rough &own = rough_[owner.site][owner.zone], &other = rough_[rival.site][rival.zone];
  Polytope::Sides sides{false, false};
  for (const Point& point : body.points) {
    const std::array<double, 3> x{CGAL::to_double(point.x()), CGAL::to_double(point.y()),
                                  CGAL::to_double(point.z())};
    const auto [a, error_a] = own.at(x);
    const auto [b, error_b] = other.at(x);
    const bool clear = std::abs(a - b) > error_a + error_b;
    const int sign = clear ? (a < b ? -1 : 1) : side(nearer(owner, rival), point);
    sides.behind |= sign < 0;
    sides.front |= sign > 0;
    if (sides.behind && sides.front) break;
  }
  return sides;
}

Territory::Territory(const Polytope& cell, const std::vector<Site>& sites)
    : sites_(sites), distances_(sites) {
  for (Index site = 0; site < sites.size(); ++site) {
    for (Index zone = 0; zone < sites[site].zones.size(); ++zone) settle(cell, {site, zone});
  }
}

void Territory::settle(const Polytope& cell, Owner owner) {
  Polytope zone = cell;
  if (!keep_before_walls(zone, owner) || !keep_zone(zone, owner)) return;
  std::vector<Polytope> parts{std::move(zone)};
  for (Index rival = 0; rival < sites_.size(); ++rival) {
    if (rival == owner.site || sites_[rival].zones.size() == 1) continue;
    std::vector<Polytope> kept;
    for (const Polytope& part : parts) {
      for (Polytope& rest : without(part, owner, rival)) kept.push_back(std::move(rest));
    }
    parts = std::move(kept);
  }
  for (Polytope& part : parts) regions_.push_back({owner, std::move(part)});
}

bool Territory::keep_zone(Polytope& body, Owner owner) {
  for (const Halfspace& bound : sites_[owner.site].zones[owner.zone].bounds) {
    if (!body.clip(bound)) return false;
  }
  return true;
}

bool Territory::keep_before_walls(Polytope& body, Owner owner) {
  for (Index rival = 0; rival < sites_.size(); ++rival) {
    if (rival == owner.site || sites_[rival].zones.size() > 1) continue;
    if (!body.clip(distances_.nearer(owner, {rival, 0}))) return false;
  }
  return true;
}

// The parts of the body where the rival is not nearer. Where both are equally near all
// over the body (they share a corner), the first site has it.
std::vector<Polytope> Territory::without(const Polytope& body, Owner owner, Index rival) {
  const std::size_t count = sites_[rival].zones.size();
  const auto out_of_reach = [&](const Polytope::Sides& sides) {
    return !sides.front && (sides.behind || owner.site < rival);
  };
  for (Index zone = 0; zone < count; ++zone) {
    if (out_of_reach(distances_.sides(body, owner, {rival, zone}))) return {body};
  }
  std::vector<Polytope> kept;
  Polytope rest = body;
  for (Index zone = 0; zone < count; ++zone) {
    const Polytope::Sides sides = distances_.sides(rest, owner, {rival, zone});
    if (out_of_reach(sides)) return {body};
    if (!sides.behind) continue;
    kept.push_back(rest);
    kept.back().clip(distances_.nearer(owner, {rival, zone}));
    rest.clip(distances_.nearer({rival, zone}, owner));
  }
  return kept;
}

}  // namespace transect::skeleton::partial
