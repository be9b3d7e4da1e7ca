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
  void settle(const Candidate& own, Index zone);
  bool keep_zone(Polytope& body, const Candidate& own, Index zone);
  void keep_nearer(Polytope body, Owner owner, const Candidate& rival, std::vector<Polytope>& kept);

  const Leaf& leaf_;
  const Distances& distances_;
  Bisectors& bisectors_;
  std::vector<Region> regions_;
};

}  // namespace transect::skeleton::partial
