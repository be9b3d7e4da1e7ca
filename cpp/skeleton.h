// The exact reconstruction (Barequet and Vaxman 2009), by CGAL. Its parts are in
// skeleton/; no CGAL type crosses.
#pragma once

#include <cstdint>
#include <memory>

#include "rust/cxx.h"
#include "transect/cpp/trycatch.h"

namespace transect::skeleton {

struct Input;
struct CellKey;
struct CellOutput;
struct ContradictionOutput;
struct Watcher;

class Skeleton {
 public:
  explicit Skeleton(const Input& input);
  ~Skeleton();

  std::uint32_t cells() const;
  std::uint32_t bits() const;
  std::uint32_t snapped() const;
  rust::Vec<double> points() const;
  rust::Vec<rust::String> exact_points() const;
  rust::Vec<std::uint32_t> contours() const;
  rust::Vec<ContradictionOutput> contradictions() const;
  CellKey key(std::uint32_t cell, bool exact, std::uint32_t most_pieces) const;
  CellOutput surface(std::uint32_t cell, bool exact, std::uint32_t most_pieces,
                     const Watcher& watcher) const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

std::unique_ptr<Skeleton> prepare(const Input& input);

}  // namespace transect::skeleton
