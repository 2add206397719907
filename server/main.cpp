// tessera-server: the coordinator.
#include <pthread.h>
#include <signal.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <thread>

#include "absl/synchronization/mutex.h"
#include "service/coordinator.h"
#include "tls/authority.h"
#include "wire/grpc_log.h"
#include "wire/log.h"
#include "wire/version.h"

namespace {

enum ExitCode { kDone = 0, kUsage = 2, kNotAllowed = 4, kFailed = 5 };

ExitCode exit_code(const absl::Status& status) {
  switch (status.code()) {
    case absl::StatusCode::kOk:
      return kDone;
    case absl::StatusCode::kInvalidArgument:
      return kUsage;
    case absl::StatusCode::kUnavailable:
    case absl::StatusCode::kPermissionDenied:
      return kNotAllowed;
    default:
      return kFailed;
  }
}

// Workers of one machine room start within it.
constexpr std::chrono::milliseconds kSettle{1000};

/// $XDG_STATE_HOME/tessera or ~/.local/state/tessera; empty when neither variable is set.
std::filesystem::path default_data_dir() {
  const char* const state = std::getenv("XDG_STATE_HOME");
  if (state != nullptr && *state != '\0') return std::filesystem::path(state) / "tessera";
  const char* const home = std::getenv("HOME");
  if (home != nullptr && *home != '\0') return std::filesystem::path(home) / ".local" / "state" / "tessera";
  return {};
}

/// Serves until SIGTERM or SIGINT, or until the coordinator ends by itself. Both signals must be blocked.
absl::Status serve(tessera::server::Coordinator& coordinator, const sigset_t& signals) {
  absl::Status status;
  const pthread_t self = pthread_self();
  std::thread waiting([&] {
    status = coordinator.wait();
    pthread_kill(self, SIGTERM);  // ends the sigwait below, where it still waits
  });
  int signal = 0;
  sigwait(&signals, &signal);
  spdlog::info("shutting down");
  coordinator.request_shutdown();
  waiting.join();
  return status;
}

}  // namespace

