#include "farm/contact.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "tessera/v1/farm.pb.h"

namespace tessera::client {
namespace {

using std::chrono::milliseconds;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr milliseconds kForever{1'000'000};
constexpr milliseconds kNever{0};

class ContactTest : public ::testing::Test {
 protected:
  Contact contact(milliseconds first, milliseconds later) {
    return Contact{"farm:7070", first, later,
                   [this](const std::string& message) { notices_.push_back(message); }};
  }
  const absl::Status gone_ = absl::UnavailableError("gone");
  std::vector<std::string> notices_;
};

TEST_F(ContactTest, AnErrorThatWillNotPassIsFinal) {
  Contact contact = this->contact(kForever, kForever);
  EXPECT_EQ(contact.failed(absl::NotFoundError("no such job"), {}).code(), absl::StatusCode::kNotFound);
  EXPECT_TRUE(notices_.empty());
}

TEST_F(ContactTest, BeforeAndAfterFirstContactPatienceDiffers) {
  Contact never_reached = contact(kNever, kForever);
  EXPECT_EQ(never_reached.failed(gone_, {}), gone_);
  Contact reached = contact(kForever, kNever);
  reached.succeeded();
  EXPECT_EQ(reached.failed(gone_, {}), gone_);
}

TEST_F(ContactTest, TellsOnceOfABreakAndOnceOfItsEnd) {
  Contact contact = this->contact(kNever, kForever);
  contact.succeeded();
  EXPECT_TRUE(contact.failed(gone_, {}).ok());
  EXPECT_TRUE(contact.failed(gone_, {}).ok());
  contact.succeeded();
  contact.succeeded();
  EXPECT_THAT(notices_, ElementsAre(HasSubstr("trouble with the coordinator at farm:7070"),
                                    HasSubstr("answers again")));
}

TEST_F(ContactTest, AnInterruptEndsTheWait) {
  Contact contact = this->contact(kForever, kForever);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_TRUE(absl::IsCancelled(contact.failed(gone_, stop.get_token())));
}

TEST_F(ContactTest, RepeatsACallUntilItSucceeds) {
  Contact contact = this->contact(kForever, kForever);
  int calls = 0;
  const absl::StatusOr<int> result = contact.retried({}, [&]() -> absl::StatusOr<int> {
    if (++calls < 3) return gone_;
    return 42;
  });
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(*result, 42);
  EXPECT_EQ(calls, 3);
}

TEST_F(ContactTest, WhatOthersNamedCannotSteerTheTerminal) {
  Contact contact = this->contact(kForever, kForever);
  const auto response = contact.retried({}, []() -> absl::StatusOr<v1::ListJobsResponse> {
    v1::ListJobsResponse jobs;
    jobs.add_jobs()->set_name("\x1b[2Jdone\r");
    return jobs;
  });
  ASSERT_TRUE(response.ok()) << response.status();
  EXPECT_EQ(response->jobs(0).name(), "\\x1b[2Jdone\\x0d");
}

}  // namespace
}  // namespace tessera::client
