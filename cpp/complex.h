// The exact cell complex of the planes in a box. No CGAL type crosses.
#pragma once

#include <cstdint>
#include <memory>

#include "rust/cxx.h"
#include "transect/cpp/trycatch.h"

namespace transect::complex {

class Complex;
struct Parts;

class ExactComplex {
 public:
  ExactComplex(rust::Slice<const double> bounds, std::uint32_t border);
  ~ExactComplex();

  std::uint32_t insert(rust::Slice<const double> plane);
  void remove(std::uint32_t plane);
  void draw(std::uint32_t plane, rust::Slice<const double> vertices,
            rust::Slice<const std::uint32_t> edges, std::uint32_t background);
  void erase(std::uint32_t plane);
  std::uint32_t coincident(rust::Slice<const double> plane) const;
  void begin();
  void commit();
  void rollback();
  void check() const;
  void check_places() const;
  Parts parts() const;
  Parts changes() const;

 private:
  std::unique_ptr<Complex> complex_;
};

std::unique_ptr<ExactComplex> new_complex(rust::Slice<const double> bounds, std::uint32_t border);

}  // namespace transect::complex