int main(int argc, char** argv) {
  // Debian's Abseil looks for cycles of locks each time that one is taken, and gRPC takes many.
  absl::SetMutexDeadlockDetectionMode(absl::OnDeadlockCycle::kIgnore);
  tessera::server::CoordinatorOptions options;
  options.listen = "127.0.0.1:7070";
  options.data_dir = default_data_dir();
  tessera::wire::LogOptions log{.program = "tessera-server"};

  CLI::App app("The coordinator of a Tessera farm: keeps jobs, hands out tiles to workers, stores their results.");
  app.set_version_flag("--version", std::string("tessera-server ") + tessera::wire::build_version());
  app.add_option("--listen", options.listen, "ADDR:PORT to serve on; port 0 takes a free one")->capture_default_str();
  app.add_option("--data", options.data_dir, "Directory for the journal, results and blobs")->capture_default_str();
  app.add_flag("--accept-loss", options.accept_loss,
               "Start although the data lacks something that was acknowledged, and go on with what there is");
  app.add_option("--log-level", log.level, "What goes to standard error")
      ->check(CLI::IsMember(tessera::wire::kLogLevels))
      ->capture_default_str();
  app.add_option("--log-format", log.format, "Lines for people, or one JSON object a line")
      ->check(CLI::IsMember(tessera::wire::kLogFormats))
      ->capture_default_str();
  double keep_days = 1, keep_unfetched_days = 30;
  double max_gigabytes = 1000;
  app.add_option("--keep-days", keep_days, "Days after which a finished job is deleted when a client has its image")
      ->check(CLI::Range(0.0, 36500.0))
      ->capture_default_str();
  app.add_option("--keep-unfetched-days", keep_unfetched_days, "The same for jobs whose image nobody fetched")
      ->check(CLI::Range(0.0, 36500.0))
      ->capture_default_str();
  app.add_option("--max-results", max_gigabytes, "GB of results, beyond which fetched jobs are deleted earlier")
      ->check(CLI::Range(0.0, 1e9))
      ->capture_default_str();
  std::optional<double> keep_free_gigabytes;
  app.add_option(
         "--keep-free", keep_free_gigabytes,
         "GB of the data's disk that uploads and new jobs leave to results (default: a twentieth, at most 2 GB)")
      ->check(CLI::Range(0.0, 1e9));
  std::string bits = "same";
  app.add_option("--bits", bits,
                 "For jobs that do not say: same (all of an image by machines that round alike) or any (every machine "
                 "works)")
      ->check(CLI::IsMember({"same", "any"}))
      ->capture_default_str();
  app.add_option("--isa", options.isa, "For jobs that do not say: kernels that workers must use (default: any)")
      ->check(CLI::IsMember({"avx512", "avx2", "neon"}));
  app.add_option("--metrics", options.metrics, "ADDR:PORT to serve Prometheus metrics on, at /metrics");
  app.add_option("--health", options.health, "ADDR:PORT to answer gRPC health checks on, without certificates");
  app.add_option("--tls", options.certificates, "Folder with the server's certificates: encrypts, and checks who calls")
      ->type_name("DIR");
  app.add_option("--join-authority", options.join_authority,
                 "Folder with the authority's key: workers may join with a token (tessera token). Needs --tls")
      ->type_name("DIR");
  app.add_option("--join-listen", options.join_listen,
                 "ADDR:PORT where they do, without a certificate (default: the port behind that of --listen)");
  app.add_flag("--share-jobs", options.share_jobs, "Clients may see and change each other's jobs");
  std::string new_certificates;
  std::vector<std::string> hosts, users;
  CLI::Option* const init = app.add_option("--init-tls", new_certificates,
                                           "Make the farm's certificates in this folder, or renew them, and leave");
  init->type_name("DIR");
  app.add_option("--tls-host", hosts, "With --init-tls: a name or an address that this server is called by")
      ->needs(init);
  app.add_option("--tls-user", users, "With --init-tls: a user to make a client's certificate for")->needs(init);
  app.add_flag("--allow-insecure", options.allow_insecure,
               "Serve without encryption on an address that is not loopback");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kDone : kUsage;
  }
  options.same_bits = bits == "same";
  options.settle = kSettle;
  options.keep_fetched = std::chrono::seconds(static_cast<std::int64_t>(keep_days * 86400));
  options.keep_unfetched = std::chrono::seconds(static_cast<std::int64_t>(keep_unfetched_days * 86400));
  options.max_result_bytes = static_cast<std::uint64_t>(max_gigabytes * 1e9);
  if (keep_free_gigabytes) options.keep_free_bytes = static_cast<std::uint64_t>(*keep_free_gigabytes * 1e9);
  tessera::wire::set_up_log(log);
  tessera::wire::log_grpc();
  if (!new_certificates.empty()) {
    const absl::Status status = tessera::server::write_farm_certificates(new_certificates, hosts, users);
    if (!status.ok()) spdlog::error("{}", std::string(status.message()));
    return exit_code(status);
  }
  if (options.data_dir.empty()) {
    spdlog::error("neither XDG_STATE_HOME nor HOME is set; say with --data where to keep the state");
    return kUsage;
  }
  if (options.listen.empty()) {
    spdlog::error("--listen is empty; expected ADDR:PORT");
    return kUsage;
  }

  // Blocked before any thread starts, so that only sigwait sees them.
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);

  auto coordinator = tessera::server::Coordinator::start(options);
  if (!coordinator.ok()) {
    spdlog::error("{}", std::string(coordinator.status().message()));
    return exit_code(coordinator.status());
  }
  // Scripts wait for this line.
  const std::string host = options.listen.substr(0, options.listen.rfind(':'));
  std::printf("listening on %s:%d\n", host.c_str(), (*coordinator)->bound_port());
  std::fflush(stdout);
  if (const int port = (*coordinator)->join_port(); port != 0) spdlog::info("workers join on port {}", port);
  if (const int port = (*coordinator)->metrics_port(); port != 0) spdlog::info("metrics on port {}", port);
  if (const int port = (*coordinator)->health_port(); port != 0) spdlog::info("health checks on port {}", port);
  spdlog::info("data directory {}", options.data_dir.string());

  const absl::Status status = serve(**coordinator, signals);
  if (!status.ok()) spdlog::error("{}", std::string(status.message()));
  return exit_code(status);
}
