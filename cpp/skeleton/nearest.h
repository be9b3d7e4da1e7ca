// Which sites may be nearest somewhere in a convex body, and by which of their zones, as far
// as doubles can tell:
//
//   a zone is out where another of its site is larger at all corners (both are linear);
//   a site is where one of its zones is farther than another site at all corners (a distance
//   is convex, so the difference has its largest value at a corner)
//
// What is left may be too much, never too little.
#pragma once

#include <vector>

#include "transect/cpp/skeleton/distances.h"

namespace transect::skeleton::partial {

// A site that may be nearest somewhere, by the zones in which it may be.
struct Candidate {
  Index site;
  std::vector<Index> zones;
};

// A site's distance at the corners of a body, by the zones that are not out.
class Spread {
 public:
  Spread(const Candidate& all, const Distances& distances, const std::vector<Place>& corners);

  Candidate candidate;
  double sum;                // of the largest zone's, or less
  std::vector<double> high;  // at each corner, no less than the distance

  // Whether a zone is above all of the other's at all corners.
  bool is_beyond(const Spread& other) const;
  // Whether no zone tells that the site is apart.
  bool touches() const;

 private:
  std::size_t corners_;
  std::vector<double> values_;  // zone by zone
  std::vector<double> errors_;  // of each zone
};

std::vector<Spread> nearest(const std::vector<Candidate>& all, const Distances& distances,
                            const std::vector<Place>& corners);

}  // namespace transect::skeleton::partial
