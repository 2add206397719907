// Names, spectra and loops that all builders use.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <new>

#include "render/scene/values/name_table.h"
#include "render/scene/values/parallel.h"
#include "render/scene/values/spectra.h"
#include "unit/render/scene/builder_inputs.h"

namespace tessera::render {
namespace {

using testing::HasSubstr;

TEST(NameTable, FindsByNameAndTheUnnamedWhereThereIsOne) {
  NameTable materials("material", 7), objects("object");
  EXPECT_EQ(materials.add("gold", 0), absl::OkStatus());
  EXPECT_EQ(*materials.find("gold"), 0);
  EXPECT_EQ(*materials.find(""), 7);
  EXPECT_THAT(std::string(materials.add("gold", 1).message()),
              HasSubstr("material 'gold': the name is used twice"));
  EXPECT_THAT(std::string(materials.find("lead").status().message()),
              HasSubstr("material 'lead' does not exist"));
  EXPECT_THAT(std::string(objects.find("").status().message()), HasSubstr("object '' does not exist"));
}

TEST(Spectra, WithoutAMeaningAreRefused) {
  EXPECT_EQ(check_spectrum(message<v1::Spectrum>("constant: 2"), "colour"), absl::OkStatus());
  const auto refusal = [](const char* text) {
    return std::string(check_spectrum(message<v1::Spectrum>(text), "colour").message());
  };
  EXPECT_THAT(refusal("constant: nan"), HasSubstr("colour: a colour is not finite"));
  EXPECT_THAT(refusal("sampled { wavelengths_nm: [400, 500] values: [1] }"),
              HasSubstr("one value a wavelength"));
  EXPECT_THAT(refusal("sampled { wavelengths_nm: [500, 400] values: [1, 1] }"), HasSubstr("must ascend"));
  EXPECT_THAT(refusal("sampled { wavelengths_nm: [400, 500] values: [1, inf] }"), HasSubstr("not finite"));
}

TEST(ParallelFor, DoesAllAndReportsAnError) {
  for (const int threads : {1, 3}) {
    std::atomic<int> sum{0};
    EXPECT_EQ(parallel_for(100, threads,
                           [&](std::size_t i) {
                             sum += static_cast<int>(i);
                             return absl::OkStatus();
                           }),
              absl::OkStatus());
    EXPECT_EQ(sum, 4950);
    const auto fails = [](std::size_t i) {
      return i == 42 ? absl::InvalidArgumentError("the 42nd") : absl::OkStatus();
    };
    EXPECT_EQ(parallel_for(100, threads, fails), absl::InvalidArgumentError("the 42nd"));
    const auto throws = [](std::size_t) -> absl::Status { throw std::bad_alloc(); };
    EXPECT_EQ(parallel_for(4, threads, throws).code(), absl::StatusCode::kResourceExhausted);
  }
}

}  // namespace
}  // namespace tessera::render
