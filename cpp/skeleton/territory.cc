#include "transect/cpp/skeleton/territory.h"

#include <utility>

namespace transect::skeleton::partial {

Territory::Territory(const Leaf& leaf, const Distances& distances, Bisectors& bisectors)
    : leaf_(leaf), distances_(distances), bisectors_(bisectors) {
  for (const auto& [site, zones] : leaf.candidates) {
    for (Index zone : zones) {
      // In a leaf that is not exact the site beyond an inner edge may not be asked.
      if (!leaf.is_exact || !distances.zone({site, zone}).is_inner) settle({site, zone});
    }
  }
}

void Territory::settle(Owner owner) {
  Polytope zone = leaf_.body;
  if (!keep_before_walls(zone, owner) || !keep_zone(zone, owner)) return;
  std::vector<Polytope> parts{std::move(zone)};
  for (const Candidate& rival : leaf_.candidates) {
    if (rival.site == owner.site || is_wall(rival)) continue;
    std::vector<Polytope> kept;
    for (const Polytope& part : parts) {
      for (Polytope& rest : without(part, owner, rival)) kept.push_back(std::move(rest));
    }
    parts = std::move(kept);
  }
  for (Polytope& part : parts) regions_.push_back({owner, std::move(part)});
}

bool Territory::is_wall(const Candidate& candidate) const {
  return distances_.sites()[candidate.site].is_wall();
}

bool Territory::keep_zone(Polytope& body, Owner owner) {
  for (const Halfspace& bound : distances_.zone(owner).bounds) {
    if (!body.clip(bound)) return false;
  }
  return true;
}

bool Territory::keep_before_walls(Polytope& body, Owner owner) {
  for (const Candidate& rival : leaf_.candidates) {
    if (rival.site == owner.site || !is_wall(rival)) continue;
    if (!body.clip(bisectors_.nearer(owner, {rival.site, 0}))) return false;
  }
  return true;
}

// The parts of the body where the rival is not nearer. Where both are equally near all
// over the body (they share a corner), the first site has it.
std::vector<Polytope> Territory::without(const Polytope& body, Owner owner,
                                         const Candidate& rival) {
  const auto out_of_reach = [&](const Polytope::Sides& sides) {
    return !sides.front && (sides.behind || owner.site < rival.site);
  };
  for (Index zone : rival.zones) {
    if (out_of_reach(bisectors_.sides(body, owner, {rival.site, zone}))) return {body};
  }
  std::vector<Polytope> kept;
  Polytope rest = body;
  for (Index zone : rival.zones) {
    const Owner other{rival.site, zone};
    const Polytope::Sides sides = bisectors_.sides(rest, owner, other);
    if (out_of_reach(sides)) return {body};
    if (!sides.behind) continue;
    kept.push_back(rest);
    kept.back().clip(bisectors_.nearer(owner, other));
    rest.clip(bisectors_.nearer(other, owner));
  }
  return kept;
}

}  // namespace transect::skeleton::partial
