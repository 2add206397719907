// tessera-server: the coordinator.
#include <pthread.h>
#include <signal.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "absl/strings/str_cat.h"
#include "absl/synchronization/mutex.h"
#include "base/address.h"
#include "net/grpc_log.h"
#include "notify/webhook_message.h"
#include "notify/webhook_url.h"
#include "notify/webhooks.h"
#include "options/program.h"
#include "service/coordinator.h"
#include "telemetry/log.h"
#include "tls/authority.h"
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

struct Options {
  tessera::server::CoordinatorOptions coordinator;
  std::string data_dir = default_data_dir();
  std::string join_authority;
  std::string web;  // empty: not given
  tessera::telemetry::LogOptions log{.program = "tessera-server"};
  double keep_days = 1, keep_unfetched_days = 30;
  double max_gigabytes = 1000;
  std::optional<double> keep_free_gigabytes;
  std::string bits = "same";
  std::string order = "first-come";
  double unit_seconds = 10;
  double unconfirmed_percent = 5;
  double class_patience_seconds = 600;
  std::string new_certificates;  // a folder; empty: none are made
  std::vector<std::string> hosts, users;
  tessera::server::WebhookOptions webhooks;
  std::string webhook_key;  // a file
};

/// Null where nobody is to be told of the ends of jobs.
absl::StatusOr<std::unique_ptr<tessera::server::Webhooks>> make_webhooks(const Options& options) {
  tessera::server::WebhookOptions webhooks = options.webhooks;
  if (webhooks.url.empty() && webhooks.allowed_urls.empty()) return nullptr;
  std::vector<std::string> urls = webhooks.allowed_urls;
  if (!webhooks.url.empty()) urls.push_back(webhooks.url);
  for (const std::string& url : urls) {
    if (absl::Status status = tessera::server::check_url(url); !status.ok()) return status;
  }
  absl::StatusOr<std::string> key = tessera::server::read_webhook_key(options.webhook_key);
  if (!key.ok()) return key.status();
  webhooks.signing_key = *std::move(key);
  return std::make_unique<tessera::server::Webhooks>(std::move(webhooks));
}

