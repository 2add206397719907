// The state that a coordinator finds when it starts: the parts are the database, the file of every job's
// results, and changes of single rows, each a byte for the column and its new value.
#include <SQLiteCpp/SQLiteCpp.h>
#include <spdlog/spdlog.h>

#include <array>
#include <charconv>

#include "fuzz/mutate_message.h"
#include "fuzz/target.h"
#include "scenario/simulated_disk.h"
#include "service/farm/farm.h"
#include "service/farm/farm_views.h"
#include "service/farm/job_control.h"
#include "service/farm/lease_seal.h"
#include "service/farm/worker_leases.h"
#include "service/farm/worker_registry.h"
#include "store/blobs/blob_store.h"
#include "store/journal.h"
#include "wire/version.h"

namespace tessera::fuzz {
namespace {

struct ColumnUpdate {
  const char* statement;
  enum Kind { kText, kBlob, kNumber } kind;
};

// Results and events as the journal of one job has them; which row is changed depends on the value alone.
constexpr std::array kUpdates = {
    ColumnUpdate{"UPDATE jobs SET spec = ?1", ColumnUpdate::kBlob},
    ColumnUpdate{"UPDATE jobs SET isa = ?1", ColumnUpdate::kText},
    ColumnUpdate{"UPDATE jobs SET state = ?1", ColumnUpdate::kNumber},
    ColumnUpdate{"UPDATE jobs SET generation = ?1", ColumnUpdate::kNumber},
    ColumnUpdate{"UPDATE jobs SET id = ?1 WHERE number = 1", ColumnUpdate::kText},
    ColumnUpdate{"UPDATE results SET digest = ?1", ColumnUpdate::kText},
    ColumnUpdate{"UPDATE results SET stats = ?1", ColumnUpdate::kBlob},
    ColumnUpdate{"UPDATE results SET host = ?1", ColumnUpdate::kText},
    ColumnUpdate{"UPDATE results SET unit = ?1 WHERE sequence = 1", ColumnUpdate::kNumber},
    ColumnUpdate{"UPDATE results SET end = ?1 WHERE sequence = (SELECT MAX(sequence) FROM results)",
                 ColumnUpdate::kNumber},
    ColumnUpdate{"INSERT INTO events (job, kind, unit, value, host, text) "
                 "SELECT id, ?1 & 31, (?1 >> 5) & 63, (?1 >> 11), 'a', 'b' FROM jobs",
                 ColumnUpdate::kNumber},
    ColumnUpdate{
        "INSERT INTO events (job, kind, unit, value, host, text) VALUES ('', ?1 & 31, 0, ?1 >> 5, 'a', 'b')",
        ColumnUpdate::kNumber},
    ColumnUpdate{"UPDATE events SET host = ?1", ColumnUpdate::kText},
    ColumnUpdate{"UPDATE events SET text = ?1", ColumnUpdate::kText},
    ColumnUpdate{"UPDATE events SET value = ?1", ColumnUpdate::kNumber},
    ColumnUpdate{"UPDATE events SET unit = ?1", ColumnUpdate::kNumber},
};

void update(SQLite::Database& database, const std::string& part) {
  if (part.empty()) return;
  const ColumnUpdate& column = kUpdates[static_cast<unsigned char>(part[0]) % kUpdates.size()];
  const std::string value = part.substr(1);
  SQLite::Statement statement(database, column.statement);
  if (column.kind == ColumnUpdate::kBlob) {
    statement.bind(1, value.data(), static_cast<int>(value.size()));
  } else if (column.kind == ColumnUpdate::kText) {
    statement.bind(1, value);
  } else {
    std::int64_t number = 0;
    std::from_chars(value.data(), value.data() + value.size(), number);
    statement.bind(1, number);
  }
  statement.exec();
}

/// The disk with these files, on which every job has the same results.
void fill_disk(server::Disk& disk, std::vector<std::string> parts) {
  const auto write = [&](const std::string& path, const std::string& bytes) {
    const auto file = disk.open(path, /*create=*/true);
    require(file.ok() && (*file)->write_at(0, bytes).ok(), "the simulated disk does not work");
  };
  parts.resize(std::max<std::size_t>(parts.size(), 2));
  write("/farm/journal.sqlite", parts[0]);
  try {
    SQLite::Database database(std::string("/farm/journal.sqlite"), SQLite::OPEN_READWRITE, 0,
                              disk.sqlite_vfs());
    database.exec("PRAGMA locking_mode = EXCLUSIVE");
    for (std::size_t i = 2; i < parts.size(); ++i) update(database, parts[i]);
    SQLite::Statement jobs(database, "SELECT id FROM jobs");
    while (jobs.executeStep()) write("/farm/results/" + jobs.getColumn(0).getString(), parts[1]);
  } catch (const SQLite::Exception&) {
    // A damaged database: the journal must see it, too.
  }
}

/// Calls of clients and workers to a farm that has started.
void use(server::Farm& farm) {
  const v1::ListJobsResponse jobs = farm.views().list_jobs();
  for (const v1::JobStatus& job : jobs.jobs()) {
    static_cast<void>(farm.views().get_job(job.job_id()));
    std::uint64_t after = 0;
    for (bool more = true; more;) {
      const auto batch = farm.views().next_results(job.job_id(), after, /*status_only=*/false);
      more = batch.ok() && batch->last > after;
      if (more) after = batch->last;
    }
    farm.jobs().retry(job.job_id(), [](const absl::StatusOr<v1::JobStatus>&) {});
  }
  v1::RegisterRequest registration;
  registration.set_protocol(wire::kProtocolVersion);
  registration.set_build(wire::build_version());
  registration.set_isa("avx2");
  registration.add_supported_isas("avx2");
  registration.add_arithmetic_classes("avx2/embree-3.13.5/0badcafe");
  registration.set_name("w");
  registration.set_host("h");
  registration.set_threads(2);
  const auto worker = farm.workers().register_worker(registration);
  require(worker.ok(), "a farm that started takes no workers");
  v1::LeaseRequest lease;
  lease.set_worker_id(worker->worker_id());
  lease.set_max_units(8);
  farm.leases().lease(
      lease, {}, [] { return false; }, [](const absl::StatusOr<v1::LeaseResponse>&) {});
  for (const v1::JobStatus& job : jobs.jobs())
    farm.jobs().cancel(job.job_id(), [](const absl::StatusOr<v1::JobStatus>&) {});
}

bool accepts_journal(std::string_view bytes) {
  spdlog::set_level(spdlog::level::off);
  server::SimulatedDisk disk(1);
  fill_disk(disk, split_parts(bytes));
  const auto journal = server::open_journal("/farm", {}, disk);
  if (!journal.ok()) {
    require(!journal.status().message().empty(), "an error without a message");
    return false;
  }
  const std::unique_ptr<server::BlobStore> blobs = server::make_memory_blob_store();
  const server::FarmOptions options = {
      .heartbeat_interval = std::chrono::seconds(1),
      .lease_timeout = std::chrono::seconds(8),
      .late_results = std::chrono::minutes(1),
      .retention = {.fetched = std::chrono::hours(1 << 20),
                    .unfetched = std::chrono::hours(1 << 20),
                    .max_bytes = std::uint64_t{1} << 60,
                    .blobs = std::chrono::hours(1 << 20),
                    .interval = std::chrono::seconds(1)},
      .seal = server::LeaseSeal::with_key(std::string(server::LeaseSeal::kKeyBytes, 'k'))};
  const auto farm = server::Farm::open(**journal, *blobs, options, [](const absl::Status&) {});
  if (!farm.ok()) {
    require(!farm.status().message().empty(), "an error without a message");
    return false;
  }
  use(**farm);
  return true;
}

std::string mutate_journal(std::string bytes, std::mt19937& random) {
  std::vector<std::string> parts = split_parts(bytes);
  if (parts.size() < 2) return mutate_bytes(std::move(bytes), random);
  const unsigned kind = random() % 4;
  if (kind == 0) {
    std::string& part = parts[random() % parts.size()];
    part = mutate_bytes(std::move(part), random);
  } else if (kind == 1 && parts.size() > 2) {
    parts.erase(parts.begin() + 2 + static_cast<std::ptrdiff_t>(random() % (parts.size() - 2)));
  } else if (parts.size() < 12) {
    const auto column = static_cast<std::size_t>(random() % kUpdates.size());
    std::string value(1, static_cast<char>(column));
    if (kUpdates[column].kind == ColumnUpdate::kNumber) {
      value += std::to_string(static_cast<std::int64_t>(random()) << (random() % 40) >> (random() % 60));
    } else if (kUpdates[column].kind == ColumnUpdate::kBlob) {
      v1::JobSpec spec;
      v1::UnitStats stats;
      google::protobuf::Message& message =
          column == 0 ? static_cast<google::protobuf::Message&>(spec) : stats;
      mutate_message(message, random);
      value += message.SerializeAsString();
    } else {
      value += mutate_bytes("0123456789abcdef", random);
    }
    parts.push_back(std::move(value));
  }
  return join_parts(parts);
}

}  // namespace

const Target kJournal = {"journal", accepts_journal, mutate_journal};

}  // namespace tessera::fuzz
