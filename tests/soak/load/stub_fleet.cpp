#include "soak/load/stub_fleet.h"

#include <google/protobuf/util/time_util.h>
#include <grpcpp/grpcpp.h>

#include <algorithm>
#include <deque>
#include <map>
#include <mutex>
#include <thread>
#include <tuple>

#include "net/channel.h"
#include "net/status.h"
#include "tessera/v1/work.grpc.pb.h"
#include "wire/aov_channels.h"
#include "wire/limits.h"
#include "wire/tile_result.h"
#include "wire/version.h"

namespace tessera::load {
namespace {

using google::protobuf::util::TimeUtil;
using Clock = std::chrono::steady_clock;

// Limits of worker/agent: how much a worker holds, how long it asks, and how much it remembers.
constexpr std::size_t kQueuedPerThread = 2;
constexpr std::chrono::seconds kLeaseWait{10};
constexpr std::size_t kKnownJobs = 64;
constexpr std::chrono::milliseconds kRetry{200};

LatencyHistogram::Duration since(Clock::time_point start) {
  return std::chrono::duration_cast<LatencyHistogram::Duration>(Clock::now() - start);
}

/// A connection of its own: channels of equal arguments would share one.
std::shared_ptr<grpc::Channel> connect(const std::string& address) {
  grpc::ChannelArguments arguments = net::channel_arguments();
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  return grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments);
}

/// Half to one and a half times the mean, by the unit alone.
Clock::duration time_of(const v1::WorkUnit& unit, std::chrono::milliseconds mean) {
  return mean * (512 + (unit.index() * 0x9e3779b1u >> 22)) / 1024;
}

}  // namespace

v1::UnitStats stub_stats(std::chrono::milliseconds unit_time) {
  v1::UnitStats stats;
  stats.set_samples(16384);
  stats.set_camera_rays(16384);
  stats.set_bounce_rays(70000);
  stats.set_shadow_rays(80000);
  const std::int64_t ms = std::max<std::int64_t>(unit_time.count(), 1);
  *stats.mutable_wall_time() = *stats.mutable_cpu_time() = TimeUtil::MillisecondsToDuration(ms);
  const auto ns = static_cast<std::uint64_t>(ms) * 100'000;
  for (const char* stage : {"camera", "intersection", "transit", "shading", "shadow", "film", "encode"}) {
    (*stats.mutable_stage_ns())[stage] = ns;
  }
  for (const char* part : {"surfaces", "materials", "light sampling", "paths"}) {
    (*stats.mutable_shading_part_ns())[part] = ns;
  }
  for (const char* material : {"white wall", "red wall", "green wall"})
    (*stats.mutable_material_ns())[material] = ns;
  return stats;
}

std::string stub_result(const v1::WorkUnit& unit) {
  static const std::vector<wire::ChannelDesc> channels = wire::channels_for_aovs({});
  const v1::PixelRect& pixels = unit.tile().pixels();
  const v1::SampleRange& samples = unit.tile().samples();
  wire::TileResult result;
  result.x0 = pixels.x0(), result.y0 = pixels.y0(), result.x1 = pixels.x1(), result.y1 = pixels.y1();
  result.sample_begin = samples.begin(), result.sample_end = samples.end();
  result.channels = channels;
  result.counts.assign(result.pixel_count(), samples.end() - samples.begin());
  result.values.resize(result.pixel_count() * channels.size());
  std::uint64_t state = unit.index() + 1;
  for (float& value : result.values) {
    state = state * 6364136223846793005u +
            1442695040888963407u;  // a linear congruential generator of [Knuth1997]
    value = static_cast<float>(state >> 40) * 0x1p-24f;
  }
  return wire::encode_tile_result(result);
}

/// One worker: its calls are answered on gRPC's threads, so a lock guards what it holds.
class StubFleet::Worker {
 public:
  Worker(StubFleet& fleet, std::size_t number, std::shared_ptr<grpc::Channel> channel)
      : fleet_(fleet), number_(number), work_(v1::WorkService::NewStub(std::move(channel))) {}

  void enroll();
  /// Ends the call that may wait for long.
  void hang_up() {
    const std::lock_guard lock(mutex_);
    if (polling_ != nullptr) polling_->TryCancel();
  }

