// A machine joins the farm with nothing but a token, and the logs and metrics of those that are in it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "integration/farm_under_test.h"

namespace tessera::integration {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using Arguments = std::vector<std::string>;

class Join : public testing::Test {
 protected:
  void SetUp() override {
    const support::Finished made =
        support::run_program({server_program(), "--init-tls", (here() / "tls").string()}, kPatience);
    ASSERT_EQ(made.status.code, 0) << made.err;
    coordinator_ = std::make_unique<support::Process>(
        Arguments{server_program(), "--listen", "127.0.0.1:0", "--data", (here() / "data").string(), "--tls",
                  (here() / "tls/server").string(), "--join-authority", (here() / "tls/authority").string(),
                  "--log-format", "json", "--log-level", "debug"});
    const auto address = coordinator_->wait_for_line("listening on ", kPatience);
    ASSERT_TRUE(address) << coordinator_->err();
    address_ = *address;
  }

  const fs::path& here() const { return directory_.path(); }

  support::Finished as(const std::string& who, Arguments arguments) const {
    arguments.insert(arguments.end(), {"--server", address_, "--tls", (here() / "tls" / who).string()});
    return tessera(std::move(arguments));
  }
  std::string token(Arguments options = {}) const {
    options.insert(options.begin(), "token");
    const support::Finished made = as("admin", std::move(options));
    EXPECT_EQ(made.status.code, 0) << made.err;
    return made.out.substr(0, made.out.find('\n'));
  }
  std::unique_ptr<support::Process> worker(const std::string& token, const fs::path& certificates,
                                           const std::string& format = "text") const {
    return std::make_unique<support::Process>(
        Arguments{worker_program(), "--server", address_, "--threads", "1", "--cache",
                  (here() / "cache").string(), "--name", "newcomer", "--tls", certificates.string(), "--join",
                  token, "--metrics", "127.0.0.1:0", "--log-format", format, "--log-level", "debug"});
  }

  support::TempDir directory_;
  std::unique_ptr<support::Process> coordinator_;
  std::string address_;
};

TEST_F(Join, ATokenIsAllThatANewMachineNeeds) {
  const std::string once = token();
  const fs::path mine = here() / "mine";
  {
    const auto first = worker(once, mine);
    ASSERT_TRUE(first->wait_for_err("registered with", kPatience)) << first->err();
    ASSERT_TRUE(first->wait_for_err("metrics on port", kPatience)) << first->err();
    const support::Finished image =
        as("admin", {"submit", "scenes/cornell-box/scene.pbrt", "--resolution", "32x32", "--spp", "1",
                     "--quiet", "-o", (here() / "image.exr").string()});
    EXPECT_EQ(image.status.code, 0) << image.err;
    // The key has not left the folder, and nobody else reads it.
    EXPECT_EQ(fs::status(mine / "key.pem").permissions(), fs::perms::owner_read | fs::perms::owner_write);
  }
  // Started again with the same command line, it is a member already; elsewhere, the token is used up.
  EXPECT_TRUE(worker(once, mine)->wait_for_err("registered with", kPatience));
  const auto second = worker(once, here() / "other");
  const auto ended = second->wait(kPatience);
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->code, 4) << second->err();
  EXPECT_THAT(second->err(), HasSubstr("the join token is not valid"));
  EXPECT_TRUE(coordinator_->wait_for_err("may not join: the join token is not known, or used up", kPatience));
}

TEST_F(Join, ATokenOfAnotherFarmIsNotToldToThisOne) {
  // The same port, but the digest of another authority.
  std::string other = token();
  const std::size_t digest = other.find(':', other.find(':') + 1) + 1;
  other[digest] = other[digest] == '0' ? '1' : '0';
  const auto refused = worker(other, here() / "mine");
  const auto ended = refused->wait(kPatience);
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->code, 4);
  EXPECT_THAT(refused->err(), HasSubstr("its authority is another"));
  EXPECT_FALSE(fs::exists(here() / "mine" / "certificate.pem"));
  const auto senseless = worker("tessera-join:1", here() / "mine");
  EXPECT_EQ(senseless->wait(kPatience)->code, 2) << senseless->err();
}