/// Tells what --init-tls made, and what is to be done with it.
std::string tell_certificates(const Options& options) {
  const std::string folder = std::filesystem::absolute(options.new_certificates).lexically_normal().string();
  const std::string host = options.hosts.empty() ? "127.0.0.1" : options.hosts.front();
  const std::string address = tessera::base::HostPort{.host = host, .port = 7070}.to_string();
  std::string text = absl::StrCat("made in ", folder, ", valid for 397 days:\n",
                                  "  authority   signs the others: keep it off the network\n",
                                  "  server      for the coordinator\n",
                                  "  worker      for workers: copy it to every machine that renders\n",
                                  "  admin       for who runs the farm (tessera --tls)\n");
  for (const std::string& user : options.users) {
    absl::StrAppend(&text, "  client-", user, "   for ", user, " (tessera --tls, $TESSERA_TLS)\n");
  }
  if (options.users.empty()) text += "  --tls-user NAME adds a folder for a user\n";
  if (options.hosts.empty())
    text += "  --tls-host HOST adds the address by which other machines call the server\n";
  absl::StrAppend(&text, "next:\n  tessera-server --listen ", address, " --tls ", folder, "/server\n",
                  "  tessera-worker --server ", address, " --tls ", folder, "/worker\n",
                  "with systemd, whose units run as the user tessera:\n  sudo chown -R tessera: ", folder,
                  "/server\n");
  return text;
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

/// Options by which clients are bounded, all of them or single ones.
void define_quota_options(tessera::options::Command& command, tessera::server::Quotas& quotas,
                          const tessera::options::Option& tls) {
  command.group("Quotas of clients (NUMBER: all, USER=NUMBER: one); administrators have none");
  const auto add = [&](const char* name, auto& quota, const char* description, auto read) {
    command
        .add_list_read_by(
            name, [&quota, read](const std::string& text) { return read(text, quota); }, [] {}, description)
        .type_name("[USER=]NUMBER")
        .needs(tls);
  };
  const auto number = [](const std::string& text, auto& quota) {
    return tessera::server::read_quota(text, quota);
  };
  add("--max-priority", quotas.priority, "highest priority of their jobs (default: 0)", number);
  add("--max-open-jobs", quotas.open_jobs, "jobs that are not over (default: 10000)", number);
  add("--max-open-units", quotas.units, "units of jobs that are not over (default: 33554432)", number);
  add("--max-blobs", quotas.blob_bytes,
      "GB of scenes, meshes and textures of jobs that are kept, and of uploads (default: half of the disk of "
      "--data)",
      &tessera::server::read_gigabytes);
}

void define_tls_options(tessera::options::Command& command, Options& options) {
  command.group("Encryption");
  const auto tls = command
                       .add("--tls", options.coordinator.certificates,
                            "a server's certificates: encrypts, and authenticates callers")
                       .type_name("DIR");
  command.add_flag("--allow-insecure", options.coordinator.allow_insecure,
                   "serve without encryption on an address that is not loopback");
  command.add_flag("--share-jobs", options.coordinator.share_jobs,
                   "clients may see and change each other's jobs");
  command
      .add("--join-authority", options.join_authority,
           "folder with the authority's key: workers may join with a token (tessera token); needs --tls")
      .type_name("DIR");
  command
      .add("--join-listen", options.coordinator.join_listen,
           "address at which they join, without a certificate (default: the port behind that of --listen)")
      .type_name("ADDR:PORT");
  define_quota_options(command, options.coordinator.quotas, tls);
  command.group("Making certificates, instead of serving");
  const auto init = command
                        .add("--init-tls", options.new_certificates,
                             "make the farm's certificates in this folder, or renew them")
                        .type_name("DIR");
  command.add("--tls-host", options.hosts, "DNS name or address of the server; may be repeated")
      .type_name("HOST")
      .needs(init);
  command.add("--tls-user", options.users, "user to make a client's certificate for; may be repeated")
      .type_name("NAME")
      .needs(init);
}

void define_options(tessera::options::Command command, Options& options) {
  command.group("Serving");
  command.add("--listen", options.coordinator.listen, "address to serve on; port 0 takes a free one")
      .type_name("ADDR:PORT")
      .with_default();
  command.add("--metrics", options.coordinator.metrics, "address of Prometheus metrics, at /metrics")
      .type_name("ADDR:PORT");
  command
      .add(
          "--web", options.web,
          "address of the web page, \"off\" for none (default: 127.0.0.1, ten ports behind that of --listen)")
      .type_name("ADDR:PORT");
  command.add("--health", options.coordinator.health, "address of gRPC health checks, without certificates")
      .type_name("ADDR:PORT");
  command.add("--log-level", options.log.level, "least level of messages on standard error")
      .type_name("LEVEL")
      .one_of(tessera::telemetry::kLogLevels)
      .with_default();
  command.add("--log-format", options.log.format, "lines for people, or one JSON object a line")
      .type_name("FORMAT")
      .one_of(tessera::telemetry::kLogFormats)
      .with_default();
  command.group("Webhooks");
  const auto key = command
                       .add("--webhook-key", options.webhook_key,
                            "file with the key by which messages are signed; for nobody else to read")
                       .type_name("FILE");
  command.add("--webhook", options.webhooks.url, "told of the end of every job, as JSON")
      .type_name("URL")
      .needs(key);
  command
      .add("--webhook-allow", options.webhooks.allowed_urls,
           "address that jobs may have as a webhook of their own, or with / at its end all below it; may be "
           "repeated")
      .type_name("URL")
      .needs(key);
  command.group("Scheduling");
  command
      .add("--order", options.order,
           "a user's jobs of one priority: first-come (the next where one has no units left) or fair "
           "(together)")
      .type_name("ORDER")
      .one_of({"first-come", "fair"})
      .with_default();
  command
      .add("--unit-seconds", options.unit_seconds,
           "duration of a lease on one thread, once the job's cost is known; 0: the smallest unit")
      .type_name("SECONDS")
      .in_range(0, 3600)
      .with_default();
  command
      .add("--unconfirmed-share", options.unconfirmed_percent,
           "per cent of a picture that may rest on one worker's certificate, unless another confirms it")
      .type_name("PERCENT")
      .in_range(0, 100)
      .with_default();
  command
      .add("--class", options.coordinator.classes,
           "arithmetic class (tessera workers) that you vouch for: jobs of same bits may be bound to it "
           "before "
           "results have confirmed it; may be repeated")
      .type_name("CLASS");
  command
      .add("--class-patience", options.class_patience_seconds,
           "seconds without a worker of its class, until a job is rendered anew in another one")
      .type_name("SECONDS")
      .in_range(0, 1e9)
      .with_default();
  command.group("Defaults of jobs");
  command
      .add("--bits", options.bits,
           "same: all of an image by machines that round alike; any: every machine works")
      .type_name("BITS")
      .one_of({"same", "any"})
      .with_default();
  command.add("--isa", options.coordinator.isa, "kernels that workers must use: avx2, avx512 or neon")
      .type_name("NAME")
      .one_of({"avx2", "avx512", "neon"});
  command.group("Storage");
  command.add("--data", options.data_dir, "folder for the journal, results and blobs")
      .type_name("DIR")
      .with_default();
  command.add_flag(
      "--accept-loss", options.coordinator.accept_loss,
      "start even if results or jobs that were acknowledged are missing, and go on with the rest");
  command
      .add("--keep-days", options.keep_days, "days until a finished job is deleted whose image a client has")
      .type_name("DAYS")
      .in_range(0, 36500)
      .with_default();
  command
      .add("--keep-unfetched-days", options.keep_unfetched_days,
           "days until a finished job is deleted whose image nobody fetched")
      .type_name("DAYS")
      .in_range(0, 36500)
      .with_default();
  command
      .add("--max-results", options.max_gigabytes,
           "upper bound of results (GB), beyond which fetched jobs are deleted earlier")
      .type_name("GB")
      .in_range(0, 1e9)
      .with_default();
  command
      .add("--keep-free", options.keep_free_gigabytes,
           "GB of the data's disk that uploads and new jobs leave to results (default: a twentieth, at most "
           "2)")
      .type_name("GB")
      .in_range(0, 1e9);
  define_tls_options(command, options);
  command.example("tessera-server");
  command.example("tessera-server --init-tls ~/farm-tls --tls-host 10.0.0.1 --tls-user $USER");
  command.example("tessera-server --listen 10.0.0.1:7070 --tls ~/farm-tls/server");
}

constexpr int kWebBehind = 10;  // ports behind that of --listen

/// The web page is there unless it is not wanted, and on this machine only unless an address is given.
void set_web(const Options& options, tessera::server::CoordinatorOptions& result) {
  if (!options.web.empty()) {
    result.web = options.web == "off" ? "" : options.web;
    return;
  }
  const auto listen = tessera::base::parse_host_port(options.coordinator.listen);
  if (!listen.ok()) return;  // whoever listens says so
  const int port = listen->port == 0 ? 0 : listen->port + kWebBehind;
  if (port > 65535) return;
  result.web =
      tessera::base::HostPort{.host = "127.0.0.1", .port = static_cast<std::uint16_t>(port)}.to_string();
  result.web_if_free = true;
}

/// Turns the command line's options into the coordinator's.
tessera::server::CoordinatorOptions coordinator_options(const Options& options) {
  tessera::server::CoordinatorOptions result = options.coordinator;
  result.data_dir = options.data_dir;
  result.join_authority = options.join_authority;
  set_web(options, result);
  result.same_bits = options.bits == "same";
  result.settle = kSettle;
  result.order =
      options.order == "fair" ? tessera::server::JobOrder::kFair : tessera::server::JobOrder::kFirstCome;
  result.longest_run = std::chrono::milliseconds(static_cast<std::int64_t>(options.unit_seconds * 1e3));
  result.unconfirmed_share = options.unconfirmed_percent / 100;
  result.class_patience =
      std::chrono::milliseconds(static_cast<std::int64_t>(options.class_patience_seconds * 1e3));
  result.keep_fetched = std::chrono::seconds(static_cast<std::int64_t>(options.keep_days * 86400));
  result.keep_unfetched =
      std::chrono::seconds(static_cast<std::int64_t>(options.keep_unfetched_days * 86400));
  result.max_result_bytes = static_cast<std::uint64_t>(options.max_gigabytes * 1e9);
  if (options.keep_free_gigabytes) {
    result.keep_free_bytes = static_cast<std::uint64_t>(*options.keep_free_gigabytes * 1e9);
  }
  return result;
}

}  // namespace

