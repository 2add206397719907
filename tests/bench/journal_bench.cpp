// The cost of the tables that stand behind the journal's logs, and what they save: a start of the coordinator
// and queries of what is over, with the tables, without them (they are made anew), and by reading the logs
// alone. Run by hand (CONTRIBUTING: measuring).
//
//   journal_bench FOLDER JOBS RESULTS    an empty folder; so many jobs that are over, of so many results each
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "base/cpu_time.h"
#include "store/data_dir.h"
#include "store/journal.h"
#include "store/log/entry_log.h"
#include "tessera/v1/job.pb.h"

namespace tessera::server {
namespace {

constexpr std::uint64_t kResultsACommit = 8;

void must(const absl::Status& status) {
  if (status.ok()) return;
  std::fprintf(stderr, "%s\n", status.ToString().c_str());
  std::exit(1);
}

/// Does the work, and prints the CPU time that it took.
void measure(const std::string& what, std::uint64_t results, const std::function<void()>& work) {
  const auto start = base::process_cpu_time();
  work();
  const double seconds = base::in_seconds(base::process_cpu_time() - start);
  std::printf("%-44s %9.3f CPU s, %7.2f us a result\n", what.c_str(), seconds,
              1e6 * seconds / static_cast<double>(results));
  std::fflush(stdout);
}

std::string name_of(std::uint64_t job) { return absl::StrCat("job", job); }

/// A job of `results` results, from its submission to its end. Stats are about as long as those of a
/// renderer.
void journal_job(Journal& journal, const std::string& id, std::uint64_t results) {
  must(journal.commit({JobAdded{.id = id, .request_id = id, .spec = std::string(4096, 's')}}));
  std::vector<JournalEntry> entries;
  for (std::uint64_t i = 1; i <= results; ++i) {
    entries.push_back(UnitDone{.job = id,
                               .sequence = i,
                               .units = {.first = static_cast<std::uint32_t>(i - 1)},
                               .digest = std::string(64, 'd'),
                               .payload = std::string(64, 'p'),
                               .stats = std::string(150, 't'),
                               .host = "a-host"});
    if (i % kResultsACommit != 0 && i < results) continue;
    must(journal.commit(entries));
    entries.clear();
  }
  must(journal.commit({JobStats{.id = id, .results = results, .stats = std::string(150, 't')},
                       JobEnded{.id = id, .state = v1::DONE, .error = "", .finished_unix_ms = 1}}));
}

/// Opens the journal and takes its jobs in, as a coordinator does when it starts.
std::unique_ptr<Journal> start(const std::filesystem::path& folder) {
  auto journal = open_journal(folder);
  must(journal.status());
  must((*journal)->recover([](const JobRecord&) { return absl::OkStatus(); }));
  return *std::move(journal);
}

std::uint64_t bytes_in(const std::filesystem::path& folder, const std::string& part_of_name) {
  std::uint64_t bytes = 0;
  for (const auto& file : std::filesystem::recursive_directory_iterator(folder)) {
    if (file.is_regular_file() && file.path().filename().string().find(part_of_name) != std::string::npos)
      bytes += file.file_size();
  }
  return bytes;
}

void run(const std::filesystem::path& folder, std::uint64_t jobs, std::uint64_t results) {
  const std::uint64_t all = jobs * results;
  std::filesystem::create_directories(folder / "results");
  std::unique_ptr<Journal> journal = start(folder);
  measure("commits of eight results", all, [&] {
    for (std::uint64_t job = 0; job < jobs; ++job) journal_job(*journal, name_of(job), results);
  });
  journal.reset();
  measure("start", all, [&] { journal = start(folder); });
  measure("a job that is over, whole", results, [&] { must(journal->read_job(name_of(jobs / 2)).status()); });
  measure("costs of 1,000 of its results", 1000,
          [&] { must(journal->read_stats(name_of(jobs / 2), results / 2, 1000).status()); });
  journal.reset();
  measure("all logs read, and nothing kept", all, [&] {
    for (std::uint64_t job = 0; job < jobs; ++job) {
      const auto read =
          read_log(machine_disk(), log_path(folder, name_of(job)), 0, [](const LogFrame&) { return true; });
      must(read.status());
    }
  });
  measure("one log read", results, [&] {
    must(read_log(machine_disk(), log_path(folder, name_of(0)), 0, [](const LogFrame&) {
           return true;
         }).status());
  });
  std::printf("%.1f MB of tables, %.1f MB of logs\n",
              1e-6 * static_cast<double>(bytes_in(folder, "journal.sqlite")),
              1e-6 * static_cast<double>(bytes_in(folder, ".log")));
  for (const char* const suffix : {"", "-wal"})
    std::filesystem::remove(folder / absl::StrCat("journal.sqlite", suffix));
  measure("start without tables: they are made anew", all, [&] { journal = start(folder); });
}

}  // namespace
}  // namespace tessera::server

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "usage: journal_bench FOLDER JOBS RESULTS\n");
    return 2;
  }
  tessera::server::run(argv[1], std::strtoull(argv[2], nullptr, 10), std::strtoull(argv[3], nullptr, 10));
  return 0;
}
