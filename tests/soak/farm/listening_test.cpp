// A coordinator whose port strangers want to close: more connections than descriptors, and a listening socket
// that fails.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "integration/farm_under_test.h"
#include "support/process/idle_connections.h"
#include "support/process/temp_dir.h"

namespace tessera::integration {
namespace {

using testing::HasSubstr;

constexpr std::size_t kDescriptors = 256;  // limit of the coordinator
constexpr std::size_t kStrangers = 600;

Arguments with_few_descriptors() {
  return {"/bin/bash", "-c", "ulimit -n " + std::to_string(kDescriptors) + "; exec \"$@\"", "bash"};
}

support::Finished jobs(const FarmUnderTest& farm) { return tessera(farm.on_farm({"jobs"})); }

TEST(Listening, GoesOnWithMoreIdleConnectionsThanDescriptors) {
  FarmUnderTest farm{with_few_descriptors()};
  EXPECT_THAT(farm.coordinator().err(), HasSubstr("256 descriptors: at most 192 connections"));
  support::Process& worker = farm.add_worker(1);
  ASSERT_TRUE(worker.wait_for_err("registered with", kPatience)) << worker.err();

  support::IdleConnections idle{farm.address()};
  idle.open(kStrangers);
  // A newcomer of the same address, the worker that was there, and files: blobs, journal, results.
  const support::Finished during = jobs(farm);
  EXPECT_EQ(during.status.code, 0) << during.err;
  const Arguments job{"scenes/cornell-box/scene.pbrt", "--resolution", "32x32", "--spp", "4", "--quiet"};
  EXPECT_EQ(farm.fetch_hash(farm.submit_detached(job)), expected_hash(job));
  idle.open(kStrangers);
  idle.close_all();
  const support::Finished after = jobs(farm);
  EXPECT_EQ(after.status.code, 0) << after.err;
  EXPECT_THAT(farm.coordinator().err(), testing::Not(HasSubstr("cannot be accepted")))
      << "some were kept back";
  EXPECT_THAT(farm.coordinator().err(), HasSubstr("is refused: too many connections from this address"));
}

TEST(Listening, TheAddressOfAFailedHandshakeIsLogged) {
  const support::TempDir directory;
  const std::string tls = (directory.path() / "tls").string();
  const support::Finished made = support::run_program({server_program(), "--init-tls", tls}, kPatience);
  ASSERT_EQ(made.status.code, 0) << made.err;
  support::Process coordinator{Arguments{server_program(), "--listen", "127.0.0.1:0", "--data",
                                         (directory.path() / "data").string(), "--tls", tls + "/server"}};
  const auto address = coordinator.wait_for_line("listening on 127.0.0.1:", kPatience);
  ASSERT_TRUE(address) << coordinator.err();
  const support::Finished stranger = support::run_program(
      {"/bin/bash", "-c", "exec 3<>/dev/tcp/127.0.0.1/" + *address + "; echo this is no TLS >&3; cat <&3"},
      kPatience);
  ASSERT_EQ(stranger.status.code, 0) << stranger.err;
  EXPECT_TRUE(coordinator.wait_for_err("ended before any call: a failed handshake", kPatience))
      << coordinator.err();
  EXPECT_THAT(coordinator.err(), testing::ContainsRegex("ended before any call.*peer=127.0.0.1:[0-9]+"));
}

}  // namespace
}  // namespace tessera::integration
