#include "transect/cpp/vdb.h"

#include <openvdb/io/Archive.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Diagnostics.h>
#include <openvdb/tools/LevelSetUtil.h>
#include <openvdb/tools/Prune.h>
#include <openvdb/tools/SignedFloodFill.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "transect/cpp/eikonal.h"
#include "transect/cpp/grids.h"
#include "transect/src/ffi/vdb.rs.h"

namespace transect::vdb {

using openvdb::Coord;
using openvdb::FloatGrid;
using openvdb::Int32Grid;

namespace {

constexpr int kLeafDim = FloatGrid::TreeType::LeafNodeType::DIM;
constexpr size_t kLeafSize = FloatGrid::TreeType::LeafNodeType::SIZE;

Coord leaf_origin(rust::Slice<const int32_t> leaves, size_t index) {
  return {leaves[3 * index] * kLeafDim, leaves[3 * index + 1] * kLeafDim,
          leaves[3 * index + 2] * kLeafDim};
}

// Sets leaves with values, active where they differ from the background, and
// tiles of one value, active; equal values then become larger tiles.
template <typename Grid>
void fill(Grid& grid, rust::Slice<const int32_t> leaves,
          rust::Slice<const typename Grid::ValueType> values, rust::Slice<const int32_t> tiles,
          rust::Slice<const typename Grid::ValueType> tile_values) {
  auto& tree = grid.tree();
  for (size_t index = 0; index < leaves.size() / 3; ++index) {
    auto* leaf = tree.touchLeaf(leaf_origin(leaves, index));
    for (openvdb::Index node = 0; node < kLeafSize; ++node) {
      const auto value = values[index * kLeafSize + node];
      if (value != grid.background()) leaf->setValueOn(node, value);
    }
  }
  for (size_t index = 0; index < tiles.size() / 3; ++index) {
    tree.addTile(1, leaf_origin(tiles, index), tile_values[index], true);
  }
  openvdb::tools::prune(tree);
}

// The smallest number of half precision that is not below this positive one.
float half_above(float value) {
  openvdb::math::half rounded(value);
  if (static_cast<float>(rounded) < value) {
    rounded.setBits(static_cast<uint16_t>(rounded.bits() + 1));
  }
  return rounded;
}

// OpenVDB's own file class writes to a stream whose state it never looks at;
// this one writes the same layout to a stream of ours.
class Writer : public openvdb::io::Archive {
 public:
  void write_to(std::ostream& stream, const openvdb::GridCPtrVec& grids,
                const openvdb::MetaMap& metadata) const {
    Archive::write(stream, grids, /*seekable=*/true, metadata);
  }
};

// Where the library puts a random identifier: after the magic number (8
// bytes), the versions (4 + 4 + 4) and a flag (1). It is 36 characters long.
constexpr std::streamoff kTagOffset = 21;
constexpr size_t kTagSize = 36;

// 128 bits of FNV-1a over all bytes but the identifier.
std::string content_tag(std::istream& file) {
  unsigned __int128 hash =
      (static_cast<unsigned __int128>(0x6c62272e07bb0142U) << 64U) | 0x62b821756295c58dU;
  const unsigned __int128 prime = (static_cast<unsigned __int128>(1) << 88U) | 0x13bU;
  std::vector<char> block(1U << 20U);
  size_t position = 0;
  while (file.read(block.data(), static_cast<std::streamsize>(block.size())), file.gcount() > 0) {
    for (std::streamsize index = 0; index < file.gcount(); ++index, ++position) {
      if (position >= kTagOffset && position < kTagOffset + kTagSize) continue;
      hash = (hash ^ static_cast<unsigned char>(block[index])) * prime;
    }
  }
  std::string tag;
  for (int digit = 0; digit < 32; ++digit) {
    if (digit == 8 || digit == 12 || digit == 16 || digit == 20) tag += '-';
    tag += "0123456789abcdef"[static_cast<unsigned>(hash >> (4U * (31 - digit))) & 15U];
  }
  return tag;
}

// The same grids make the same bytes: a hash of the content takes the place
// of the random identifier.
void settle_tag(const std::string& path) {
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.exceptions(std::ios::badbit);
  const std::string tag = content_tag(file);
  file.clear();
  file.exceptions(std::ios::badbit | std::ios::failbit);
  std::string found(kTagSize, ' ');
  file.seekg(kTagOffset).read(found.data(), kTagSize);
  if (std::count(found.begin(), found.end(), '-') != 4) {
    throw std::runtime_error("this OpenVDB writes another header than the one known");
  }
  file.seekp(kTagOffset).write(tag.data(), kTagSize);
  file.close();
}

void write_file(const Grids& grids, const std::string& path) {
  std::ofstream file;
  file.exceptions(std::ios::badbit | std::ios::failbit);
  file.open(path, std::ios::binary | std::ios::trunc);
  Writer writer;
  // Each grid whole: not every reader follows references.
  writer.setInstancingEnabled(false);
  writer.write_to(file, openvdb::GridCPtrVec(grids.all.begin(), grids.all.end()), grids.metadata);
  file.close();
  settle_tag(path);
}

rust::Vec<rust::String> texts(const openvdb::MetaMap& metadata) {
  rust::Vec<rust::String> found;
  for (auto entry = metadata.beginMeta(); entry != metadata.endMeta(); ++entry) {
    found.push_back(entry->first);
    found.push_back(entry->second->str());
  }
  return found;
}

}  // namespace

std::unique_ptr<Volumes> new_volumes(double voxel, std::array<double, 3> origin, bool half) {
  openvdb::initialize();
  auto volumes = std::make_unique<Volumes>();
  volumes->grids = std::make_shared<Grids>();
  volumes->grids->transform = openvdb::math::Transform::createLinearTransform(voxel);
  volumes->grids->transform->postTranslate({origin[0], origin[1], origin[2]});
  volumes->grids->half = half;
  return volumes;
}

void add_level_set(Volumes& volumes, rust::Str name, double half_width,
                   rust::Slice<const int32_t> leaves, rust::Slice<const float> values) {
  const double voxel = volumes.grids->transform->voxelSize()[0];
  auto background = static_cast<float>(half_width * voxel);
  // Rounding must not make it less than what OpenVDB's check asks for.
  while (background / voxel < half_width) {
    background = std::nextafter(background, std::numeric_limits<float>::infinity());
  }
  if (volumes.grids->half) background = half_above(background);
  FloatGrid::Ptr grid = FloatGrid::create(background);
  for (size_t index = 0; index < leaves.size() / 3; ++index) {
    auto* leaf = grid->tree().touchLeaf(leaf_origin(leaves, index));
    for (openvdb::Index node = 0; node < kLeafSize; ++node) {
      const float value = values[index * kLeafSize + node];
      if (std::abs(value) < half_width) {
        leaf->setValueOn(node, static_cast<float>(value * voxel));
      } else {
        leaf->setValueOff(node, std::copysign(background, value));
      }
    }
  }
  openvdb::tools::signedFloodFill(grid->tree());
  volumes.grids->add(grid, name, openvdb::GRID_LEVEL_SET);
  settle_gradients(*grid);
}

void add_alias(Volumes& volumes, rust::Str from, rust::Str name) {
  volumes.grids->add(volumes.grids->find_float(from)->copy(), name, openvdb::GRID_LEVEL_SET);
}

void remove(Volumes& volumes, rust::Str name) {
  auto& all = volumes.grids->all;
  all.erase(std::find(all.begin(), all.end(), volumes.grids->find(name)));
}

void adopt(Volumes& volumes, const Volumes& others) {
  const auto& more = others.grids->all;
  volumes.grids->all.insert(volumes.grids->all.end(), more.begin(), more.end());
}

void add_fog(Volumes& volumes, rust::Str from, rust::Str name) {
  FloatGrid::Ptr fog = volumes.grids->find_float(from)->deepCopy();
  openvdb::tools::sdfToFogVolume(*fog);
  openvdb::tools::prune(fog->tree());
  volumes.grids->add(fog, name, openvdb::GRID_FOG_VOLUME);
}

void add_numbers(Volumes& volumes, rust::Str name, rust::Slice<const int32_t> leaves,
                 rust::Slice<const int32_t> values, rust::Slice<const int32_t> tiles,
                 rust::Slice<const int32_t> tile_values) {
  Int32Grid::Ptr grid = Int32Grid::create(0);
  fill(*grid, leaves, values, tiles, tile_values);
  volumes.grids->add(grid, name, openvdb::GRID_UNKNOWN);
}

void add_values(Volumes& volumes, rust::Str name, float background,
                rust::Slice<const int32_t> leaves, rust::Slice<const float> values,
                rust::Slice<const int32_t> tiles, rust::Slice<const float> tile_values) {
  FloatGrid::Ptr grid = FloatGrid::create(background);
  fill(*grid, leaves, values, tiles, tile_values);
  volumes.grids->add(grid, name, openvdb::GRID_UNKNOWN);
}

void set_text(Volumes& volumes, rust::Str grid, rust::Str key, rust::Str text) {
  const openvdb::StringMetadata value{std::string(text)};
  if (grid.empty()) {
    volumes.grids->metadata.insertMeta(std::string(key), value);
  } else {
    volumes.grids->find(grid)->insertMeta(std::string(key), value);
  }
}

void write(const Volumes& volumes, rust::Str path) {
  errno = 0;
  try {
    write_file(*volumes.grids, std::string(path));
  } catch (const std::ios_base::failure&) {
    throw std::runtime_error(errno != 0 ? std::strerror(errno) : "it cannot be written");
  }
}

std::unique_ptr<Volumes> read(rust::Str path) {
  openvdb::initialize();
  openvdb::io::File file{std::string(path)};
  file.open(/*delayLoad=*/false);
  auto volumes = std::make_unique<Volumes>();
  volumes->grids = std::make_shared<Grids>();
  volumes->grids->all = *file.getGrids();
  volumes->grids->metadata = *file.getMetadata();
  return volumes;
}

rust::Vec<Description> describe(const Volumes& volumes) {
  rust::Vec<Description> found;
  for (const openvdb::GridBase::Ptr& grid : volumes.grids->all) {
    const openvdb::Vec3d voxel = grid->voxelSize();
    const openvdb::Vec3d origin = grid->indexToWorld(Coord(0, 0, 0));
    Description description;
    description.name = grid->getName();
    description.value_type = grid->valueType();
    description.class_name = openvdb::GridBase::gridClassToString(grid->getGridClass());
    description.voxel = {voxel[0], voxel[1], voxel[2]};
    description.origin = {origin[0], origin[1], origin[2]};
    description.active = grid->activeVoxelCount();
    description.metadata = texts(*grid);
    found.push_back(std::move(description));
  }
  return found;
}

rust::Vec<rust::String> file_metadata(const Volumes& volumes) {
  return texts(volumes.grids->metadata);
}

double value(const Volumes& volumes, rust::Str name, std::array<int32_t, 3> node) {
  const Coord at(node[0], node[1], node[2]);
  const openvdb::GridBase::Ptr grid = volumes.grids->find(name);
  if (auto numbers = openvdb::gridPtrCast<Int32Grid>(grid)) return numbers->tree().getValue(at);
  return volumes.grids->find_float(name)->tree().getValue(at);
}

rust::String check_level_set(const Volumes& volumes, rust::Str name) {
  return openvdb::tools::checkLevelSet(*volumes.grids->find_float(name));
}

rust::String check_fog_volume(const Volumes& volumes, rust::Str name) {
  return openvdb::tools::checkFogVolume(*volumes.grids->find_float(name));
}

}  // namespace transect::vdb
