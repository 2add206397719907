// tessera-worker: leases tiles from a coordinator and renders them.
#include <pthread.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <iostream>
#include <optional>
#include <thread>

#include "absl/strings/str_join.h"
#include "agent/agent.h"
#include "agent/link/grpc_link.h"
#include "agent/link/join.h"
#include "agent/metrics.h"
#include "agent/stores/blob_cache.h"
#include "base/address.h"
#include "base/freed_memory.h"
#include "net/channel.h"
#include "net/grpc_log.h"
#include "options/program.h"
#include "telemetry/log.h"
#include "telemetry/metrics_server.h"
#include "telemetry/recent_lines.h"
#include "wire/limits.h"
#include "wire/version.h"

namespace tessera {
namespace {

enum ExitCode { kDone = 0, kUsage = 2, kUnreachable = 4, kInterrupted = 130 };

struct Options {
  std::string server = "127.0.0.1:7070";
  int threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  std::string cache = agent::default_cache_dir().string();
  std::uint64_t cache_gigabytes = 64;
  std::string isa;
  std::string name;
  std::vector<std::string> tags;
  telemetry::LogOptions log{.program = "tessera-worker"};
  int grace_seconds = 1;
  int unit_limit_seconds = 4 * 3600;
  double memory_gigabytes = 0;
  std::string certificates;
  std::string join_token;
  std::string metrics;
  bool allow_insecure = false;
};

void define_connection_options(options::Command& command, Options& options) {
  command.group("Coordinator");
  command.add("--server", options.server, "the coordinator")
      .type_name("HOST:PORT")
      .from_environment("TESSERA_SERVER")
      .required();
  const auto tls = command.add("--tls", options.certificates, "a worker's certificates")
                       .type_name("DIR")
                       .from_environment("TESSERA_TLS");
  command
      .add("--join", options.join_token,
           "token (tessera token) by which to get certificates, if that folder has none")
      .type_name("TOKEN")
      .from_environment("TESSERA_JOIN")
      .needs(tls);
  command.add_flag("--allow-insecure", options.allow_insecure, "talk without encryption to another machine");
  command.add("--name", options.name, "name in the coordinator's list (default: host:pid)").type_name("NAME");
  command.add("--tag", options.tags, "tags that jobs may require (tessera submit --require)")
      .separated_by_commas()
      .type_name("TAG,...");
}

void define_options(options::Command command, Options& options) {
  define_connection_options(command, options);
  command.group("Rendering");
  command.add("--threads", options.threads, "tiles rendered at once")
      .in_range(1, 1024)
      .with_default("one a hardware thread");
  command.add("--isa", options.isa, "kernels to use").type_name("NAME").one_of(render::supported_isas());
  command.group("Limits");
  command.add("--cache", options.cache, "folder for meshes and textures").type_name("DIR").with_default();
  command.add("--cache-size", options.cache_gigabytes, "upper bound of the cache (GB)")
      .type_name("GB")
      .in_range(1, 1 << 20)
      .with_default();
  command.add("--grace", options.grace_seconds, "time for tiles in progress after SIGTERM (s)")
      .type_name("SECONDS")
      .in_range(0, 3600)
      .with_default();
  command.add("--unit-limit", options.unit_limit_seconds, "time limit of one lease (s); 0: none")
      .type_name("SECONDS")
      .in_range(0, 30 * 24 * 3600)
      .with_default();
  command
      .add("--memory-limit", options.memory_gigabytes,
           "memory limit (GB); a scene that needs more fails by name (default: none)")
      .type_name("GB")
      .in_range(0.25, 1e6);
  command.group("Log and metrics");
  command.add("--log-level", options.log.level, "least level of messages on standard error")
      .type_name("LEVEL")
      .one_of(telemetry::kLogLevels)
      .with_default();
  command.add("--log-format", options.log.format, "lines for people, or one JSON object a line")
      .type_name("FORMAT")
      .one_of(telemetry::kLogFormats)
      .with_default();
  command.add("--metrics", options.metrics, "address of Prometheus metrics, at /metrics")
      .type_name("ADDR:PORT");
  command.example("tessera-worker --server 127.0.0.1:7070");
  command.example("tessera-worker --server 10.0.0.1:7070 --tls ~/farm-tls/worker --threads 8");
}

std::string host_name() {
  char host[256] = "unknown";
  ::gethostname(host, sizeof(host) - 1);
  return host;
}

std::string worker_name(const Options& options) {
  return options.name.empty() ? host_name() + ":" + std::to_string(::getpid()) : options.name;
}

agent::AgentOptions agent_options(const Options& options,
                                  const std::shared_ptr<telemetry::RecentLines>& lines) {
  agent::AgentOptions result;
  result.name = worker_name(options);
  result.host = options.name.empty() ? host_name() : options.name;
  result.tags = options.tags;
  result.threads = options.threads;
  result.isas = options.isa.empty() ? render::supported_isas() : std::vector{options.isa};
  result.arithmetic_classes = render::arithmetic_classes(result.isas);
  result.load_scene = render::load_scene;
  result.cache_dir = options.cache;
  result.cache_cap_bytes = options.cache_gigabytes * 1'000'000'000;
  result.unit_limit = std::chrono::seconds{options.unit_limit_seconds};
  result.grace = std::chrono::seconds{options.grace_seconds};
  result.recent_log = [lines](const std::string& job) { return lines->last_about(job, wire::kMaxTextBytes); };
  return result;
}

/// Limits memory that is not a file's: those are the cache's, which the system may drop at any time. Beyond
/// it allocations fail, which is an error of the unit.
void limit_memory(double gigabytes) {
  const auto bytes = static_cast<rlim_t>(gigabytes * 1e9);
  const rlimit limit{bytes, bytes};
  if (::setrlimit(RLIMIT_DATA, &limit) != 0) spdlog::warn("--memory-limit: {}", std::strerror(errno));
}

sigset_t stop_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  return signals;
}

/// Asks for a stop at the first signal, and ends the program at the second; the coordinator then notices by
/// itself. Needs the signals blocked in every thread.
void wait_for_signal(std::stop_token done, std::stop_source stop) {
  const sigset_t signals = stop_signals();
  const timespec patience{0, 200'000'000};
  while (!done.stop_requested()) {
    if (const int signal = sigtimedwait(&signals, nullptr, &patience); signal > 0) {
      if (stop.stop_requested()) _exit(kInterrupted);
      spdlog::info("{}: finishing what was begun", signal == SIGTERM ? "SIGTERM" : "SIGINT");
      stop.request_stop();
    }
  }
}

absl::Status join_where_asked(const Options& options) {
  if (options.join_token.empty()) return absl::OkStatus();
  return agent::join_farm({.server = options.server,
                           .token = options.join_token,
                           .machine_name = host_name(),
                           .certificate_folder = options.certificates});
}

/// Null when nobody asked for them.
absl::StatusOr<std::unique_ptr<telemetry::MetricsServer>> serve_metrics(const Options& options,
                                                                        const agent::Agent& agent) {
  if (options.metrics.empty()) return nullptr;
  auto server = telemetry::MetricsServer::start(options.metrics, {agent::agent_metrics(agent)});
  if (server.ok()) spdlog::info("metrics on port {}", (*server)->port());
  return server;
}

int run_worker(const Options& options, const std::shared_ptr<telemetry::RecentLines>& lines) {
  if (const absl::Status joined = join_where_asked(options); !joined.ok()) {
    spdlog::error("{}", std::string(joined.message()));
    return absl::IsInvalidArgument(joined) ? kUsage : kUnreachable;
  }
  const auto channel = net::make_channel(
      options.server, {.allow_insecure = options.allow_insecure, .certificates = options.certificates});
  if (!channel.ok()) {
    std::cerr << "tessera-worker: " << channel.status().message() << '\n';
    return absl::IsInvalidArgument(channel.status()) ? kUsage : kUnreachable;
  }
  if (options.memory_gigabytes > 0) limit_memory(options.memory_gigabytes);
  const agent::AgentOptions worker = agent_options(options, lines);
  if (worker.isas.empty()) {
    std::cerr << "tessera-worker: " << render::why_no_kernels() << '\n';
    return kUsage;
  }
  for (const std::string& fault : render::refused_kernels()) spdlog::warn("{}", fault);
  auto agent = agent::Agent::create(std::make_unique<agent::GrpcLink>(*channel, options.server), worker);
  if (!agent.ok()) {
    std::cerr << "tessera-worker: " << agent.status().message() << '\n';
    return kUsage;
  }
  const auto metrics = serve_metrics(options, **agent);
  if (!metrics.ok()) {
    spdlog::error("{}", std::string(metrics.status().message()));
    return kUsage;
  }
  std::stop_source stop;
  std::jthread signals{wait_for_signal, stop};
  spdlog::info("tessera-worker {} ({}): {} threads, {}, cache {}, coordinator {}", wire::build_version(),
               worker.name, worker.threads, absl::StrJoin(worker.arithmetic_classes, " "), options.cache,
               options.server);
  const absl::Status status = (*agent)->run(stop.get_token());
  const agent::AgentReport report = (*agent)->report();
  spdlog::info(
      "{} units rendered, {} stopped, {} results delivered; {} scenes loaded, {} of them upon another's "
      "geometry; {} "
      "of {} "
      "bytes downloaded",
      report.units_rendered, report.units_stopped, report.results_acknowledged, report.scenes_loaded,
      report.scenes_shared, report.downloaded_bytes, report.referenced_bytes);
  if (!status.ok()) {
    spdlog::error("{}", status.ToString());
    return kUnreachable;
  }
  return kDone;
}

}  // namespace
}  // namespace tessera

int main(int argc, char** argv) {
  const sigset_t signals = tessera::stop_signals();
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  tessera::base::keep_freed_memory();

  tessera::Options options;
  {
    tessera::options::Program program{"tessera-worker", "Renders tiles for a coordinator.",
                                      tessera::wire::build_version()};
    tessera::define_options(program.root(), options);
    if (const std::optional<int> ended = program.parse(argc, argv)) return *ended;
  }
  options.log.worker = tessera::worker_name(options);
  tessera::telemetry::set_up_log(options.log);
  const auto lines = tessera::telemetry::keep_recent_lines();
  tessera::net::log_grpc();
  return tessera::run_worker(options, lines);
}
