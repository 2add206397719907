#include "scenario/whole_farm/mortal_coordinator.h"

#include <mutex>
#include <utility>

namespace tessera::test {

/// The journal, as it is reached in one life.
class MortalCoordinator::Disk final : public server::Journal {
 public:
  explicit Disk(MortalCoordinator& owner) : owner_(owner), journal_(owner.journal_) {}

  void lose_power() { has_power_ = false; }

  std::uint64_t epoch() const override { return journal_.epoch(); }
  absl::Status recover(const std::function<absl::Status(server::JobRecord)>& visit) override {
    return journal_.recover(visit);
  }
  absl::StatusOr<server::JobRecord> read_job(const std::string& job) override {
    return journal_.read_job(job);
  }
  absl::StatusOr<std::vector<server::SchedulerEvent>> farm_events() override {
    return journal_.farm_events();
  }
  /// When the power fails meanwhile, what it was to write is there, or is not.
  absl::Status commit(const std::vector<server::JournalEntry>& entries) override {
    turn_platter();
    if (!has_power_) return absl::UnavailableError("no power");
    absl::Status status = journal_.commit(entries);
    turn_platter();
    return has_power_ ? status : absl::UnavailableError("no power");
  }
  absl::StatusOr<std::string> read_result(const std::string& job, std::uint64_t sequence) override {
    return journal_.read_result(job, sequence);
  }
  absl::StatusOr<std::vector<server::CoveredUnits>> read_units(const std::string& job, std::uint64_t after,
                                                               std::uint32_t most) override {
    return journal_.read_units(job, after, most);
  }

 private:
  void turn_platter() {
    base::pause(owner_.clock_, owner_.chance_.between({}, owner_.slowest_commit_ / 2), {});
  }

  MortalCoordinator& owner_;
  server::ModelJournal& journal_;
  bool has_power_ = true;
};

struct MortalCoordinator::Life {
  Life(MortalCoordinator& owner) : disk(owner), left(owner.clock_) {}

  Disk disk;
  std::unique_ptr<server::Farm> farm;
  std::stop_source end;
  std::mutex mutex;
  base::Condition left;
  int visitors = 0;
};

MortalCoordinator::Visit::Visit(std::shared_ptr<Life> life) : life_(std::move(life)) {
  if (life_ != nullptr) ++life_->visitors;
}

MortalCoordinator::Visit::~Visit() {
  if (life_ == nullptr) return;
  --life_->visitors;
  life_->left.notify_all();
}

server::Farm& MortalCoordinator::Visit::farm() const { return *life_->farm; }
std::stop_token MortalCoordinator::Visit::end() const { return life_->end.get_token(); }

MortalCoordinator::MortalCoordinator(base::Clock& clock, Chance& chance, server::FarmOptions options,
                                     std::chrono::milliseconds slowest_commit)
    : clock_(clock),
      chance_(chance),
      options_(std::move(options)),
      slowest_commit_(slowest_commit),
      blobs_(server::make_memory_blob_store()) {}

MortalCoordinator::~MortalCoordinator() { stop(/*power_fails=*/false); }

absl::Status MortalCoordinator::start() {
  journal_.begin_epoch();
  const auto life = std::make_shared<Life>(*this);
  auto farm = server::Farm::open(life->disk, *blobs_, options_, [](const absl::Status&) {});
  if (!farm.ok()) return farm.status();
  life->farm = *std::move(farm);
  life_ = life;
  return absl::OkStatus();
}

void MortalCoordinator::stop(bool power_fails) {
  const std::shared_ptr<Life> life = life_;
  if (life == nullptr) return;
  if (power_fails) {
    // Nothing is written any more, while calls still come.
    life->disk.lose_power();
    base::pause(clock_, chance_.between({}, std::chrono::seconds{2}), {});
  }
  life_.reset();
  life->end.request_stop();
  life->farm->stop();
  {
    std::unique_lock lock(life->mutex);
    life->left.wait(lock, [&] { return life->visitors == 0; });
  }
  life->farm.reset();
}

}  // namespace tessera::test
