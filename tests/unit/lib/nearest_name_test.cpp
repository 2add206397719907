#include "base/nearest_name.h"

#include <gtest/gtest.h>

namespace tessera::base {
namespace {

const std::vector<std::string> kCommands{"render", "resume", "retry", "priority", "cancel"};

TEST(NearestName, FindsWhatDiffersByOneLetterOrTwo) {
  EXPECT_EQ(nearest_name("rendr", kCommands), "render");    // left out
  EXPECT_EQ(nearest_name("renderr", kCommands), "render");  // put in
  EXPECT_EQ(nearest_name("rneder", kCommands), "render");   // swapped with its neighbour
  EXPECT_EQ(nearest_name("RENDER", kCommands), "render");
  EXPECT_EQ(nearest_name("retyr", kCommands), "retry");
}

TEST(NearestName, FindsWhatANameBegins) { EXPECT_EQ(nearest_name("prio", kCommands), "priority"); }

TEST(NearestName, FindsNothingThatIsFarAway) {
  EXPECT_EQ(nearest_name("workers", kCommands), "");
  EXPECT_EQ(nearest_name("", kCommands), "");
  EXPECT_EQ(nearest_name("render", {}), "");
  EXPECT_EQ(nearest_name(std::string(1'000'000, 'r'), kCommands), "");
}

TEST(NearestName, IsAskedForInAQuestion) {
  EXPECT_EQ(did_you_mean("rendr", kCommands), "; did you mean 'render'?");
  EXPECT_EQ(did_you_mean("workers", kCommands), "");
}

}  // namespace
}  // namespace tessera::base
