// sample() of every model against the density that eval() claims, from 32 directions.
#include "statistical/bsdf/density_check.h"

namespace tessera::test {
namespace {

TEST(BsdfChiSquareLong, SamplesFollowThePdfWhichIntegratesToOne) {
  const std::vector<BsdfCase> cases = all_cases();
  const std::vector<Direction> directions = many_wo();
  ASSERT_EQ(directions.size(), 32u);
  const double level = sidak_level(0.01, static_cast<int>(cases.size() * directions.size()));
  int unresolved = 0;
  double most_lost = 0;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    for (std::size_t k = 0; k < directions.size(); ++k) {
      if (!resolvable(cases[i], directions[k])) {
        ++unresolved;
        continue;
      }
      most_lost = std::max(most_lost, expect_samples_follow_pdf(cases[i], directions[k], level, 32 * i + k));
    }
  }
  RecordProperty("pairs_beyond_single_precision", unresolved);
  RecordProperty("largest_part_of_samples_lost", std::to_string(most_lost));
}

}  // namespace
}  // namespace tessera::test
