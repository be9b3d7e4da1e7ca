// The distances of all zones of all sites in doubles, and in a part of space exactly which
// of two is nearer where.
#pragma once

#include <deque>
#include <map>
#include <vector>

#include "transect/cpp/skeleton/sites.h"

namespace transect::skeleton::partial {

// A zone of a site.
struct Owner {
  Index site, zone;
};

class Distances {
 public:
  explicit Distances(const std::vector<Site>& sites);

  const std::vector<Site>& sites() const { return sites_; }
  const Zone& zone(Owner owner) const { return sites_[owner.site].zones[owner.zone]; }
  const Rough& rough(Owner owner) const { return rough_[owner.site][owner.zone]; }
  const WholeLinear& whole(Owner owner) const { return whole_[owner.site][owner.zone]; }

 private:
  const std::vector<Site>& sites_;
  std::vector<std::vector<Rough>> rough_;
  std::vector<std::vector<WholeLinear>> whole_;
};

// The planes on which two zones are equally near.
class Bisectors {
 public:
  explicit Bisectors(const Distances& distances) : distances_(distances) {}

  // Behind it, the owner is nearer than the rival.
  const Halfspace& nearer(Owner owner, Owner rival);
  // Whether that is so at a corner of the body (behind), and the contrary (front).
  Polytope::Sides sides(const Polytope& body, Owner owner, Owner rival);

 private:
  const Distances& distances_;
  std::map<std::array<Index, 4>, const Halfspace*> known_;
  std::deque<Halfspace> halfspaces_;  // deques do not move what they hold
};

}  // namespace transect::skeleton::partial
