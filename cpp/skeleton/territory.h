// The partition of a cell: each zone of each site keeps what no other site is nearer to.
// What is nearer to a site Q than f, which is linear, is convex: all distances of Q's zones
// are below f there. So it is cut off piece by piece, along the planes where one of them
// equals f, and nothing is propagated.
#pragma once

#include <deque>
#include <map>
#include <utility>

#include "transect/cpp/skeleton/sites.h"

namespace transect::skeleton::partial {

// A zone of a site.
struct Owner {
  Index site, zone;
};

struct Region {
  Owner owner;
  Polytope body;
};

class Territory {
 public:
  Territory(const Polytope& cell, const std::vector<Site>& sites);

  const std::vector<Region>& regions() const { return regions_; }

 private:
  void settle(const Polytope& cell, Owner owner);
  bool keep_zone(Polytope& body, Owner owner);
  bool keep_before_walls(Polytope& body, Owner owner);
  std::vector<Polytope> without(const Polytope& body, Owner owner, Index rival);
  const Linear& distance(Owner owner) const;
  const Halfspace& nearer(Owner owner, Owner rival);

  const std::vector<Site>& sites_;
  // Behind each, the first owner's distance is the smaller one; deques do not move them.
  std::map<std::pair<std::pair<Index, Index>, std::pair<Index, Index>>, const Halfspace*> known_;
  std::deque<Halfspace> halfspaces_;
  std::vector<Region> regions_;
};

}  // namespace transect::skeleton::partial
