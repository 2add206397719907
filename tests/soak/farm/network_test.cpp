// A network that loses packets both ways or one way, closes connections, or flips bits. TESSERA_CUT_SECONDS=N
// in the environment cuts for that long (600 takes an hour).
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <functional>
#include <optional>
#include <thread>
#include <vector>

#include "integration/farm_under_test.h"
#include "support/long_form.h"
#include "support/process/network_namespace.h"
#include "support/process/tcp_proxy.h"

namespace tessera::integration {
namespace {

using std::chrono::seconds;
using support::TcpProxy;

// Some seconds of work in many units.
const Arguments kJobOverTheNetwork = in_many_units("128", "256");

/// Whether a program ended by a name, or by an assertion of gRPC 1.51, which dies of an answer whose
/// grpc-status did not arrive: a wire without TLS cannot keep it from that.
bool ended_as_expected(const support::ExitStatus& end, const std::string& err) {
  return end.signal == 0 ? end.code > 0 && !err.empty()
                         : end.signal == SIGABRT && err.find("absl::") != std::string::npos;
}

/// Cuts the farm's one worker off in the midst of a job, for longer and for less long than its leases last.
void cut_off(FarmUnderTest& farm, const std::function<void()>& begin, const std::function<void()>& end) {
  std::vector<int> durations{static_cast<int>(test::how_often("TESSERA_CUT_SECONDS", 3, 0))};
  if (test::long_form()) durations = {1, 12};
  for (const int duration : durations) {
    const std::string job_id = farm.submit_detached(kJobOverTheNetwork + Arguments{"--fresh"});
    farm.watch_until(job_id, a_quarter_is_done);
    begin();
    std::this_thread::sleep_for(seconds{duration});
    end();
    const v1::JobStatus last = farm.watch_until(job_id, [](const v1::JobStatus&) { return false; });
    EXPECT_EQ(last.state(), v1::DONE) << last.error() << farm.worker(0).err();
    EXPECT_EQ(last.set_aside_size(), 0);
    EXPECT_EQ(farm.fetch_hash(job_id), expected_hash(kJobOverTheNetwork)) << "after " << duration << " s";
  }
}

class Network : public testing::Test {
 protected:
  Network() : proxy_(std::stoi(farm_.address().substr(farm_.address().rfind(':') + 1))) {
    farm_.add_worker(WorkerSetup{.server = proxy_.address()});
  }

  /// Nobody starts the coordinator again, whatever the network does.
  void TearDown() override {
    const std::optional<support::ExitStatus> end = farm_.coordinator().wait(std::chrono::milliseconds{0});
    EXPECT_FALSE(end) << "the coordinator ended: exit code " << end->code << ", signal " << end->signal
                      << "\n"
                      << farm_.coordinator().err();
  }

  void cut(TcpProxy::Fault fault) {
    cut_off(
        farm_, [&] { proxy_.set_fault(fault); }, [&] { proxy_.set_fault(TcpProxy::Fault::kNone); });
  }

  /// Starts the worker again whenever it has ended, as a service manager does, until `stop`; returns how
  /// often.
  int supervise(std::stop_token stop) {
    int ends = 0;
    while (!stop.stop_requested()) {
      const std::optional<support::ExitStatus> end = farm_.worker(0).wait(std::chrono::milliseconds{200});
      if (!end) continue;
      ++ends;
      const std::string err = farm_.worker(0).err();
      EXPECT_TRUE(ended_as_expected(*end, err))
          << "exit code " << end->code << ", signal " << end->signal << "\n"
          << err;
      farm_.restart_worker(0);
    }
    return ends;
  }

