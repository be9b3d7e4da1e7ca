// What a throwing bridged function does: every exception becomes an error with
// a text, also those that do not derive from std::exception.
#pragma once

#include <exception>

namespace rust {
namespace behavior {

template <typename Try, typename Fail>
static void trycatch(Try&& func, Fail&& fail) noexcept try {
  func();
} catch (const std::exception& e) {
  fail(e.what());
} catch (...) {
  fail("an exception of unknown type in C++");
}

}  // namespace behavior
}  // namespace rust