 private:
  template <typename Request, typename Response>
  struct Call {
    grpc::ClientContext context;
    Request request;
    Response response;
    Clock::time_point start = Clock::now();
  };
  template <typename Request, typename Response>
  using Method = void (v1::WorkService::StubInterface::async_interface::*)(grpc::ClientContext*,
                                                                           const Request*, Response*,
                                                                           std::function<void(grpc::Status)>);
  using UnitKey = std::pair<std::string, std::uint32_t>;

  template <typename Request, typename Response>
  void begin(std::shared_ptr<Call<Request, Response>> call, Method<Request, Response> method,
             std::function<void(const grpc::Status&)> done) {
    ++fleet_.calls_;
    (work_->async()->*method)(&call->context, &call->request, &call->response,
                              [this, call, done = std::move(done)](const grpc::Status& status) {
                                done(status);
                                --fleet_.calls_;
                              });
  }
  void later(Clock::duration delay, std::function<void()> action) {
    if (!fleet_.stopping_) fleet_.timers_.after(delay, std::move(action));
  }
  void try_again(std::function<void()> action) {
    ++fleet_.tally_.retries;
    later(kRetry, std::move(action));
  }

  std::uint32_t want(v1::LeaseRequest& request);
  void ride(const v1::LeaseToken& home, v1::CompleteRequest& request);
  void beaten(const v1::HeartbeatResponse& response);
  void ask();
  void take(const v1::LeaseResponse& response);
  void render_next();
  void finish(const v1::Lease& lease);
  void deliver(const v1::Lease& lease, std::shared_ptr<const std::string> payload);
  void beat();
  void forget(const v1::LeaseToken& token);
  void lost(const std::string& id);

  StubFleet& fleet_;
  const std::size_t number_;
  const std::unique_ptr<v1::WorkService::Stub> work_;

  std::mutex mutex_;
  std::string id_;  // empty: not registered
  bool enrolling_ = false;
  bool beating_ = false;
  grpc::ClientContext* polling_ = nullptr;
  std::chrono::milliseconds interval_{1000};
  Clock::time_point last_beat_{};
  Clock::time_point idle_since_{};
  std::map<UnitKey, v1::LeaseToken> held_;
  std::deque<v1::Lease> queue_;
  std::uint32_t busy_ = 0;   // threads
  std::uint32_t asked_ = 0;  // units
  std::deque<std::string> jobs_, scenes_;
  std::map<std::string, std::string> scene_of_job_;
};

void StubFleet::Worker::enroll() {
  {
    const std::lock_guard lock(mutex_);
    if (fleet_.stopping_ || enrolling_ || !id_.empty()) return;
    enrolling_ = true;
  }
  const auto call = std::make_shared<Call<v1::RegisterRequest, v1::RegisterResponse>>();
  call->request.set_protocol(wire::kProtocolVersion);
  call->request.set_build(wire::build_version());
  call->request.set_isa("avx2");
  call->request.add_supported_isas("avx2");
  call->request.add_arithmetic_classes("avx2/embree-3.13.5/0badcafe");
  call->request.set_name("stub" + std::to_string(number_));
  call->request.set_host(call->request.name());
  call->request.set_threads(fleet_.options_.threads_per_worker);
  begin(call, &v1::WorkService::StubInterface::async_interface::Register,
        [this, call](const grpc::Status& status) {
          bool begin_beating = false;
          {
            const std::lock_guard lock(mutex_);
            enrolling_ = false;
            if (status.ok()) {
              id_ = call->response.worker_id();
              interval_ = std::chrono::milliseconds(
                  TimeUtil::DurationToMilliseconds(call->response.heartbeat_interval()));
              begin_beating = !std::exchange(beating_, true);
              idle_since_ = Clock::now();
            }
          }
          if (!status.ok()) return try_again([this] { enroll(); });
          ++fleet_.registered_;
          // Spread over the interval, as those of machines that start one after another are.
          if (begin_beating) later(interval_ * (number_ % 97) / 97, [this] { beat(); });
          ask();
        });
}

