// The partition of a leaf (leaves.h): each zone of each site keeps what no other site is
// nearer to. What is nearer to a site Q than f, which is linear, is convex: all distances
// of Q's zones are below f there. So it is cut off piece by piece, along the planes where
// one of them equals f, and nothing is propagated.
#pragma once

#include "transect/cpp/skeleton/leaves.h"

namespace transect::skeleton::partial {

struct Region {
  Owner owner;
  Polytope body;
};

class Territory {
 public:
  Territory(const Leaf& leaf, const Distances& distances, Bisectors& bisectors);

  std::vector<Region>& regions() { return regions_; }

 private:
  void settle(Owner owner);
  bool is_wall(const Candidate& candidate) const;
  bool keep_zone(Polytope& body, Owner owner);
  bool keep_before_walls(Polytope& body, Owner owner);
  std::vector<Polytope> without(const Polytope& body, Owner owner, const Candidate& rival);

  const Leaf& leaf_;
  const Distances& distances_;
  Bisectors& bisectors_;
  std::vector<Region> regions_;
};

}  // namespace transect::skeleton::partial