TEST_F(Join, WhoeverIsExpelledLeavesAndComesBackWithANewTokenOnly) {
  const auto leaves = [](support::Process& worker, const std::string& why) {
    const auto ended = worker.wait(kPatience);
    ASSERT_TRUE(ended) << worker.err();
    EXPECT_EQ(ended->code, 4) << worker.err();
    EXPECT_THAT(worker.err(), HasSubstr(why));
  };
  const std::string good_for_two = token({"--uses", "2"});
  const auto first = worker(good_for_two, here() / "mine");
  ASSERT_TRUE(first->wait_for_err("registered with", kPatience)) << first->err();
  // A machine joins by its own name, whatever its worker calls itself.
  const nlohmann::json workers = nlohmann::json::parse(as("admin", {"workers", "--json"}).out);
  const std::string machine = workers["workers"][0]["certificate"];
  EXPECT_THAT(as("admin", {"workers"}).out, HasSubstr("certificate of " + machine));

  const std::string of_others = token();
  const support::Finished nobody = as("admin", {"expel", "nobody"});
  EXPECT_EQ(nobody.status.code, 2) << nobody.out;
  EXPECT_THAT(nobody.err, HasSubstr("no worker with the name 'nobody' in its certificate has called here"));
  const support::Finished expelled = as("admin", {"expel", machine});
  EXPECT_EQ(expelled.out, "worker " + machine + " is expelled: 1 at work, 1 join tokens called back\n")
      << expelled.err;
  const std::string told = "'" + machine + "' (worker) was expelled from the farm";
  leaves(*first, told);
  leaves(*worker(good_for_two, here() / "mine"), told);
  leaves(*worker(good_for_two, here() / "other"), "the join token is not valid");
  EXPECT_TRUE(coordinator_->wait_for_err("is expelled; its 0 leases go to others", kPatience));

  // With a token that nobody who was put out knew, and a key of its own: whose name is another.
  const auto again = worker(of_others, here() / "anew");
  EXPECT_TRUE(again->wait_for_err("registered with", kPatience)) << again->err();
}

TEST_F(Join, EveryLineOfAJsonLogIsAnObject) {
  const auto newcomer = worker(token({"--for", "10m", "--uses", "2"}), here() / "mine", "json");
  const support::Finished image =
      as("admin", {"submit", "scenes/cornell-box/scene.pbrt", "--resolution", "32x32", "--spp", "1",
                   "--quiet", "-o", (here() / "image.exr").string()});
  ASSERT_EQ(image.status.code, 0) << image.err;
  ASSERT_TRUE(newcomer->wait_for_err("rendered", kPatience));
  newcomer->send_signal(SIGTERM);
  ASSERT_TRUE(newcomer->wait(kPatience));
  coordinator_->send_signal(SIGTERM);
  ASSERT_TRUE(coordinator_->wait(kPatience));
  int units = 0;
  for (const std::string& log : {coordinator_->err(), newcomer->err()}) {
    std::istringstream lines{log};
    for (std::string line; std::getline(lines, line);) {
      const nlohmann::json object = nlohmann::json::parse(line, nullptr, /*allow_exceptions=*/false);
      ASSERT_TRUE(object.is_object()) << line;
      for (const char* field : {"time", "level", "program", "message"})
        EXPECT_TRUE(object.contains(field)) << line;
      if (!object.contains("unit")) continue;
      ++units;
      for (const char* field : {"job", "attempt", "worker"}) EXPECT_TRUE(object.contains(field)) << line;
      EXPECT_EQ(object["worker"], "newcomer");
    }
  }
  EXPECT_GE(units, 2);  // rendered there, accepted here
}

}  // namespace
}  // namespace tessera::integration
