// How many threads TBB, which OpenVDB runs on, may use.
#pragma once

#include <cstddef>

#include "transect/cpp/trycatch.h"

namespace transect::threads {

void limit_threads(std::size_t count);

}  // namespace transect::threads
