// OpenVDB grids and their files. No OpenVDB type crosses.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "rust/cxx.h"
#include "transect/cpp/trycatch.h"

namespace transect::vdb {

struct Grids;
struct Description;

/// Grids with one transform, and text that belongs to all of them.
struct Volumes {
  std::shared_ptr<Grids> grids;
};

// See src/ffi/vdb.rs for what they do.
std::unique_ptr<Volumes> new_volumes(double voxel, std::array<double, 3> origin, bool half);
void add_level_set(Volumes& volumes, rust::Str name, double half_width,
                   rust::Slice<const int32_t> leaves, rust::Slice<const float> values);
void add_alias(Volumes& volumes, rust::Str from, rust::Str name);
void remove(Volumes& volumes, rust::Str name);
void adopt(Volumes& volumes, const Volumes& others);
void add_fog(Volumes& volumes, rust::Str from, rust::Str name);
void add_numbers(Volumes& volumes, rust::Str name, rust::Slice<const int32_t> leaves,
                 rust::Slice<const int32_t> values, rust::Slice<const int32_t> tiles,
                 rust::Slice<const int32_t> tile_values);
void add_values(Volumes& volumes, rust::Str name, float background,
                rust::Slice<const int32_t> leaves, rust::Slice<const float> values,
                rust::Slice<const int32_t> tiles, rust::Slice<const float> tile_values);
void set_text(Volumes& volumes, rust::Str grid, rust::Str key, rust::Str text);

void write(const Volumes& volumes, rust::Str path);
void write_nano(const Volumes& volumes, rust::Str path);
bool has_nano();
std::unique_ptr<Volumes> read(rust::Str path);

rust::Vec<Description> describe(const Volumes& volumes);
rust::Vec<rust::String> file_metadata(const Volumes& volumes);
double value(const Volumes& volumes, rust::Str grid, std::array<int32_t, 3> node);
rust::String check_level_set(const Volumes& volumes, rust::Str grid);
rust::String check_fog_volume(const Volumes& volumes, rust::Str grid);

}  // namespace transect::vdb
