// The grids of a file.
#pragma once

#include <openvdb/openvdb.h>

#include <stdexcept>
#include <string>

#include "rust/cxx.h"

namespace transect::vdb {

struct Grids {
  openvdb::GridPtrVec all;
  openvdb::MetaMap metadata;
  openvdb::math::Transform::Ptr transform;
  // Whether files have floats of half precision.
  bool half = false;

  openvdb::GridBase::Ptr find(rust::Str name) const {
    openvdb::GridBase::Ptr grid = openvdb::findGridByName(all, std::string(name));
    if (grid == nullptr) throw std::invalid_argument("no grid is called " + std::string(name));
    return grid;
  }

  openvdb::FloatGrid::Ptr find_float(rust::Str name) const {
    auto grid = openvdb::gridPtrCast<openvdb::FloatGrid>(find(name));
    if (grid == nullptr) throw std::invalid_argument(std::string(name) + " does not hold floats");
    return grid;
  }

  void add(const openvdb::GridBase::Ptr& grid, rust::Str name, openvdb::GridClass kind) {
    grid->setName(std::string(name));
    grid->setGridClass(kind);
    grid->setTransform(transform->copy());
    grid->setSaveFloatAsHalf(half);
    all.push_back(grid);
  }
};

}  // namespace transect::vdb
