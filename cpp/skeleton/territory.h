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

// The distances of all zones, exact and rough, and which is nearer where.
class Distances {
 public:
  explicit Distances(const std::vector<Site>& sites);

  // Behind it, the owner is nearer than the rival.
  const Halfspace& nearer(Owner owner, Owner rival);
  // Whether that is so at a corner of the body (behind), and the contrary (front).
  Polytope::Sides sides(const Polytope& body, Owner owner, Owner rival);

 private:
  const std::vector<Site>& sites_;
  std::vector<std::vector<Rough>> rough_;
  // Deques do not move what they hold.
  std::map<std::array<Index, 4>, const Halfspace*> known_;
  std::deque<Halfspace> halfspaces_;
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

  const std::vector<Site>& sites_;
  Distances distances_;
  std::vector<Region> regions_;
};

}  // namespace transect::skeleton::partial
