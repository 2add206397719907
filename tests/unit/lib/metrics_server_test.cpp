// The port that Prometheus asks, with strangers on it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <prometheus/registry.h>

#include <chrono>
#include <filesystem>
#include <iterator>

#include "absl/strings/str_cat.h"
#include "prometheus/counter.h"
#include "support/process/http_get.h"
#include "support/process/idle_connections.h"
#include "telemetry/metrics_server.h"

namespace tessera::telemetry {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

class MetricsServerTest : public ::testing::Test {
 protected:
  MetricsServerTest() {
    auto registry = std::make_shared<prometheus::Registry>();
    prometheus::BuildCounter()
        .Name("tessera_test_total")
        .Help("for a test")
        .Register(*registry)
        .Add({})
        .Increment(7);
    auto started = MetricsServer::start("127.0.0.1:0", {registry});
    EXPECT_TRUE(started.ok()) << started.status();
    server_ = *std::move(started);
  }

  std::string scrape() const { return support::http_get(server_->port(), "/metrics"); }

  std::unique_ptr<MetricsServer> server_;
};

std::size_t descriptors() {
  const std::filesystem::directory_iterator open{"/proc/self/fd"};
  return static_cast<std::size_t>(std::distance(begin(open), end(open)));
}

TEST_F(MetricsServerTest, ServesWhatPrometheusReads) {
  const std::string answer = scrape();
  EXPECT_THAT(answer, StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(answer, HasSubstr("text/plain; version=0.0.4"));
  EXPECT_THAT(answer, HasSubstr("\n# TYPE tessera_test_total counter\ntessera_test_total 7\n"));
  EXPECT_THAT(support::http_get(server_->port(), "/"), StartsWith("HTTP/1.1 404"));
}

TEST_F(MetricsServerTest, IsScrapedWhileStrangersKeepConnectionsOpen) {
  constexpr std::size_t kStrangers = 600;
  support::IdleConnections idle{absl::StrCat("127.0.0.1:", server_->port())};
  const std::size_t before = descriptors();
  idle.open(kStrangers);
  EXPECT_THAT(scrape(), HasSubstr("tessera_test_total 7"));
  EXPECT_LE(descriptors(), before + kStrangers + MetricsServer::kMostConnections)
      << "the strangers' ends, and its own";
}

TEST_F(MetricsServerTest, AnAddressInUseIsUnavailable) {
  const auto second = MetricsServer::start(absl::StrCat("127.0.0.1:", server_->port()), {});
  EXPECT_TRUE(absl::IsUnavailable(second.status())) << second.status();
  EXPECT_THAT(std::string(second.status().message()), StartsWith("cannot serve metrics on 127.0.0.1:"));
}

}  // namespace
}  // namespace tessera::telemetry
