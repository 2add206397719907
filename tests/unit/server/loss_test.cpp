// Every way in which a data directory can be damaged: what was acknowledged is there after all, or is said to
// be lost.
#include <gmock/gmock.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <fstream>
#include <random>
#include <set>
#include <sstream>
#include <thread>

#include "absl/strings/str_cat.h"
#include "support/long_form.h"
#include "support/process/temp_dir.h"
#include "unit/server/coordinator_fixture.h"

namespace tessera::server {
namespace {

namespace fs = std::filesystem;

/// Log of the coordinator, from warnings on.
class Said {
 public:
  Said() : before_(spdlog::default_logger()) {
    auto logger = std::make_shared<spdlog::logger>(
        "said", std::make_shared<spdlog::sinks::ostream_sink_mt>(text_, true));
    logger->set_level(spdlog::level::warn);
    spdlog::set_default_logger(std::move(logger));
  }
  ~Said() { spdlog::set_default_logger(before_); }
  std::string text() const { return text_.str(); }

 private:
  std::ostringstream text_;
  std::shared_ptr<spdlog::logger> before_;
};

struct Damage {
  std::string name;
  std::function<void(const fs::path& data)> make;
};

void overwrite(const fs::path& path, std::uint64_t at, const std::string& bytes) {
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(static_cast<std::streamoff>(at));
  file << bytes;
  ASSERT_TRUE(file.good()) << path;
}

void flip_a_bit(const fs::path& path, std::uint64_t at, unsigned bit) {
  std::ifstream file(path, std::ios::binary);
  file.seekg(static_cast<std::streamoff>(at));
  const int byte = file.get();
  file.close();
  overwrite(path, at, std::string(1, static_cast<char>(byte ^ (1 << bit))));
}

/// Damages of one file: gone, emptied, cut, zeroed in part, a bit flipped; at `places` places each.
void add_damages_of(const fs::path& file, std::uint64_t size, unsigned places, std::mt19937& random,
                    std::vector<Damage>& damages) {
  const auto add = [&](const std::string& what, std::function<void(const fs::path&)> make) {
    damages.push_back({absl::StrCat(file.string(), " ", what),
                       [file, make = std::move(make)](const fs::path& data) { make(data / file); }});
  };
  add("missing", [](const fs::path& path) { fs::remove(path); });
  add("emptied", [](const fs::path& path) { fs::resize_file(path, 0); });
  if (size == 0) return;
  add("zeroed", [size](const fs::path& path) { overwrite(path, 0, std::string(size, '\0')); });
  for (unsigned i = 0; i < places; ++i) {
    const std::uint64_t at = random() % size, bit = random() % 8;
    const std::uint64_t block = at / 512 * 512, bytes = std::min<std::uint64_t>(size - block, 4096);
    add(absl::StrCat("cut to ", at), [at](const fs::path& path) { fs::resize_file(path, at); });
    add(absl::StrCat("zeroed from ", block),
        [=](const fs::path& path) { overwrite(path, block, std::string(bytes, '\0')); });
    add(absl::StrCat("with a bit flipped at ", at), [=](const fs::path& path) { flip_a_bit(path, at, bit); });
  }
}

class LossTest : public CoordinatorTest {
 protected:
  static constexpr std::uint32_t kRanges = 8, kTiles = 4, kUnits = kTiles * kRanges;

  static CoordinatorOptions options(const fs::path& data) {
    CoordinatorOptions options;
    options.data_dir = data;
    return options;
  }

  v1::JobSpec spec(std::uint64_t seed) {
    v1::JobSpec spec = job_spec(kRanges);
    spec.mutable_view()->set_seed(seed);  // otherwise it would take over results that are there
    spec.mutable_farm()->set_user(absl::StrCat("user ", seed));
    return spec;
  }

  /// Renders what was leased: one unit, or several as one. Returns how many.
  std::uint32_t render(const std::string& worker, const v1::Lease& lease) {
    EXPECT_TRUE(complete(worker, lease, payload_for(lease.unit()), std::chrono::milliseconds(1)).ok());
    const std::uint32_t units = std::max(lease.token().ranges(), 1u);
    rendered_ += units;
    return units;
  }

  /// Renders so many units of what there is, or some more.
  void render(std::uint32_t units) {
    const std::string worker = register_worker();
    while (units > 0) {
      const v1::LeaseResponse leases = lease(worker, units);
      if (leases.leases().empty()) return;
      for (const v1::Lease& lease : leases.leases()) {
        units -= std::min(units, render(worker, lease));
      }
    }
  }

  void change(const std::string& id, bool cancel) {
    grpc::ClientContext context;
    if (cancel) {
      v1::CancelJobRequest request;
      v1::CancelJobResponse response;
      request.set_job_id(id);
      ASSERT_TRUE(farm_->CancelJob(&context, request, &response).ok());
    } else {
      v1::AdjustJobRequest request;
      v1::AdjustJobResponse response;
      request.set_job_id(id);
      request.set_priority(7);
      ASSERT_TRUE(farm_->AdjustJob(&context, request, &response).ok());
    }
  }

