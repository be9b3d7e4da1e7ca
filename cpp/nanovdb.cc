// NanoVDB files. Its headers are in packages of their own, and moved with every version.
#include "transect/cpp/vdb.h"

#if __has_include(<nanovdb/tools/CreateNanoGrid.h>)  // OpenVDB 12
#define NANOVDB_USE_OPENVDB
#include <nanovdb/io/IO.h>
#include <nanovdb/tools/CreateNanoGrid.h>
#define TRANSECT_TO_NANO nanovdb::tools::openToNanoVDB
#elif __has_include(<nanovdb/util/CreateNanoGrid.h>)  // 11
#define NANOVDB_USE_OPENVDB
#include <nanovdb/util/CreateNanoGrid.h>
#include <nanovdb/util/IO.h>
#define TRANSECT_TO_NANO nanovdb::openToNanoVDB
#elif __has_include(<nanovdb/util/OpenToNanoVDB.h>)  // 10
#include <nanovdb/util/IO.h>
#include <nanovdb/util/OpenToNanoVDB.h>
#define TRANSECT_TO_NANO nanovdb::openToNanoVDB
#endif

#include <stdexcept>
#include <string>

#include "transect/cpp/grids.h"

#ifdef TRANSECT_TO_NANO

#include <cerrno>
#include <cstring>
#include <fstream>
#include <vector>

namespace transect::vdb {

bool has_nano() { return true; }

void write_nano(const Volumes& volumes, rust::Str path) {
  errno = 0;
  try {
    std::ofstream file;
    file.exceptions(std::ios::badbit | std::ios::failbit);
    file.open(std::string(path), std::ios::binary | std::ios::trunc);
    // All in one segment: some readers look at the first alone.
    std::vector<nanovdb::GridHandle<nanovdb::HostBuffer>> handles;
    for (const openvdb::GridBase::Ptr& grid : volumes.grids->all) {
      handles.push_back(TRANSECT_TO_NANO(grid));
    }
    nanovdb::io::writeGrids(file, handles, nanovdb::io::Codec::NONE);
    file.close();
  } catch (const std::ios_base::failure&) {
    throw std::runtime_error(errno != 0 ? std::strerror(errno) : "it cannot be written");
  }
}

}  // namespace transect::vdb

#else

namespace transect::vdb {

bool has_nano() { return false; }

void write_nano(const Volumes&, rust::Str) {
  throw std::runtime_error("this transect was built without NanoVDB");
}

}  // namespace transect::vdb

#endif
