#include "scenario/trace.h"

#include <variant>

#include "absl/strings/str_cat.h"

namespace tessera::server {
namespace {

template <typename... F>
struct Overloaded : F... {
  using F::operator()...;
};

std::string text_of(const JournalEntry& entry) {
  return std::visit(
      Overloaded{[](const JobAdded& added) { return absl::StrCat("added ", added.id); },
                 [](const JobBound& bound) { return absl::StrCat("bound ", bound.id, " ", bound.isa); },
                 [](const JobEnded& ended) {
                   return absl::StrCat("ended ", ended.id, " ", ended.state, " ", ended.error);
                 },
                 [](const UnitDone& done) {
                   return absl::StrCat("done ", done.job, " ", done.sequence, " ", done.units.first, " ",
                                       done.units.ranges, " ", done.digest, " ", done.host, " ",
                                       done.from_job, " ", done.from_sequence);
                 },
                 [](const JobStats& stats) { return absl::StrCat("stats ", stats.id, " ", stats.results); },
                 [](const SchedulerEvent& event) {
                   return absl::StrCat("event ", event.job, " ", event.kind, " ", event.unit, " ",
                                       event.value, " ", event.host, " ", event.text);
                 },
                 [](const JobReopened& reopened) { return absl::StrCat("reopened ", reopened.id); },
                 [](const JobFetched& fetched) { return absl::StrCat("fetched ", fetched.id); },
                 [](const JobPruned& pruned) { return absl::StrCat("pruned ", pruned.id); }},
      entry);
}

}  // namespace

void Trace::add(std::string_view text) {
  for (const char c : text) digest_ = (digest_ ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  add(text.size());
}

void Trace::add(std::uint64_t number) {
  for (int i = 0; i < 8; ++i) digest_ = (digest_ ^ (number >> 8 * i & 0xff)) * 0x100000001b3;
}

void Trace::add(const JournalEntry& entry) { add(text_of(entry)); }

void Trace::add(const v1::LeaseToken& token) {
  add(token.job_id());
  for (const std::uint64_t number :
       {std::uint64_t{token.unit_index()}, std::uint64_t{token.ranges()}, std::uint64_t{token.attempt()},
        std::uint64_t{token.epoch()}, std::uint64_t{token.inputs()}}) {
    add(number);
  }
}

void Trace::add(const LeaseDecision& decision) {
  for (const v1::Lease& lease : decision.leases) add(lease.token());
}

void Trace::add(const HeartbeatDecision& decision) {
  for (const v1::LeaseToken& token : decision.revoked) add(token);
}

}  // namespace tessera::server
