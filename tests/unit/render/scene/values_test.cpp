// Names, spectra and loops that all builders use.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <new>

#include "render/scene/values/name_table.h"
#include "render/scene/values/parallel.h"
#include "render/scene/values/spectra.h"
#include "spectra/named_spectra.h"
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
  EXPECT_THAT(refusal("sampled { wavelengths_nm: [400, 500] values: [1, -1] }"),
              HasSubstr("the value of a spectrum at 500 nm is -1, which is negative"));
  EXPECT_THAT(refusal("sampled {}"), HasSubstr("at least one"));
  EXPECT_THAT(refusal("sampled { wavelengths_nm: [0.4, 0.7] values: [1, 1] }"),
              HasSubstr("none from 300 to 1000 nm"));
  EXPECT_THAT(refusal("blackbody { kelvin: -3 }"), HasSubstr("not above 0 K"));
  EXPECT_THAT(refusal("named: 'metal-Au-n'"),
              HasSubstr("no spectrum is called 'metal-Au-n'; did you mean 'metal-Au-k'?"));
}

TEST(Spectra, AreFoundByName) {
  for (const std::string& name : spectra::names_of_spectra()) {
    v1::Spectrum spectrum;
    spectrum.set_named(name);
    EXPECT_EQ(check_spectrum(spectrum, name.c_str()), absl::OkStatus());
    ASSERT_TRUE(measured_curve(spectrum).has_value());
    if (!name.ends_with("-k"))
      EXPECT_GT(measured_curve(spectrum)->at(550), 0) << name;  // some absorb nothing
  }
  // Daylight is white, and its luminance is 1.
  const spectra::Rgb white = emission(message<v1::Spectrum>("named: 'stdillum-D65'"));
  for (const float c : {white.r, white.g, white.b}) EXPECT_NEAR(c, 1, 1e-3);
}

TEST(Spectra, HaveTheColourThatTheirFormatGivesThem) {
  const auto spectrum = message<v1::Spectrum>(
      "sampled { wavelengths_nm: [400, 700] values: [1, 2] } in_rgb { r: 3 g: 4 b: 5 }");
  for (const spectra::Rgb& rgb : {emission(spectrum), reflectance(spectrum)}) {
    EXPECT_EQ(rgb.r, 3);
    EXPECT_EQ(rgb.g, 4);
    EXPECT_EQ(rgb.b, 5);
  }
  ASSERT_TRUE(measured_curve(spectrum).has_value());
  EXPECT_EQ(measured_curve(spectrum)->at(400), 1);
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
