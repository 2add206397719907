// Kernel modules say of which build they are, and those of another one are refused by name.
#include "render/kernel/kernel_module.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/renderer.h"

namespace tessera::render {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST(KernelModule, OfThisBuildIsTheKernelThatProgramsFind) {
  for (const std::string& isa : supported_isas()) {
    const auto kernel = open_kernel_module(kernel_file(isa, KernelLight::kRgb));
    ASSERT_TRUE(kernel.ok()) << kernel.status();
    EXPECT_EQ(*kernel, find_kernel(isa));
  }
  EXPECT_TRUE(refused_kernels().empty());
}

TEST(KernelModule, OfAnotherBuildIsRefusedWithBothNames) {
  const absl::Status status = open_kernel_module(TESSERA_MODULE_OF_ANOTHER_BUILD).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(status.message()),
              AllOf(HasSubstr(TESSERA_MODULE_OF_ANOTHER_BUILD), HasSubstr("build 0.0.9-abc"),
                    HasSubstr(std::string(kernel_build()))));
}

TEST(KernelModule, WithoutABuildIsRefused) {
  const absl::Status status = open_kernel_module(TESSERA_MODULE_WITHOUT_BUILD).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(status.message()), HasSubstr("belongs to a build without a name"));
}

TEST(KernelModule, ThatIsNotThereIsNotFound) {
  const absl::Status status = open_kernel_module("libtessera_kernel_of_nobody.so").status();
  EXPECT_EQ(status.code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(status.message()), HasSubstr("libtessera_kernel_of_nobody.so"));
}

}  // namespace
}  // namespace tessera::render
