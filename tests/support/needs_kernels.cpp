// Part of every test program that renders: without a kernel for this processor beside it, it says so and
// skips all of its tests.
#include <gtest/gtest.h>

#include "render/renderer.h"
#include "support/needs.h"

namespace tessera::test {
namespace {

class NeedsKernels : public testing::Environment {
  void SetUp() override {
    if (render::supported_isas().empty()) GTEST_SKIP() << needs("a kernel module for this processor");
  }
};

[[maybe_unused]] const testing::Environment* const kNeedsKernels =
    testing::AddGlobalTestEnvironment(new NeedsKernels);

}  // namespace
}  // namespace tessera::test