  std::vector<v1::JobStatus> jobs() {
    grpc::ClientContext context;
    v1::ListJobsResponse response;
    EXPECT_TRUE(farm_->ListJobs(&context, {}, &response).ok());
    return {response.jobs().begin(), response.jobs().end()};
  }

  /// Acknowledged facts about all jobs, in order.
  std::string facts() {
    std::string facts;
    for (const v1::JobStatus& job : jobs()) {
      absl::StrAppend(&facts, job.job_id(), " ", job.name(), " ", job.state(), " ", job.user(), " ",
                      job.priority(), " ", job.units_done(), " of ", job.units_total(), " ", job.isa(), " ",
                      job.submitted_unix_ms(), " ", job.finished_unix_ms(), "\n");
    }
    return facts;
  }

  /// Takes all results of a job, while a worker renders what is missing. Each that comes must be right.
  grpc::Status fetch(const std::string& id) {
    std::set<std::uint32_t> units;
    std::atomic<bool> over = false;
    grpc::Status status;
    std::jthread watcher([&] {
      grpc::ClientContext context;
      v1::WatchJobRequest request;
      request.set_job_id(id);
      const auto stream = farm_->WatchJob(&context, request);
      for (v1::WatchJobResponse message; stream->Read(&message);) {
        for (const v1::UnitResult& result : message.results()) {
          EXPECT_EQ(result.payload(), payload_for(result.unit()))
              << "a wrong picture, of unit " << result.unit().index();
          for (std::uint32_t i = 0; i < result.ranges(); ++i)
            units.insert(result.unit().index() + i * kTiles);
        }
      }
      status = stream->Finish();
      over = true;
    });
    const std::string worker = register_worker();
    while (!over) {
      const v1::LeaseResponse leases = lease(worker, kUnits, std::chrono::milliseconds(20));
      for (const v1::Lease& lease : leases.leases()) render(worker, lease);
    }
    watcher.join();
    EXPECT_TRUE(!status.ok() || units.size() == kUnits) << "of job " << id;
    return status;
  }

  /// A farm's data as a coordinator leaves it that is killed: some of the journal in its database, some in
  /// SQLite's log.
  void make_store() {
    start(store_.path() / "data");
    const std::string fetched = submit(spec(1)), unfetched = submit(spec(2));
    render(2 * kUnits);
    ASSERT_TRUE(fetch(fetched).ok());
    start(store_.path() / "data");
    const std::string cancelled = submit(spec(3));
    render(5);
    change(cancelled, /*cancel=*/true);
    half_done_ = submit(spec(4));
    change(half_done_, /*cancel=*/false);
    render(kUnits / 2);
    submit(spec(5));
    facts_ = facts();
    for (const v1::JobStatus& job : jobs()) {
      if (job.state() != v1::CANCELLED) missing_ += job.units_total() - job.units_done();
    }
    // Nobody writes: what is copied is what a kill would leave.
    fs::copy(store_.path() / "data", store_.path() / "killed", fs::copy_options::recursive);
    stop();
  }

  enum Verdict { kHealed, kNamed, kSilent };

  /// Opens the store with this damage, and says what became of it.
  Verdict judge(const std::function<void(const fs::path&)>& damage, std::string& said_text) {
    const fs::path copy = store_.path() / "copy";
    fs::remove_all(copy);
    fs::copy(store_.path() / "killed", copy, fs::copy_options::recursive);
    damage(copy);
    const Said said;
    stop();
    auto started = Coordinator::start(options(copy));
    if (!started.ok()) {
      said_text = said.text() + std::string(started.status().message());
      return started.status().message().empty() ? kSilent : kNamed;
    }
    started->reset();
    start(copy);
    const std::string found = facts();
    bool same = found == facts_;
    rendered_ = 0;
    for (const v1::JobStatus& job : jobs()) {
      if (job.state() != v1::CANCELLED) same = fetch(job.job_id()).ok() && same;
    }
    same = same && rendered_ == missing_;
    stop();
    said_text = said.text();
    if (same) return kHealed;
    const Verdict verdict = said_text.empty() ? kSilent : kNamed;
    absl::StrAppend(&said_text, rendered_, " units rendered; the jobs were\n", facts_, "and are\n", found);
    return verdict;
  }