int main(int argc, char** argv) {
  // Debian's Abseil looks for cycles of locks each time that one is taken, and gRPC takes many.
  absl::SetMutexDeadlockDetectionMode(absl::OnDeadlockCycle::kIgnore);
  Options given;
  given.coordinator.listen = "127.0.0.1:7070";
  {
    tessera::options::Program program{
        "tessera-server",
        "The coordinator of a farm: keeps jobs, hands out tiles to workers, stores their results.",
        absl::StrCat("tessera-server ", tessera::wire::build_version())};
    define_options(program.root(), given);
    if (const std::optional<int> ended = program.parse(argc, argv)) return *ended;
  }
  tessera::server::CoordinatorOptions options = coordinator_options(given);
  tessera::telemetry::set_up_log(given.log);
  options.lines = tessera::telemetry::keep_recent_lines();
  tessera::net::log_grpc();
  if (!given.new_certificates.empty()) {
    const absl::Status status =
        tessera::server::write_farm_certificates(given.new_certificates, given.hosts, given.users);
    if (!status.ok()) spdlog::error("{}", std::string(status.message()));
    if (status.ok()) std::printf("%s", tell_certificates(given).c_str());
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

  const absl::StatusOr<std::unique_ptr<tessera::server::Webhooks>> webhooks = make_webhooks(given);
  if (!webhooks.ok()) {
    spdlog::error("{}", std::string(webhooks.status().message()));
    return kUsage;
  }
  options.listener = webhooks->get();
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
  if (const int port = (*coordinator)->web_port(); port != 0) {
    spdlog::info("web page on port {}{}", port,
                 options.certificates.empty() ? "" : "; tessera token --web logs in");
  }
  if (const int port = (*coordinator)->health_port(); port != 0)
    spdlog::info("health checks on port {}", port);
  spdlog::info("data directory {}", options.data_dir.string());

  const absl::Status status = serve(**coordinator, signals);
  if (!status.ok()) spdlog::error("{}", std::string(status.message()));
  return exit_code(status);
}
