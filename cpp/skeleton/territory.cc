#include "transect/cpp/skeleton/territory.h"

#include <utility>

namespace transect::skeleton::partial {

Territory::Territory(const Polytope& cell, const std::vector<Site>& sites) : sites_(sites) {
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

// In its zone, a distance is the largest of its site.
bool Territory::keep_zone(Polytope& body, Owner owner) {
  for (Index zone = 0; zone < sites_[owner.site].zones.size(); ++zone) {
    if (zone != owner.zone && !body.clip(nearer({owner.site, zone}, owner))) return false;
  }
  return true;
}

bool Territory::keep_before_walls(Polytope& body, Owner owner) {
  for (Index rival = 0; rival < sites_.size(); ++rival) {
    if (rival == owner.site || sites_[rival].zones.size() > 1) continue;
    if (!body.clip(nearer(owner, {rival, 0}))) return false;
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
    if (out_of_reach(body.sides(nearer(owner, {rival, zone})))) return {body};
  }
  std::vector<Polytope> kept;
  Polytope rest = body;
  for (Index zone = 0; zone < count; ++zone) {
    const Halfspace& owned = nearer(owner, {rival, zone});
    const Polytope::Sides sides = rest.sides(owned);
    if (out_of_reach(sides)) return {body};
    if (!sides.behind) continue;
    kept.push_back(rest);
    kept.back().clip(owned);
    rest.clip(nearer({rival, zone}, owner));
  }
  return kept;
}

const Linear& Territory::distance(Owner owner) const {
  return sites_[owner.site].zones[owner.zone].distance;
}

const Halfspace& Territory::nearer(Owner owner, Owner rival) {
  const Halfspace*& at =
      known_[{{owner.site, owner.zone}, {rival.site, rival.zone}}];
  if (!at) {
    halfspaces_.push_back(less(distance(owner), distance(rival)));
    at = &halfspaces_.back();
  }
  return *at;
}

}  // namespace transect::skeleton::partial
