#include "service/web/logins.h"

#include <gtest/gtest.h>

namespace tessera::server {
namespace {

using std::chrono::seconds;

constexpr Logins::Time kStart{std::chrono::hours{1000}};
const Visitor kAda{.caller = {.role = Role::kClient, .user = "ada"}, .certificate = "PEM"};

TEST(Logins, LetATokensHolderInOnce) {
  Logins logins;
  const auto token = logins.make_token(kAda, seconds{60}, kStart);
  ASSERT_TRUE(token.ok());
  EXPECT_FALSE(logins.find(*token, kStart)) << "a token is no session";
  const auto session = logins.begin(*token, kStart + seconds{59});
  ASSERT_TRUE(session.ok());
  EXPECT_NE(*session, *token);
  const auto who = logins.find(*session, kStart + seconds{60});
  ASSERT_TRUE(who);
  EXPECT_EQ(who->caller.user, "ada");
  EXPECT_EQ(who->caller.role, Role::kClient);
  EXPECT_EQ(who->certificate, "PEM");
  EXPECT_TRUE(absl::IsPermissionDenied(logins.begin(*token, kStart + seconds{60}).status()));
}

TEST(Logins, EndWithTheirTime) {
  Logins logins;
  const auto late = logins.make_token(kAda, seconds{60}, kStart);
  EXPECT_TRUE(absl::IsPermissionDenied(logins.begin(*late, kStart + seconds{60}).status()));
  const auto session = logins.begin(*logins.make_token(kAda, seconds{60}, kStart), kStart);
  EXPECT_TRUE(logins.find(*session, kStart + Logins::kSession - seconds{1}));
  EXPECT_FALSE(logins.find(*session, kStart + Logins::kSession));
  const auto other = logins.begin(*logins.make_token(kAda, seconds{60}, kStart), kStart);
  logins.end(*other);
  EXPECT_FALSE(logins.find(*other, kStart));
}

TEST(Logins, AreNotHeldUpByGuesses) {
  Logins logins;
  const auto token = logins.make_token(kAda, seconds{60}, kStart);
  for (int i = 0; i < 1000; ++i)
    EXPECT_TRUE(absl::IsPermissionDenied(logins.begin("guess", kStart).status()));
  EXPECT_TRUE(logins.begin(*token, kStart).ok());
}

TEST(Logins, HaveBounds) {
  Logins logins;
  EXPECT_TRUE(absl::IsInvalidArgument(logins.make_token(kAda, seconds{0}, kStart).status()));
  EXPECT_TRUE(
      absl::IsInvalidArgument(logins.make_token(kAda, Logins::kLongestToken + seconds{1}, kStart).status()));
  const auto named = [](std::size_t i) {
    return Visitor{.caller = {.role = Role::kClient, .user = std::to_string(i)}, .certificate = ""};
  };
  for (std::size_t i = 0; i < Logins::kMost; ++i)
    ASSERT_TRUE(logins.make_token(named(i), seconds{60}, kStart).ok());
  EXPECT_TRUE(absl::IsResourceExhausted(logins.make_token(kAda, seconds{60}, kStart).status()));
  EXPECT_TRUE(logins.make_token(kAda, seconds{60}, kStart + seconds{60}).ok()) << "old ones make room";
}

TEST(Logins, OfOneCallerMakeRoomForEachOther) {
  Logins logins;
  const Visitor ben{.caller = {.role = Role::kClient, .user = "ben"}, .certificate = ""};
  const auto other = logins.make_token(ben, seconds{60}, kStart);
  const auto oldest = logins.make_token(kAda, seconds{60}, kStart);
  const auto second = logins.make_token(kAda, seconds{61}, kStart);
  for (std::size_t i = 2; i <= Logins::kMostOfOneCaller; ++i)
    ASSERT_TRUE(logins.make_token(kAda, seconds{60 + i}, kStart).ok());
  EXPECT_FALSE(logins.begin(*oldest, kStart).ok());
  EXPECT_TRUE(logins.begin(*second, kStart).ok());
  EXPECT_TRUE(logins.begin(*other, kStart).ok()) << "others keep theirs";
}

}  // namespace
}  // namespace tessera::server