/// How many units to ask for; they are on their way then. With mutex_ held.
std::uint32_t StubFleet::Worker::want(v1::LeaseRequest& request) {
  const std::size_t full = kQueuedPerThread * fleet_.options_.threads_per_worker,
                    expected = queue_.size() + asked_;
  if (fleet_.stopping_ || id_.empty() || expected > full / 2) return 0;
  const auto units = static_cast<std::uint32_t>(full - expected);
  request.set_max_units(units);
  for (const std::string& job : jobs_) request.add_known_job_ids(job);
  for (const std::string& scene : scenes_) request.add_loaded_scene_digests(scene);
  asked_ += units;
  return units;
}

/// Asks when nothing is queued, and nothing on its way.
void StubFleet::Worker::ask() {
  const auto call = std::make_shared<Call<v1::LeaseRequest, v1::LeaseResponse>>();
  {
    const std::lock_guard lock(mutex_);
    if (asked_ > 0 || !queue_.empty() || want(call->request) == 0) return;
    polling_ = &call->context;
    call->request.set_worker_id(id_);
  }
  call->request.mutable_max_wait()->set_seconds(kLeaseWait.count());
  begin(call, &v1::WorkService::StubInterface::async_interface::Lease,
        [this, call](const grpc::Status& status) {
          {
            const std::lock_guard lock(mutex_);
            polling_ = nullptr;
            asked_ -= call->request.max_units();
          }
          if (status.error_code() == grpc::StatusCode::NOT_FOUND) return lost(call->request.worker_id());
          if (!status.ok()) return try_again([this] { ask(); });
          take(call->response);
          render_next();
          ask();
        });
}

void StubFleet::Worker::take(const v1::LeaseResponse& response) {
  if (response.leases_size() == 0) return;
  const std::lock_guard lock(mutex_);
  fleet_.tally_.leased += static_cast<std::uint64_t>(response.leases_size());
  if (busy_ == 0 && queue_.empty()) fleet_.tally_.lease.add(since(idle_since_));
  for (const auto& [id, spec] : response.specs()) {
    if (!scene_of_job_.emplace(id, spec.content().scene()).second) continue;
    jobs_.push_back(id);
    if (jobs_.size() <= kKnownJobs) continue;
    scene_of_job_.erase(jobs_.front());
    jobs_.pop_front();
  }
  for (const v1::Lease& lease : response.leases()) {
    held_[{lease.token().job_id(), lease.token().unit_index()}] = lease.token();
    queue_.push_back(lease);
    const std::string& scene = scene_of_job_[lease.token().job_id()];
    if (std::find(scenes_.begin(), scenes_.end(), scene) != scenes_.end()) continue;
    scenes_.push_back(scene);
    if (scenes_.size() > fleet_.options_.scenes_per_worker) scenes_.pop_front();
  }
}

/// Gives every idle thread a unit.
void StubFleet::Worker::render_next() {
  std::vector<v1::Lease> begun;
  {
    const std::lock_guard lock(mutex_);
    while (busy_ < fleet_.options_.threads_per_worker && !queue_.empty()) {
      ++busy_;
      begun.push_back(std::move(queue_.front()));
      queue_.pop_front();
    }
  }
  for (v1::Lease& lease : begun) {
    const Clock::duration takes = time_of(lease.unit(), fleet_.options_.unit_time);
    const auto render = [this, lease = std::move(lease)] { finish(lease); };
    takes == Clock::duration::zero() ? render() : later(takes, render);
  }
}

/// The thread goes on with the next unit while the result is on its way.
void StubFleet::Worker::finish(const v1::Lease& lease) {
  const auto result = std::make_shared<const std::string>(stub_result(lease.unit()));
  {
    const std::lock_guard lock(mutex_);
    if (--busy_ == 0 && queue_.empty()) idle_since_ = Clock::now();
  }
  deliver(lease, result);
  render_next();
}

