// Join tokens: how long, how often, and for whom not.
#include "tls/join_tokens.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "support/process/temp_dir.h"

namespace tessera::server {
namespace {

using std::chrono::hours;
using std::chrono::minutes;
using std::chrono::seconds;

constexpr const char* kMember = "render7";
constexpr const char* kAddress = "ipv4:10.0.0.1";
const JoinTokens::Time kToday{hours{24 * 365 * 50}};

std::string contents(const std::filesystem::path& path) {
  std::ifstream in{path};
  return {std::istreambuf_iterator<char>{in}, {}};
}

TEST(JoinTokens, AreAcceptedAsOftenAsWasSaid) {
  auto tokens = JoinTokens::open({});
  ASSERT_TRUE(tokens.ok());
  const auto secret = tokens->make(hours{1}, 2, kToday);
  ASSERT_TRUE(secret.ok());
  EXPECT_EQ(secret->size(), 32U);
  EXPECT_TRUE(tokens->redeem(*secret, kMember, kAddress, kToday).ok());
  EXPECT_TRUE(tokens->redeem(*secret, kMember, kAddress, kToday + minutes{59}).ok());
  EXPECT_TRUE(absl::IsPermissionDenied(tokens->redeem(*secret, kMember, kAddress, kToday + minutes{59})));
}

TEST(JoinTokens, AreCalledBackOfTheMemberThatKnowsThem) {
  const support::TempDir folder;
  const std::filesystem::path file = folder.path() / "join-tokens";
  auto tokens = JoinTokens::open(file);
  ASSERT_TRUE(tokens.ok());
  const auto shared = tokens->make(hours{1}, 3, kToday), unused = tokens->make(hours{2}, 2, kToday);
  ASSERT_TRUE(shared.ok() && unused.ok());
  EXPECT_TRUE(tokens->redeem(*shared, "render7", kAddress, kToday).ok());
  EXPECT_TRUE(tokens->redeem(*shared, "render 8", kAddress, kToday).ok());

  auto restarted = JoinTokens::open(file);
  ASSERT_TRUE(restarted.ok());
  EXPECT_EQ(restarted->call_back("stranger").value(), 0U);
  EXPECT_EQ(restarted->call_back("render 8").value(), 1U);
  EXPECT_TRUE(absl::IsPermissionDenied(restarted->redeem(*shared, "render9", kAddress, kToday)));
  EXPECT_TRUE(restarted->redeem(*unused, "render9", kAddress, kToday).ok())
      << "nobody who was put out knows it";
}

TEST(JoinTokens, Expire) {
  auto tokens = JoinTokens::open({});
  const auto secret = tokens->make(hours{1}, 1, kToday);
  ASSERT_TRUE(secret.ok());
  EXPECT_TRUE(absl::IsPermissionDenied(tokens->redeem(*secret, kMember, kAddress, kToday + hours{1})));
}

TEST(JoinTokens, OneDigitOffIsAnotherToken) {
  auto tokens = JoinTokens::open({});
  const auto secret = tokens->make(hours{1}, 1, kToday);
  ASSERT_TRUE(secret.ok());
  for (std::size_t i = 0; i < secret->size(); i += 5) {
    std::string tampered = *secret;
    tampered[i] = tampered[i] == '0' ? '1' : '0';
    EXPECT_TRUE(absl::IsPermissionDenied(tokens->redeem(tampered, kMember, kAddress, kToday)));
  }
  EXPECT_TRUE(absl::IsPermissionDenied(tokens->redeem("", kMember, kAddress, kToday)));
  EXPECT_TRUE(tokens->redeem(*secret, kMember, kAddress, kToday).ok());
}

TEST(JoinTokens, OutliveTheCoordinatorButNotTheirUses) {
  const support::TempDir folder;
  const auto file = folder.path() / "join-tokens";
  std::string once, thrice;
  {
    auto tokens = JoinTokens::open(file);
    ASSERT_TRUE(tokens.ok());
    once = tokens->make(hours{1}, 1, kToday).value();
    thrice = tokens->make(hours{1}, 3, kToday).value();
    ASSERT_TRUE(tokens->redeem(once, kMember, kAddress, kToday).ok());
    ASSERT_TRUE(tokens->redeem(thrice, kMember, kAddress, kToday).ok());
  }
  // Whoever reads the file learns no secret.
  EXPECT_EQ(contents(file).find(thrice), std::string::npos);
  EXPECT_EQ(std::filesystem::status(file).permissions(),
            std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
  auto tokens = JoinTokens::open(file);
  ASSERT_TRUE(tokens.ok()) << tokens.status();
  EXPECT_TRUE(absl::IsPermissionDenied(tokens->redeem(once, kMember, kAddress, kToday)));
  EXPECT_TRUE(tokens->redeem(thrice, kMember, kAddress, kToday).ok());
  EXPECT_TRUE(tokens->redeem(thrice, kMember, kAddress, kToday).ok());
  EXPECT_TRUE(absl::IsPermissionDenied(tokens->redeem(thrice, kMember, kAddress, kToday)));
}

TEST(JoinTokens, ADamagedFileIsNamed) {
  const support::TempDir folder;
  const auto file = folder.path() / "join-tokens";
  std::ofstream{file} << "0123 1 1\n";
  EXPECT_TRUE(absl::IsDataLoss(JoinTokens::open(file).status()));
}

TEST(JoinTokens, GuessingIsSlowAndHindersNobodyElse) {
  auto tokens = JoinTokens::open({});
  const auto secret = tokens->make(hours{1}, 5, kToday);
  ASSERT_TRUE(secret.ok());
  const std::string wrong(32, '0');
  for (std::uint32_t i = 0; i < JoinTokens::kFailuresAMinute; ++i) {
    EXPECT_TRUE(absl::IsPermissionDenied(tokens->redeem(wrong, kMember, kAddress, kToday)));
  }
  EXPECT_TRUE(absl::IsResourceExhausted(tokens->redeem(wrong, kMember, kAddress, kToday)));
  EXPECT_TRUE(absl::IsResourceExhausted(tokens->redeem(*secret, kMember, kAddress, kToday)));
  EXPECT_TRUE(tokens->redeem(*secret, kMember, "ipv4:10.0.0.2", kToday).ok());
  EXPECT_TRUE(tokens->redeem(*secret, kMember, kAddress, kToday + minutes{1}).ok());
  // From any number of addresses, what is remembered of them stays bounded.
  for (std::size_t i = 0; i < 2 * JoinTokens::kMostAddresses; ++i) {
    static_cast<void>(tokens->redeem(wrong, kMember, std::to_string(i), kToday + minutes{1}));
  }
  EXPECT_TRUE(absl::IsResourceExhausted(tokens->redeem(wrong, kMember, "yet another", kToday + minutes{1})));
}

TEST(JoinTokens, LivesAndUsesHaveBounds) {
  auto tokens = JoinTokens::open({});
  EXPECT_TRUE(absl::IsInvalidArgument(tokens->make(seconds{0}, 1, kToday).status()));
  EXPECT_TRUE(absl::IsInvalidArgument(tokens->make(hours{24 * 31}, 1, kToday).status()));
  EXPECT_TRUE(absl::IsInvalidArgument(tokens->make(hours{1}, 0, kToday).status()));
  EXPECT_TRUE(absl::IsInvalidArgument(tokens->make(hours{1}, JoinTokens::kMostUses + 1, kToday).status()));
  for (std::size_t i = 0; i < JoinTokens::kMostTokens; ++i)
    ASSERT_TRUE(tokens->make(hours{1}, 1, kToday).ok());
  EXPECT_TRUE(absl::IsResourceExhausted(tokens->make(hours{1}, 1, kToday).status()));
  EXPECT_TRUE(tokens->make(hours{1}, 1, kToday + hours{2}).ok());  // the others are expired
}

}  // namespace
}  // namespace tessera::server
