#include "transect/cpp/skeleton/territory.h"

#include <algorithm>
#include <utility>

namespace transect::skeleton::partial {

Territory::Territory(const Leaf& leaf, const Distances& distances, Bisectors& bisectors)
    : leaf_(leaf), distances_(distances), bisectors_(bisectors) {
  for (const Candidate& own : leaf.candidates) {
    for (Index zone : own.zones) {
      // In a leaf that is not exact the site beyond an inner edge may not be asked.
      if (leaf.is_exact && distances.zone({own.site, zone}).is_inner) continue;
      settle(own, zone);
    }
  }
}

void Territory::settle(const Candidate& own, Index zone) {
  const Owner owner{own.site, zone};
  Polytope body = leaf_.body;
  if (!keep_zone(body, own, zone)) return;
  std::vector<Spread> rivals = nearest(leaf_.candidates, distances_, body.places());
  const auto is_own = [&](const Spread& spread) { return spread.candidate.site == own.site; };
  if (std::none_of(rivals.begin(), rivals.end(), is_own)) return;
  // What is taken away first may be all there is.
  std::sort(rivals.begin(), rivals.end(),
            [](const Spread& a, const Spread& b) { return a.sum < b.sum; });
  std::vector<Polytope> parts{std::move(body)};
  for (const Spread& rival : rivals) {
    if (is_own(rival)) continue;
    std::vector<Polytope> kept;
    for (Polytope& part : parts) keep_nearer(std::move(part), owner, rival.candidate, kept);
    parts = std::move(kept);
  }
  for (Polytope& part : parts) regions_.push_back({owner, std::move(part)});
}

// A site's distance is the largest of its zones'.
bool Territory::keep_zone(Polytope& body, const Candidate& own, Index zone) {
  return std::all_of(own.zones.begin(), own.zones.end(), [&](Index other) {
    if (other == zone) return true;
    const Owner less{own.site, other}, more{own.site, zone};
    const Polytope::Sides sides = bisectors_.sides(body, less, more);
    if (sides.behind && sides.front) body.clip(bisectors_.nearer(less, more));
    return sides.behind;
  });
}

// The parts of the body where the rival is not nearer. Where both are equally near all
// over the body (they share a corner), the first site has it.
void Territory::keep_nearer(Polytope body, Owner owner, const Candidate& rival,
                            std::vector<Polytope>& kept) {
  const auto out_of_reach = [&](const Polytope::Sides& sides) {
    return !sides.front && (sides.behind || owner.site < rival.site);
  };
  const std::vector<Index> zones = Spread(rival, distances_, body.places()).candidate.zones;
  for (Index zone : zones) {
    if (!out_of_reach(bisectors_.sides(body, owner, {rival.site, zone}))) continue;
    kept.push_back(std::move(body));
    return;
  }
  const std::size_t before = kept.size();
  Polytope rest = body;
  for (Index zone : zones) {
    const Owner other{rival.site, zone};
    const Polytope::Sides sides = bisectors_.sides(rest, owner, other);
    if (out_of_reach(sides)) {
      kept.resize(before);
      kept.push_back(std::move(body));
      return;
    }
    if (!sides.behind) continue;
    kept.push_back(rest);
    kept.back().clip(bisectors_.nearer(owner, other));
    rest.clip(bisectors_.nearer(other, owner));
  }
}

}  // namespace transect::skeleton::partial
