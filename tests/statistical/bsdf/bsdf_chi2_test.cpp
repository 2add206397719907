// sample() of every model against the density that eval() claims: a sample of the directions of
// bsdf_chi2_long_test.cpp.
#include <cstdio>
#include <set>

#include "statistical/bsdf/density_check.h"

namespace tessera::test {
namespace {

/// A new model cannot be left out.
TEST(BsdfCases, HaveEveryModel) {
  using enum render::BsdfKind;
  // Nothing there; parts are asked instead; a walk, whose density is not that of its samples
  // (coated_conductor_test.cpp).
  std::set<render::BsdfKind> kinds{kInterface, kMix, kCoatedConductor};
  for (const BsdfCase& bsdf : all_cases()) {
    EXPECT_FALSE(bsdf.kind == kInterface || bsdf.kind == kMix || bsdf.kind == kCoatedConductor);
    kinds.insert(bsdf.kind);
  }
  for (int kind = 0; kind < static_cast<int>(kCount); ++kind) {
    EXPECT_TRUE(kinds.contains(static_cast<render::BsdfKind>(kind))) << "no case of kind " << kind;
  }
}

TEST(BsdfChiSquare, SamplesFollowThePdfWhichIntegratesToOne) {
  constexpr std::size_t kEvery = 10;  // direction for a model, beginning with another for the next
  const std::vector<BsdfCase> cases = all_cases();
  const std::vector<Direction> directions = many_wo();
  const double level = sidak_level(0.01, static_cast<int>(cases.size() * directions.size() / kEvery));
  std::size_t pairs = 0, tested = 0;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    for (std::size_t k = i % kEvery; k < directions.size(); k += kEvery) {
      ++pairs;
      if (!resolvable(cases[i], directions[k])) continue;
      ++tested;
      expect_samples_follow_pdf(cases[i], directions[k], level, 32 * i + k);
    }
  }
  std::printf("%zu of %zu pairs can be resolved\n", tested, pairs);
  EXPECT_GT(tested, pairs * 9 / 10);
}

}  // namespace
}  // namespace tessera::test