  FarmUnderTest farm_;
  TcpProxy proxy_;
};

TEST_F(Network, LosesEverythingForAWhile) { cut(TcpProxy::Fault::kSilence); }
TEST_F(Network, LosesWhatTheWorkerSays) { cut(TcpProxy::Fault::kDeaf); }
TEST_F(Network, LosesWhatTheCoordinatorSays) { cut(TcpProxy::Fault::kMute); }
TEST_F(Network, RefusesConnectionsForAWhile) { cut(TcpProxy::Fault::kRefusing); }

/// Or given up meanwhile. Half a second is what may have been on its way.
void expect_not_heard_of_since(FarmUnderTest& farm, std::chrono::steady_clock::time_point begun) {
  const auto silence = std::chrono::steady_clock::now() - begun - std::chrono::milliseconds{500};
  const auto workers = farm.client().workers({});
  ASSERT_TRUE(workers.ok()) << workers.status();
  for (const v1::WorkerStatus& worker : *workers) {
    EXPECT_GE(std::chrono::milliseconds{worker.last_seen_ms_ago()}, silence) << "packets still arrive";
  }
}

/// The same with packets that are lost, where the machine lets the test make a network.
TEST(Packets, AreLostOnTheirWayInOutAndBothWays) {
  std::optional<support::NetworkNamespace> network;
  try {
    network.emplace();
  } catch (const std::exception& error) {
    GTEST_SKIP() << "no network of its own: " << error.what();
  }
  FarmUnderTest farm{{}, {}, network->outer_address()};
  farm.add_worker(WorkerSetup{.wrapper = network->wrapper()});
  struct Loss {
    bool in, out;
  };
  for (const Loss loss : {Loss{true, true}, Loss{true, false}, Loss{false, true}}) {
    std::chrono::steady_clock::time_point begun;
    cut_off(
        farm,
        [&] {
          network->lose(loss.in, loss.out);
          begun = std::chrono::steady_clock::now();
        },
        [&] {
          if (loss.out) expect_not_heard_of_since(farm, begun);
          network->lose(false, false);
        });
    if (!test::long_form()) return;
    // Longer than the worker's leases: what it said did not arrive.
    if (loss.in && loss.out) {
      EXPECT_TRUE(farm.coordinator().wait_for_err("was lost", kPatience));
    }
  }
}

TEST_F(Network, FlipsBitsAndTheImageIsTheSame) {
  // Nothing but the digests of blobs and the checksums of results protects what TCP lets pass.
  ASSERT_TRUE(farm_.worker(0).wait_for_err("registered with", kPatience)) << farm_.worker(0).err();
  proxy_.flip_a_bit_in(test::long_form() ? 6'000 : 20'000);
  // A bit in a name or a number is a job that nobody knows, or a unit that fails: the job may end incomplete.
  const std::string job_id = farm_.submit_detached(kJobOverTheNetwork);
  int ends = 0;
  std::jthread manager{[&](std::stop_token stop) { ends = supervise(stop); }};
  v1::JobStatus end = farm_.watch_until(job_id, [](const v1::JobStatus&) { return false; });
  proxy_.flip_a_bit_in(0);
  manager.request_stop();
  manager.join();
  if (end.state() == v1::INCOMPLETE) {
    ASSERT_TRUE(farm_.client().retry(job_id, {}).ok());
    end = farm_.watch_until(job_id, [](const v1::JobStatus&) { return false; });
  }
  EXPECT_EQ(end.state(), v1::DONE) << end.error() << farm_.worker(0).err();
  EXPECT_EQ(farm_.fetch_hash(job_id), expected_hash(kJobOverTheNetwork));
  EXPECT_GT(proxy_.flipped(), 0U);
  std::printf("%d bits flipped; the worker was started again %d times\n", static_cast<int>(proxy_.flipped()),
              ends);
}

TEST_F(Network, FlipsBitsOfAnImageOnItsWay) {
  farm_.add_worker(1);
  const std::string job_id = farm_.submit_detached(kJobOverTheNetwork);
  farm_.watch_until(job_id, [](const v1::JobStatus&) { return false; });
  proxy_.flip_a_bit_in(30'000);
  const std::string image = (farm_.directory() / "image.exr").string();
  int whole = 0, refused = 0;
  for (int attempt = 0; attempt < (test::long_form() ? 40 : 8); ++attempt) {
    const support::Finished done =
        tessera({"fetch", job_id, "-o", image, "--quiet", "--server", proxy_.address()});
    if (done.status.code == 0) {
      ++whole;
      EXPECT_EQ(pixel_sha256(image), expected_hash(kJobOverTheNetwork));
    } else {
      ++refused;
      EXPECT_TRUE(ended_as_expected(done.status, done.err)) << "signal " << done.status.signal << "\n"
                                                            << done.err;
    }
  }
  std::printf("%d images were whole, %d refused by name; %d bits flipped\n", whole, refused,
              static_cast<int>(proxy_.flipped()));
}

}  // namespace
}  // namespace tessera::integration
