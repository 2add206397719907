#include "scenario/whole_farm/farm_world.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <map>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "local/awaited.h"
#include "local/local_calls.h"
#include "scenario/whole_farm/painted_scene.h"
#include "service/farm/farm_views.h"
#include "service/farm/job_control.h"
#include "service/farm/lease_seal.h"
#include "support/phased_job.h"
#include "tessera/v1/scene.pb.h"
#include "unit/server/requests.h"
#include "wire/digest.h"

namespace tessera::test {
namespace {

using std::chrono::hours;
using std::chrono::milliseconds;
using std::chrono::minutes;
using std::chrono::seconds;

// All that waits for something has it long before.
constexpr hours kPatience{1};
constexpr hours kLongestWorld{3};
constexpr minutes kLongestSettling{15};

/// Bytes of a scene whose pictures nobody confuses with those of another.
std::string scene_bytes(std::uint64_t number) {
  v1::Scene scene;
  scene.set_name(absl::StrCat("scene ", number));
  return scene.SerializeAsString();
}

std::string texture_bytes() { return std::string(3000, 't'); }

void store(server::BlobStore& blobs, const std::string& bytes) {
  const auto writer = blobs.write(wire::sha256_hex(bytes), 0);
  static_cast<void>((*writer)->append(bytes));
  static_cast<void>((*writer)->finish());
}

/// Blobs for machines that need no cache.
render::BlobSource blobs_in_memory(server::BlobStore& blobs) {
  return [&blobs](const std::string& digest) -> absl::StatusOr<render::BlobBytes> {
    const auto reader = blobs.read(digest);
    if (!reader.ok()) return reader.status();
    const auto bytes = std::make_shared<const std::string>(*(*reader)->read(0, (*reader)->size()));
    return render::BlobBytes{*bytes, bytes};
  };
}

bool is_over(v1::JobState state) {
  return state == v1::DONE || state == v1::CANCELLED || state == v1::FAILED;
}

}  // namespace

FarmWorld::FarmWorld(std::uint64_t seed, std::string replay)
    : clock_(seed, kLongestWorld, std::move(replay)), chance_(~seed) {
  spdlog::set_level(spdlog::level::off);
  coordinator_.emplace(clock_, chance_, draw_farm(), chance_.between({}, milliseconds{200}));
  store(coordinator_->blobs(), texture_bytes());
  draw_network();
  draw_machines();
  draw_orders();
}

FarmWorld::~FarmWorld() = default;

// ---------------------------------------------------------------- what the world is like

server::FarmOptions FarmWorld::draw_farm() {
  constexpr milliseconds kLongestRuns[] = {milliseconds{0}, seconds{1}, seconds{10}};
  return {.heartbeat_interval = chance_.between(milliseconds{300}, seconds{2}),
          .lease_timeout = chance_.between(seconds{6}, seconds{30}),
          .late_results = chance_.of(0.5) ? seconds{60} : seconds{0},
          .retention = {.fetched = hours{24},
                        .unfetched = hours{24},
                        .max_bytes = std::uint64_t{1} << 40,
                        .blobs = hours{24},
                        .interval = minutes{1}},
          .longest_run = kLongestRuns[chance_.below(3)],
          .order = chance_.of(0.3) ? server::JobOrder::kFair : server::JobOrder::kFirstCome,
          .share_results = chance_.of(0.5),
          .seal = server::LeaseSeal::with_key(std::string(server::LeaseSeal::kKeyBytes, 'k')),
          .settle = chance_.of(0.3) ? seconds{3} : seconds{0},
          .clock = &clock_,
          .make_identifier = [this](int digits) {
            std::string text;
            for (int i = 0; i < digits; ++i) text.push_back("0123456789abcdef"[chance_.below(16)]);
            return text;
          }};
}

void FarmWorld::draw_network() {
  network_.emplace(Network{.clock = clock_, .chance = chance_, .coordinator = *coordinator_});
  // One world in five has a good network, so that other mishaps are seen alone.
  const double roughness = chance_.of(0.2) ? 0 : static_cast<double>(chance_.below(100)) / 100;
  network_->lost = 0.06 * roughness;
  network_->answer_lost = 0.06 * roughness;
  network_->late = 0.04 * roughness;
  network_->twice = 0.06 * roughness;
  network_->refused = 0.04 * roughness;
  network_->spoilt = 0.05 * roughness;
  network_->longest_delay = chance_.between(milliseconds{5}, seconds{4});
}

void FarmWorld::draw_machines() {
  longest_unit_ = chance_.between(milliseconds{50}, seconds{6});
  constexpr double kFailing[] = {0, 0, 0.03, 0.3};  // with the largest, units are set aside
  failing_ = kFailing[chance_.below(4)];
  unit_limit_ = chance_.of(0.5) ? seconds{20} : seconds{0};
  hanging_ = unit_limit_ > unit_limit_.zero() ? 0.02 : 0;
  chaos_ = chance_.between({}, seconds{120});
  const bool two_classes = chance_.of(0.25);
  machines_.resize(1 + chance_.below(5));
  for (std::size_t i = 0; i < machines_.size(); ++i) {
    Machine& machine = machines_[i];
    machine.name = absl::StrCat("machine ", i);
    machine.threads = static_cast<int>(1 + chance_.below(2));
    machine.rounding = two_classes ? i % 2 : 0;
    if (!chance_.of(0.1)) continue;
    if (!caches_) caches_.emplace();
    machine.cache = caches_->path() / absl::StrCat(i);
    ++counts_.caches;
  }
}

void FarmWorld::draw_orders() {
  orders_.resize(1 + chance_.below(4));
  for (std::size_t i = 0; i < orders_.size(); ++i) {
    Order& order = orders_[i];
    const std::string scene = scene_bytes(chance_.below(2));
    if (!coordinator_->blobs().query(wire::sha256_hex(scene)).complete) store(coordinator_->blobs(), scene);
    order.request_id = absl::StrCat("order ", i);
    constexpr std::uint32_t kSides[] = {16, 20, 32, 48};
    order.spec = server::square_spec(scene, kSides[chance_.below(4)],
                                     static_cast<std::uint32_t>(1 + chance_.below(12)));
    order.spec.mutable_farm()->add_blobs()->set_digest(wire::sha256_hex(texture_bytes()));
    order.spec.mutable_farm()->set_user(chance_.of(0.5) ? "alice" : "bob");
    order.spec.mutable_farm()->set_priority(static_cast<std::int32_t>(chance_.below(2)));
    // Equal seeds: one job takes over the results of another.
    order.spec.mutable_view()->set_seed(chance_.below(3));
    if (chance_.of(0.3)) {
      add_test_phases(order.spec, {static_cast<std::uint32_t>(1 + chance_.below(5)),
                                   static_cast<std::uint32_t>(1 + chance_.below(3))});
      ++counts_.phases;
    }
    order.begin = chance_.between({}, chaos_);
    if (chance_.of(0.25)) order.cancelled_after = chance_.between({}, seconds{30});
  }
}

// ---------------------------------------------------------------- machines

void FarmWorld::start(Machine& machine) {
  machine.cut = std::make_shared<bool>(false);
  agent::AgentOptions options;
  options.name = options.host = machine.name;
  options.threads = machine.threads;
  options.isas = {"avx2"};
  options.arithmetic_classes = {absl::StrCat("avx2/embree-3.13.5/0000000", machine.rounding)};
  options.load_scene =
      [this, rounding = machine.rounding](
          const v1::Scene&, const v1::JobSpec& spec, const render::BlobSource& blobs,
          const render::LoadOptions& load) -> absl::StatusOr<std::unique_ptr<render::RenderScene>> {
    for (const v1::BlobRef& blob : spec.farm().blobs()) {
      if (const auto bytes = blobs(blob.digest()); !bytes.ok()) return bytes.status();
    }
    if (!base::pause(clock_, chance_.between({}, seconds{2}), load.stop))
      return absl::CancelledError("nobody wants the scene");
    if (absl::Status status = try_luck(); !status.ok()) return status;
    return std::make_unique<PaintedScene>(
        spec, rounding,
        PaintedScene::Events{.work = [this](const std::stop_token& stop) { return work(stop); },
                             .read =
                                 [this] {
                                   base::pause(clock_, chance_.between({}, seconds{1}), {});
                                   return try_luck();
                                 }});
  };
  if (machine.cache.empty()) {
    options.blobs = blobs_in_memory(coordinator_->blobs());
  } else {
    options.cache_dir = machine.cache;
  }
  options.unit_limit = unit_limit_;
  options.grace = chance_.between({}, seconds{5});
  options.clock = &clock_;
  auto agent = agent::Agent::create(std::make_unique<RoughLink>(*network_, machine.cut), std::move(options));
  if (!agent.ok()) return violate(absl::StrCat(machine.name, ": ", agent.status().ToString()));
  machine.agent = *std::move(agent);
  machine.runner = clock_.start(machine.name, [this, &machine](const std::stop_token& stop) {
    const absl::Status status = machine.agent->run(stop);
    if (!status.ok() && !*machine.cut)
      violate(absl::StrCat(machine.name, " was refused: ", status.ToString()));
  });
}

void FarmWorld::kill(Machine& machine) {
  *machine.cut = true;
  machine.runner = base::Thread();
  machine.agent.reset();
}

void FarmWorld::drain(Machine& machine) {
  machine.runner = base::Thread();
  machine.agent.reset();
}

absl::Status FarmWorld::work(const std::stop_token& stop) {
  const bool hangs = network_->rough && chance_.of(hanging_);
  const milliseconds time = hangs ? milliseconds{hours{2}} : chance_.between(milliseconds{5}, longest_unit_);
  if (!base::pause(clock_, time, stop)) return absl::CancelledError("stopped");
  return try_luck();
}

absl::Status FarmWorld::try_luck() {
  if (!network_->rough || !chance_.of(failing_)) return absl::OkStatus();
  ++counts_.failed_units;
  return absl::ResourceExhaustedError("bad luck");
}

void FarmWorld::bring_mishap() {
  Machine& machine = machines_[chance_.below(machines_.size())];
  const std::uint64_t kind = chance_.below(10);
  if (kind < 6 && machine.agent == nullptr) {
    start(machine);
  } else if (kind < 4) {
    kill(machine);
    ++counts_.worker_deaths;
  } else if (kind < 6) {
    drain(machine);
    ++counts_.drained;
  } else if (kind < 9) {
    ++counts_.coordinator_deaths;
    coordinator_->stop(/*power_fails=*/chance_.of(0.7));
    base::pause(clock_, chance_.between({}, seconds{15}), {});
    if (const absl::Status status = coordinator_->start(); !status.ok())
      violate(absl::StrCat("the coordinator does not start again: ", status.ToString()));
  } else {
    const double lost = std::exchange(network_->lost, 1);
    base::pause(clock_, chance_.between(seconds{1}, seconds{40}), {});
    network_->lost = lost;
  }
}

// ---------------------------------------------------------------- clients

template <class Call>
auto FarmWorld::insist(const std::stop_token& stop, const Call& call) {
  while (true) {
    if (const MortalCoordinator::Visit visit = coordinator_->visit(); visit) {
      auto answer = call(visit.farm(), visit.end());
      const bool unheard = absl::IsUnavailable(answer.status()) || absl::IsCancelled(answer.status());
      if (!unheard || stop.stop_requested()) return answer;
    }
    if (!base::pause(clock_, chance_.between(milliseconds{100}, seconds{2}), stop))
      return decltype(call(std::declval<server::Farm&>(), stop))(absl::CancelledError("given up"));
  }
}

void FarmWorld::order_picture(Order& order, const std::stop_token& stop) {
  base::pause(clock_, order.begin, stop);
  while (true) {
    const absl::StatusOr<std::string> id = insist(stop, [&](server::Farm& farm, const std::stop_token& end) {
      return client::LocalCalls(farm).submit(order.spec, {.continued = "", .request_id = order.request_id},
                                             end);
    });
    if (!id.ok()) return violate(absl::StrCat(order.request_id, ": ", id.status().ToString()));
    order.id = *id;
    progress_.notify_all();
    follow(order, stop);
    // With bad luck the units that come first are set aside, so that nothing of it is rendered at all; then
    // it is to be submitted again.
    if (order.state != v1::FAILED || !absl::StrContains(order.error, "set aside")) break;
    ++counts_.submitted_again;
    order.request_id += " again";
    order.state = v1::JOB_STATE_UNSPECIFIED;
  }
  progress_.notify_all();
}

void FarmWorld::follow(Order& order, const std::stop_token& stop) {
  const client::JobCalls::WatchHandlers handlers{.result =
                                                     [&](const v1::UnitResult& result) {
                                                       order.results.push_back(result);
                                                       return absl::OkStatus();
                                                     },
                                                 .status = {},
                                                 .restart =
                                                     [&] {
                                                       order.results.clear();
                                                       return absl::OkStatus();
                                                     }};
  while (!is_over(order.state) && !stop.stop_requested()) {
    const absl::StatusOr<v1::JobStatus> status =
        insist(stop, [&](server::Farm& farm, const std::stop_token& end) {
          order.results.clear();
          return client::LocalCalls(farm).watch(order.id, handlers, end);
        });
    if (!status.ok()) return violate(absl::StrCat("watching ", order.id, ": ", status.status().ToString()));
    order.state = status->state();
    order.error = status->error();
    if (order.state != v1::INCOMPLETE) continue;
    ++counts_.reopened;
    const auto retried = insist(stop, [&](server::Farm& farm, const std::stop_token& end) {
      client::Awaited<absl::StatusOr<v1::JobStatus>> answer(clock_);
      farm.jobs().retry(order.id, answer.done());
      return answer.wait(end);
    });
    // It may have been cancelled meanwhile.
    if (!retried.ok() && !order.cancels)
      return violate(absl::StrCat("retrying ", order.id, ": ", retried.status().ToString()));
  }
}

void FarmWorld::cancel(Order& order, const std::stop_token& stop) {
  {
    std::unique_lock lock(mutex_);
    if (!progress_.wait(lock, stop, [&] { return !order.id.empty(); })) return;
  }
  if (!base::pause(clock_, *order.cancelled_after, stop)) return;
  order.cancels = true;
  ++counts_.cancelled;
  const auto status = insist(stop, [&](server::Farm& farm, const std::stop_token& end) {
    return client::LocalCalls(farm).cancel(order.id, end);
  });
  if (!status.ok() && !stop.stop_requested())
    violate(absl::StrCat("cancelling ", order.id, ": ", status.status().ToString()));
}

// ---------------------------------------------------------------- the course of the world

void FarmWorld::violate(const std::string& what) {
  if (violation_.empty()) violation_ = what;
  progress_.notify_all();
}

bool FarmWorld::all_over() const {
  return std::ranges::all_of(orders_, [](const Order& order) { return is_over(order.state); });
}

void FarmWorld::check_results(const Order& order) {
  if (order.state == v1::CANCELLED && order.cancels) return;
  if (order.state != v1::DONE)
    return violate(absl::StrCat(order.id, " ended as ", v1::JobState_Name(order.state), ": ", order.error));
  const bool is_of_first_class =
      !order.results.empty() &&
      order.results[0].payload() == right_payload(order.spec, 0, order.results[0].unit());
  using Tile = std::pair<std::uint32_t, std::uint32_t>;
  std::map<Tile, std::map<std::uint32_t, std::uint32_t>> ends_by_tile_and_begin;
  for (const v1::UnitResult& result : order.results) {
    ++counts_.results;
    const v1::TileUnit& tile = result.unit().tile();
    auto& ends = ends_by_tile_and_begin[{tile.pixels().x0(), tile.pixels().y0()}];
    if (!ends.emplace(tile.samples().begin(), tile.samples().end()).second)
      return violate(absl::StrCat(order.id, " has two results of unit ", result.unit().index()));
    if (result.payload() != right_payload(order.spec, is_of_first_class ? 0 : 1, result.unit()))
      return violate(absl::StrCat(order.id, " has a wrong result of unit ", result.unit().index()));
  }
  const std::uint32_t tiles_across = (order.spec.view().width() + 15) / 16;
  if (ends_by_tile_and_begin.size() != std::size_t{tiles_across} * tiles_across)
    return violate(absl::StrCat(order.id, " has results of ", ends_by_tile_and_begin.size(), " tiles"));
  for (const auto& [tile, ends] : ends_by_tile_and_begin) {
    std::uint32_t reached = 0;
    for (const auto& [begin, end] : ends) {
      if (begin != reached)
        return violate(absl::StrCat(order.id, ": a sample of tile ", tile.first, ", ", tile.second,
                                    " is there twice, or not at all, from ", begin, " on"));
      reached = end;
    }
    if (reached != order.spec.samples().spp())
      return violate(absl::StrCat(order.id, " has ", reached, " samples a pixel in a tile"));
  }
}

std::string FarmWorld::leftovers() {
  std::string found;
  const MortalCoordinator::Visit visit = coordinator_->visit();
  const v1::ListWorkersResponse workers = visit.farm().views().list_workers();
  for (const v1::WorkerStatus& worker : workers.workers()) {
    if (worker.leases() > 0) absl::StrAppend(&found, worker.name(), " has ", worker.leases(), " leases; ");
  }
  for (const Machine& machine : machines_) {
    const std::uint64_t results = machine.agent->report().outbox_results;
    if (results > 0) absl::StrAppend(&found, machine.name, " keeps ", results, " results; ");
  }
  return found;
}

std::string FarmWorld::run() {
  const base::Clock::TimePoint begin = clock_.now();
  if (const absl::Status status = coordinator_->start(); !status.ok()) return status.ToString();
  for (Machine& machine : machines_) start(machine);
  std::vector<base::Thread> clients;
  for (Order& order : orders_) {
    clients.push_back(
        clock_.start(order.request_id, [&](const std::stop_token& stop) { order_picture(order, stop); }));
    if (order.cancelled_after)
      clients.push_back(clock_.start("canceller", [&](const std::stop_token& stop) { cancel(order, stop); }));
  }

  const milliseconds longest_quiet = chance_.between(seconds{1}, seconds{12});
  while (clock_.now() < begin + chaos_ && violation_.empty()) {
    base::pause(clock_, chance_.between(milliseconds{50}, longest_quiet), {});
    bring_mishap();
  }
  network_->rough = false;
  for (Machine& machine : machines_) {
    if (machine.agent == nullptr) start(machine);
  }
  {
    std::unique_lock lock(mutex_);
    if (!progress_.wait_until(lock, {}, begin + kPatience, [&] { return all_over() || !violation_.empty(); }))
      violate(absl::StrCat("not all jobs are over after an hour:\n", clock_.who_waits()));
  }
  for (const base::Clock::TimePoint end = clock_.now() + kLongestSettling;
       violation_.empty() && !leftovers().empty();) {
    if (clock_.now() > end) violate(absl::StrCat("after all is over, ", leftovers()));
    base::pause(clock_, seconds{1}, {});
  }
  if (violation_.empty()) {
    for (const Order& order : orders_) check_results(order);
  }
  counts_.time = std::chrono::duration_cast<milliseconds>(clock_.now() - begin);

  for (Machine& machine : machines_) {
    if (machine.agent != nullptr) drain(machine);
  }
  network_->late_calls.clear();
  coordinator_->stop(/*power_fails=*/false);
  clients.clear();
  counts_.turns = clock_.turns();
  counts_.mishaps = network_->mishaps;
  return violation_;
}

}  // namespace tessera::test
