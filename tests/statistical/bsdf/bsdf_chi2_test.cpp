// sample() of every model against the density that eval() claims: a sample of the directions of
// bsdf_chi2_long_test.cpp.
#include "statistical/bsdf/density_check.h"

namespace tessera::test {
namespace {

TEST(BsdfChiSquare, SamplesFollowThePdfWhichIntegratesToOne) {
  constexpr std::size_t kEvery = 10;  // direction for a model, beginning with another for the next
  const std::vector<BsdfCase> cases = all_cases();
  const std::vector<Direction> directions = many_wo();
  const double level = sidak_level(0.01, static_cast<int>(cases.size() * directions.size() / kEvery));
  for (std::size_t i = 0; i < cases.size(); ++i) {
    for (std::size_t k = i % kEvery; k < directions.size(); k += kEvery) {
      if (resolvable(cases[i], directions[k])) expect_samples_follow_pdf(cases[i], directions[k], level, 32 * i + k);
    }
  }
}

}  // namespace
}  // namespace tessera::test
