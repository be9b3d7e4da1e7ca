#include "transect/cpp/skeleton/nearest.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <set>
#include <utility>

namespace transect::skeleton::partial {
namespace {

// Whether one linear function is above another at all corners, whatever their errors.
bool above(const double* more, double more_error, const double* less, double less_error,
           std::size_t corners) {
  for (std::size_t i = 0; i < corners; ++i) {
    if (!(more[i] - more_error > less[i] + less_error)) return false;
  }
  return true;
}

}  // namespace

Spread::Spread(const Candidate& all, const Distances& distances, const std::vector<Place>& places)
    : candidate{all.site, {}},
      sum(-std::numeric_limits<double>::infinity()),
      high(places.size(), -std::numeric_limits<double>::infinity()),
      corners_(places.size()) {
  const std::size_t count = all.zones.size();
  std::vector<double> every(count * corners_), error(count), sums(count);
  for (std::size_t zone = 0; zone < count; ++zone) {
    const Rough& rough = distances.rough({all.site, all.zones[zone]});
    for (std::size_t corner = 0; corner < corners_; ++corner) {
      const auto [value, doubt] = rough.at(places[corner]);
      every[zone * corners_ + corner] = value;
      error[zone] = std::max(error[zone], doubt);
      sums[zone] += value;
    }
  }
  // Zones that are the largest somewhere are above others, if any are.
  const auto lead = [&](auto value) {
    std::size_t best = 0;
    for (std::size_t i = 1; i < count; ++i) {
      if (value(i) > value(best)) best = i;
    }
    return best;
  };
  const auto is_below = [&](std::size_t zone, std::size_t leader) {
    return leader != zone && above(&every[leader * corners_], error[leader],
                                   &every[zone * corners_], error[zone], corners_);
  };
  std::vector<std::size_t> left(count);
  std::iota(left.begin(), left.end(), 0);
  const auto drop_below = [&](std::size_t leader) {
    left.erase(std::remove_if(left.begin(), left.end(),
                              [&](std::size_t zone) { return is_below(zone, leader); }),
               left.end());
  };
  drop_below(lead([&](std::size_t zone) { return sums[zone]; }));
  std::vector<std::size_t> leaders;
  for (std::size_t corner = 0; corner < corners_; ++corner) {
    leaders.push_back(lead([&](std::size_t zone) { return every[zone * corners_ + corner]; }));
  }
  std::sort(leaders.begin(), leaders.end());
  leaders.erase(std::unique(leaders.begin(), leaders.end()), leaders.end());
  for (std::size_t leader : leaders) drop_below(leader);
  for (std::size_t zone : left) {
    const double* own = &every[zone * corners_];
    for (std::size_t corner = 0; corner < corners_; ++corner) {
      high[corner] = std::max(high[corner], own[corner] + error[zone]);
    }
    sum = std::max(sum, sums[zone]);
    candidate.zones.push_back(all.zones[zone]);
    values_.insert(values_.end(), own, own + corners_);
    errors_.push_back(error[zone]);
  }
}

bool Spread::is_beyond(const Spread& other) const {
  for (std::size_t zone = 0; zone < errors_.size(); ++zone) {
    if (above(&values_[zone * corners_], errors_[zone], other.high.data(), 0, corners_)) {
      return true;
    }
  }
  return false;
}

bool Spread::touches() const {
  for (std::size_t zone = 0; zone < errors_.size(); ++zone) {
    const double* own = &values_[zone * corners_];
    if (*std::min_element(own, own + corners_) > errors_[zone]) return false;
  }
  return true;
}

std::vector<Spread> nearest(const std::vector<Candidate>& all, const Distances& distances,
                            const std::vector<Place>& corners) {
  std::vector<Spread> spreads;
  for (const Candidate& candidate : all) spreads.emplace_back(candidate, distances, corners);
  std::set<std::size_t> leaders;
  const auto lead = [&](auto value) {
    std::size_t best = 0;
    for (std::size_t i = 1; i < spreads.size(); ++i) {
      if (value(spreads[i]) < value(spreads[best])) best = i;
    }
    leaders.insert(best);
  };
  lead([](const Spread& spread) { return spread.sum; });
  for (std::size_t corner = 0; corner < corners.size(); ++corner) {
    lead([corner](const Spread& spread) { return spread.high[corner]; });
  }
  std::vector<bool> is_out(spreads.size());
  for (std::size_t i = 0; i < spreads.size(); ++i) {
    for (std::size_t leader : leaders) {
      is_out[i] = is_out[i] || (leader != i && spreads[i].is_beyond(spreads[leader]));
    }
  }
  std::vector<Spread> kept;
  for (std::size_t i = 0; i < spreads.size(); ++i) {
    if (!is_out[i]) kept.push_back(std::move(spreads[i]));
  }
  return kept;
}

}  // namespace transect::skeleton::partial
