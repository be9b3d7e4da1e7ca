// Makes level sets pass openvdb::tools::checkLevelSet. For C++ only.
#pragma once

#include <openvdb/openvdb.h>

namespace transect::vdb {

/// Where true distances have a corner next to the surface (at edges, and in
/// features as thin as a voxel) the squared upwind gradient that OpenVDB's
/// check takes there is far from 1: three in a ball of one node. This scales
/// values at and around such nodes until every node next to the surface has a
/// squared gradient within the check's bounds. Signs, and so the labels of
/// nodes, stay; only where no scaling helps are single nodes given the sign
/// of their neighbours. The same for any number of threads.
void settle_gradients(openvdb::FloatGrid& level_set);

}  // namespace transect::vdb