  /// Whether the coordinator refuses to start on the store with this damage, and goes on when told to.
  void expect_refused(const std::function<void(const fs::path&)>& damage, const std::string& because) {
    const fs::path copy = store_.path() / "copy";
    fs::remove_all(copy);
    fs::copy(store_.path() / "killed", copy, fs::copy_options::recursive);
    damage(copy);
    for (int time = 0; time < 2; ++time) {
      const auto refused = Coordinator::start(options(copy));
      ASSERT_FALSE(refused.ok()) << "the " << time + 1 << ". time";
      EXPECT_EQ(refused.status().code(), absl::StatusCode::kFailedPrecondition) << refused.status();
      EXPECT_THAT(std::string(refused.status().message()), testing::HasSubstr(because));
      EXPECT_THAT(std::string(refused.status().message()), testing::HasSubstr("--accept-loss"));
    }
    CoordinatorOptions accepting = options(copy);
    accepting.accept_loss = true;
    start(accepting);
    start(copy);  // a loss that was accepted once is not refused again
    stop();
  }

  support::TempDir store_;
  std::string facts_, half_done_;
  std::uint32_t rendered_ = 0;
  std::uint32_t missing_ = 0;  // units of jobs that were not over
};

void remove_journal(const fs::path& data) {
  fs::remove(data / "journal.sqlite");
  fs::remove(data / "journal.sqlite-wal");
}

TEST_F(LossTest, NothingIsLostWithoutAWord) {
  make_store();
  std::string said;
  ASSERT_EQ(judge([](const fs::path&) {}, said), kHealed) << said;
  EXPECT_EQ(said, "") << "nothing is wrong with it";

  std::vector<Damage> damages;
  const auto places = static_cast<unsigned>(test::how_often("TESSERA_DAMAGES", 1, 16));
  std::mt19937 random(13);
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(store_.path() / "killed")) {
    const fs::path file = fs::relative(entry.path(), store_.path() / "killed");
    // Blobs are damaged in damage_test.cpp; the lock has no contents.
    if (!entry.is_regular_file() || *file.begin() == "blobs" || file == "lock") continue;
    add_damages_of(file, entry.file_size(), places, random, damages);
  }
  damages.push_back({"journal and log missing", remove_journal});
  damages.push_back({"results missing", [](const fs::path& data) { fs::remove_all(data / "results"); }});
  damages.push_back({"log and manifest missing", [](const fs::path& data) {
                       fs::remove(data / "journal.sqlite-wal"), fs::remove(data / "manifest");
                     }});
  damages.push_back({"journal and manifest missing",
                     [](const fs::path& data) { remove_journal(data), fs::remove(data / "manifest"); }});
  int counts[3] = {0, 0, 0};
  for (const Damage& damage : damages) {
    SCOPED_TRACE(damage.name);
    const Verdict verdict = judge(damage.make, said);
    ++counts[verdict];
    EXPECT_NE(verdict, kSilent) << "something is lost, and nobody said so";
    if (HasFatalFailure()) break;
  }
  std::printf("%zu damages: %d healed, %d named, %d silent\n", damages.size(), counts[kHealed],
              counts[kNamed], counts[kSilent]);
}

TEST_F(LossTest, JobsAreMadeAnewFromWhatLiesBesideTheirResults) {
  make_store();
  std::string said;
  EXPECT_EQ(judge(remove_journal, said), kHealed) << said;
  EXPECT_THAT(said, testing::HasSubstr("are taken from the logs beside the results"));
  EXPECT_EQ(judge([](const fs::path& data) { fs::remove(data / "journal.sqlite-wal"); }, said), kHealed)
      << said;
  EXPECT_EQ(judge([](const fs::path& data) { fs::resize_file(data / "journal.sqlite", 0); }, said), kHealed)
      << said;
  EXPECT_EQ(judge(
                [](const fs::path& data) {
                  for (const fs::directory_entry& entry : fs::directory_iterator(data / "results")) {
                    if (entry.path().extension() == ".log") fs::remove(entry.path());
                  }
                  fs::remove(data / "farm.log");
                },
                said),
            kHealed)
      << said;
}

TEST_F(LossTest, WhatCannotBeMadeAnewKeepsTheCoordinatorFromStarting) {
  make_store();
  const auto remove_logs = [](const fs::path& data) {
    for (const fs::directory_entry& entry : fs::directory_iterator(data / "results")) {
      if (entry.path().extension() == ".log") fs::remove(entry.path());
    }
  };
  // A folder of an older version, whose journal is emptied.
  expect_refused(
      [&](const fs::path& data) {
        remove_logs(data), remove_journal(data), fs::remove(data / "manifest"), fs::remove(data / "farm.log");
      },
      "has results of a job that is not known");
  expect_refused(
      [&](const fs::path& data) {
        fs::remove_all(data / "results"), remove_journal(data), fs::remove(data / "manifest");
        fs::remove(data / "farm.log");
      },
      "but no job is known");
  expect_refused([&](const fs::path& data) { fs::remove_all(data / "results"), remove_journal(data); },
                 "the manifest says");
  expect_refused(
      [&](const fs::path& data) {
        remove_journal(data);
        fs::resize_file(data / "results" / (half_done_ + ".log"), 2000);
      },
      half_done_ + ".log is damaged at byte");
}

}  // namespace
}  // namespace tessera::server
