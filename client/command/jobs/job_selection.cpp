#include "command/jobs/job_selection.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "base/nearest_name.h"
#include "command/report/job_table.h"

namespace tessera::client {
namespace {

// Identifiers that coordinators give jobs.
constexpr std::size_t kIdLength = 8;

std::vector<std::string> ids_of(const std::vector<v1::JobStatus>& jobs) {
  std::vector<std::string> ids;
  for (const v1::JobStatus& job : jobs) ids.push_back(job.job_id());
  return ids;
}

absl::Status check(const JobSelection& selection) {
  const bool by_filter = selection.all || !selection.filter.user.empty() || !selection.filter.state.empty();
  if (by_filter && !selection.ids.empty()) {
    return absl::InvalidArgumentError("give either the ids of jobs, or --all, --user and --state");
  }
  if (!by_filter && selection.ids.empty()) {
    return absl::InvalidArgumentError("which jobs? Give their ids, or --all, --user or --state");
  }
  return absl::OkStatus();
}

}  // namespace

void define_job_filter(options::Command& command, JobFilter& filter) {
  command.add("--user", filter.user, "only jobs of this user").type_name("NAME");
  command.add("--state", filter.state, "only jobs in this state")
      .type_name("STATE")
      .one_of({"queued", "running", "paused", "done", "failed", "cancelled", "incomplete"});
}

bool matches(const JobFilter& filter, const v1::JobStatus& job) {
  return (filter.user.empty() || job.user() == filter.user) &&
         (filter.state.empty() || short_state(job) == filter.state);
}

void define_job_selection(options::Command& command, JobSelection& selection) {
  command.add("ID", selection.ids, "the jobs, or unique beginnings of their ids");
  command.group("Selection, instead of ids");
  command.add_flag("--all", selection.all, "all jobs that the command applies to");
  define_job_filter(command, selection.filter);
}

absl::StatusOr<std::string> find_job_id(const std::vector<std::string>& all, const std::string& id) {
  std::vector<std::string> found;
  for (const std::string& known : all) {
    if (known == id) return id;
    if (!id.empty() && known.starts_with(id)) found.push_back(known);
  }
  if (found.size() == 1) return found.front();
  if (found.empty())
    return absl::NotFoundError(absl::StrCat("there is no job ", id, base::did_you_mean(id, all)));
  return absl::InvalidArgumentError(
      absl::StrCat(found.size(), " jobs begin with ", id, ", ", found[0], " and ", found[1], " among them"));
}

absl::StatusOr<std::string> find_job_id(FarmClient& farm, const std::string& id, std::stop_token stop) {
  if (id.size() >= kIdLength) return id;
  const auto jobs = farm.jobs(stop);
  if (!jobs.ok()) return jobs.status();
  return find_job_id(ids_of(*jobs), id);
}

absl::StatusOr<std::vector<std::string>> select_jobs(FarmClient& farm, const JobSelection& selection,
                                                     const Suits& suits, std::stop_token stop) {
  if (absl::Status status = check(selection); !status.ok()) return status;
  const bool whole = !selection.ids.empty() && std::ranges::all_of(selection.ids, [](const auto& id) {
    return id.size() >= kIdLength;
  });
  if (whole) return selection.ids;
  const auto jobs = farm.jobs(stop);
  if (!jobs.ok()) return jobs.status();
  std::vector<std::string> chosen;
  for (const std::string& id : selection.ids) {
    absl::StatusOr<std::string> found = find_job_id(ids_of(*jobs), id);
    if (!found.ok()) return found.status();
    if (std::ranges::find(chosen, *found) == chosen.end()) chosen.push_back(*std::move(found));
  }
  if (!chosen.empty()) return chosen;
  for (const v1::JobStatus& job : *jobs) {
    if (matches(selection.filter, job) && suits(job)) chosen.push_back(job.job_id());
  }
  return chosen;
}

}  // namespace tessera::client
