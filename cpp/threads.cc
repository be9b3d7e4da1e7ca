#include "transect/cpp/threads.h"

#include <tbb/global_control.h>

#include <memory>

namespace transect::threads {

void limit_threads(std::size_t count) {
  // The limit lasts as long as the object.
  static std::unique_ptr<tbb::global_control> limit;
  limit =
      std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism, count);
}

}  // namespace transect::threads
