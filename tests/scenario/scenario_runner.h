// Drives the scheduler from text, in the manner of the interaction tests of etcd's raft.
//
// A scenario is a list of blocks: commands, a line of dashes, the expected output, an empty line. A line that
// begins with # is for people. Commands (names are free, times are in seconds, a lease is JOB/UNIT#ATTEMPT,
// with @EPOCH when it is not of the current epoch):
//
//   submit JOB tiles=N [ranges=N] [scene=NAME] [isa=NAME] [priority=N] [user=NAME] [require=TAG,TAG]
//   [workers=N]
//          [bits=any]
//   cancel JOB
//   retry JOB
//   pause JOB
//   resume JOB
//   priority JOB N
//   job JOB                 with what it waits for, who is left out, what was set aside, and its notes
//   order fair|first-come   among a user's jobs; only before the first job
//   audit N                 from now on one result in N gets a second opinion; only before the first job
//   settle SECONDS          from now on that is how long workers have to come together; only before the first
//   job register WORKER [isa=NAME] [also=NAME] [threads=N] [host=NAME] [tags=TAG,TAG]
//   [classes=ISA/NAME,ISA/NAME] deregister WORKER drain WORKER workers lease WORKER COUNT [scenes=NAME,NAME]
//   heartbeat WORKER LEASE...
//   complete WORKER LEASE [result=N] [took=SECONDS]
//   fail WORKER LEASE [scene]
//   trust HOST
//   advance SECONDS
//   restart                 as after a crash of the coordinator: only what was journaled is left
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "scenario/model_journal.h"
#include "scheduler/scheduler.h"

namespace tessera::server {

class ScenarioRunner {
 public:
  ScenarioRunner();

  /// Executes one command line; its output, ending in a newline.
  std::string run(const std::string& line);

 private:
  using Words = std::vector<std::string>;
  struct Arguments {
    Words positional;
    std::map<std::string, std::string> named;
    std::string get(const std::string& name, const std::string& otherwise) const;
  };

  std::string submit(const Arguments& arguments);
  std::string show_job(const std::string& id) const;
  std::string register_worker(const Arguments& arguments);
  std::string show_workers() const;
  std::string lease(const Arguments& arguments);
  std::string heartbeat(const Arguments& arguments);
  std::string complete(const Arguments& arguments);
  std::string fail(const Arguments& arguments);
  std::string advance(const std::string& seconds);
  std::string restart();
  std::string changed(const absl::Status& status);

  v1::LeaseToken token(const std::string& text) const;
  std::string text(const v1::LeaseToken& token) const;

  /// Journals `entries` and what the scheduler wants to have journaled; in words, what was news.
  std::string journal(std::vector<JournalEntry> entries);

  SchedulerOptions options_;
  Time now_{0};
  ModelJournal journal_;
  std::map<std::string, JobRequest> jobs_;
  std::unique_ptr<Scheduler> scheduler_;
};

/// A job whose film is a row of `tiles` tiles, with `ranges` sample ranges, after phases of so many parts:
/// none or two.
std::shared_ptr<const WorkPlan> row_of_tiles(std::uint32_t tiles, std::uint32_t ranges,
                                             const std::vector<std::uint32_t>& parts = {});

}  // namespace tessera::server