void StubFleet::Worker::deliver(const v1::Lease& lease, std::shared_ptr<const std::string> payload) {
  const auto call = std::make_shared<Call<v1::CompleteRequest, v1::CompleteResponse>>();
  {
    const std::lock_guard lock(mutex_);
    if (fleet_.stopping_) return;
    call->request.set_worker_id(id_);
    if (want(*call->request.mutable_more()) == 0) call->request.clear_more();
    ride(lease.token(), call->request);
  }
  *call->request.mutable_token() = lease.token();
  call->request.set_payload(*payload);
  *call->request.mutable_stats() = stub_stats(fleet_.options_.unit_time);
  const auto done = [this, call, lease, payload](const grpc::Status& status) {
    {
      const std::lock_guard lock(mutex_);
      asked_ -= call->request.more().max_units();
    }
    if (status.error_code() == grpc::StatusCode::NOT_FOUND) lost(call->request.worker_id());
    if (status.error_code() == grpc::StatusCode::NOT_FOUND ||
        net::is_transient(net::from_grpc(status, "Complete"))) {
      return try_again([this, lease, payload] { deliver(lease, payload); });
    }
    if (status.ok()) {
      if (call->response.has_beat()) beaten(call->response.beat());
      fleet_.tally_.complete.add(since(call->start));
      ++fleet_.tally_.completed;
      fleet_.completed_(lease.token().job_id(), lease.token().unit_index());
    } else if (!fleet_.stopping_) {
      ++fleet_.tally_.refused;
    }
    take(call->response.more());
    forget(lease.token());
    render_next();
    ask();
  };
  begin(call, &v1::WorkService::StubInterface::async_interface::Complete, done);
}

void StubFleet::Worker::forget(const v1::LeaseToken& token) {
  const std::lock_guard lock(mutex_);
  held_.erase({token.job_id(), token.unit_index()});
}

/// The coordinator does not know this worker any more: it started again.
void StubFleet::Worker::lost(const std::string& id) {
  {
    const std::lock_guard lock(mutex_);
    if (id_ == id) id_.clear();
  }
  enroll();
}

/// A heartbeat that is due soon goes with the result. With mutex_ held.
void StubFleet::Worker::ride(const v1::LeaseToken& home, v1::CompleteRequest& request) {
  if (last_beat_ + interval_ / 2 > Clock::now()) return;
  last_beat_ = Clock::now();
  v1::HeartbeatRequest& beat = *request.mutable_beat();
  for (const auto& [unit, token] : held_) {
    if (unit != UnitKey{home.job_id(), home.unit_index()}) *beat.add_leases() = token;
  }
}

void StubFleet::Worker::beaten(const v1::HeartbeatResponse& response) {
  const std::lock_guard lock(mutex_);
  interval_ = std::chrono::milliseconds(TimeUtil::DurationToMilliseconds(response.heartbeat_interval()));
  fleet_.tally_.revoked += static_cast<std::uint64_t>(response.revoked_size());
}

void StubFleet::Worker::beat() {
  const auto call = std::make_shared<Call<v1::HeartbeatRequest, v1::HeartbeatResponse>>();
  {
    const std::lock_guard lock(mutex_);
    const Clock::duration early = last_beat_ + interval_ - Clock::now();
    if (early > Clock::duration::zero()) return later(early, [this] { beat(); });
    last_beat_ = Clock::now();
    call->request.set_worker_id(id_);
    for (const auto& [unit, token] : held_) *call->request.add_leases() = token;
  }
  if (call->request.worker_id().empty()) return later(interval_, [this] { beat(); });
  begin(call, &v1::WorkService::StubInterface::async_interface::Heartbeat,
        [this, call](const grpc::Status& status) {
          later(interval_, [this] { beat(); });
          if (status.error_code() == grpc::StatusCode::NOT_FOUND) return lost(call->request.worker_id());
          if (!status.ok()) return;
          ++fleet_.tally_.heartbeats;
          fleet_.tally_.heartbeat.add(since(call->start));
          beaten(call->response);
        });
}

StubFleet::StubFleet(std::string address, const FleetOptions& options, Completed completed)
    : options_(options), completed_(std::move(completed)) {
  std::shared_ptr<grpc::Channel> channel;
  for (std::size_t i = 0; i < options_.workers; ++i) {
    if (i % options_.workers_per_connection == 0) channel = connect(address);
    workers_.push_back(std::make_unique<Worker>(*this, i, channel));
  }
}

StubFleet::~StubFleet() {
  stopping_ = true;
  timers_.stop();
  // A call may begin while the others are ended, so they are asked until none is left.
  while (calls_ > 0) {
    for (const auto& worker : workers_) worker->hang_up();
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

void StubFleet::start() {
  for (const auto& worker : workers_) worker->enroll();
}

void StubFleet::clear_latencies() {
  tally_.lease.clear();
  tally_.complete.clear();
  tally_.heartbeat.clear();
}

}  // namespace tessera::load
