#include "local/local_farm.h"

#include <spdlog/spdlog.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <optional>
#include <thread>
#include <utility>

#include "agent/agent.h"
#include "local/bench_scene.h"
#include "local/local_calls.h"
#include "local/local_link.h"
#include "local/scene_blobs.h"
#include "service/coordinator.h"

namespace tessera::client {

struct LocalFarm::Parts {
  std::shared_ptr<SceneBlobs> blobs;
  std::unique_ptr<server::Coordinator> coordinator;
  std::jthread failure;  // waits for the coordinator's
  std::optional<LocalCalls> calls;
  std::unique_ptr<agent::Agent> agent;
  std::shared_ptr<std::atomic<bool>> building = std::make_shared<std::atomic<bool>>(false);
  std::stop_source ends;
  std::jthread worker;

  /// The worker goes first.
  ~Parts() {
    ends.request_stop();
    if (worker.joinable()) worker.request_stop(), worker.join();
    if (coordinator != nullptr) coordinator->request_shutdown();
  }
};

std::vector<std::string> local_isas() { return render::supported_isas(); }

absl::StatusOr<std::unique_ptr<LocalFarm>> LocalFarm::start(LocalFarmOptions options) {
  // All events reach the user as the job's status; coordinator and worker have nobody to write a log
  // for.
  spdlog::set_level(spdlog::level::off);
  if (options.isa.empty() && render::supported_isas().empty()) {
    return absl::FailedPreconditionError(render::why_no_kernels());
  }
  auto parts = std::make_unique<Parts>();
  parts->blobs = std::make_shared<SceneBlobs>(options.blobs);

  server::CoordinatorOptions coordinator_options;
  coordinator_options.blobs = parts->blobs;
  coordinator_options.data_dir = options.checkpoint;
  coordinator_options.takes_messages = false;
  if (options.web) coordinator_options.web = "127.0.0.1:0";
  // Results that a checkpoint has lost are rendered again, and it is deleted by whoever made it.
  coordinator_options.accept_loss = true;
  // Somebody watches, and Ctrl-C keeps what is done.
  coordinator_options.longest_run = std::chrono::seconds{1};
  coordinator_options.keep_fetched = coordinator_options.keep_unfetched = std::chrono::hours{24 * 36500};
  absl::StatusOr<std::unique_ptr<server::Coordinator>> coordinator =
      server::Coordinator::start(std::move(coordinator_options));
  if (!coordinator.ok()) return coordinator.status();
  parts->coordinator = *std::move(coordinator);
  parts->calls.emplace(parts->coordinator->farm());
  parts->failure = std::jthread{[&farm = *parts->coordinator, failed = std::move(options.failed)] {
    if (const absl::Status status = farm.wait(); !status.ok() && failed) failed(status);
  }};

  agent::AgentOptions agent_options;
  agent_options.name = "local";
  agent_options.threads = options.threads;
  agent_options.isas = options.isa.empty() ? render::supported_isas() : std::vector{options.isa};
  agent_options.arithmetic_classes = render::arithmetic_classes(agent_options.isas);
  agent_options.load_scene = [geometry_read = std::move(options.geometry_read), building = parts->building,
                              built = std::move(options.built), ends = parts->ends.get_token()](
                                 const v1::Scene& scene, const v1::JobSpec& job,
                                 const render::BlobSource& blobs, render::LoadOptions load_options) {
    load_options.geometry_read = geometry_read;
    // The job's other units need the scene, too, and there is no second time once its meshes are freed: a
    // unit that is revoked (the checkpoint's former job was, on behalf of the new one) does not end the
    // build.
    load_options.stop = ends;
    if (built != nullptr) load_options.contents = built->contents.get();
    *building = true;
    auto loaded = render::load_scene(scene, job, blobs, load_options);
    *building = false;
    return loaded;
  };
  agent_options.blobs = [blobs = parts->blobs](const std::string& digest) { return blobs->bytes(digest); };
  agent_options.plain_results = options.checkpoint.empty();
  agent_options.grace = std::chrono::milliseconds{0};
  absl::StatusOr<std::unique_ptr<agent::Agent>> agent = agent::Agent::create(
      std::make_unique<LocalLink>(parts->coordinator->farm(), *parts->blobs), std::move(agent_options));
  if (!agent.ok()) return agent.status();
  parts->agent = *std::move(agent);
  // Its status is of no use here: a worker that cannot register leaves the job waiting only until the farm is
  // stopped.
  parts->worker =
      std::jthread{[&worker = *parts->agent](std::stop_token stop) { static_cast<void>(worker.run(stop)); }};
  return std::unique_ptr<LocalFarm>{new LocalFarm{std::move(parts)}};
}

LocalFarm::LocalFarm(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
LocalFarm::~LocalFarm() = default;

JobCalls& LocalFarm::calls() { return *parts_->calls; }

int LocalFarm::web_port() const { return parts_->coordinator->web_port(); }

bool LocalFarm::building() const { return *parts_->building; }

double LocalFarm::build_seconds() const { return parts_->agent->report().build_seconds; }

}  // namespace tessera::client
