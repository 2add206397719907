#include "agent/link/outbox.h"

#include <utility>

#include "base/printable.h"
#include "net/backoff.h"
#include "net/status.h"
#include "telemetry/log.h"

namespace tessera::agent {
namespace {

constexpr std::chrono::milliseconds kRetryCap{2000};
constexpr std::size_t kMaxFailureMessage = 4096;  // bytes

std::size_t size_of(const Outcome& outcome) { return outcome.payload.size() + outcome.blob.size(); }

/// The blob that the result names goes first. Stored parts that did not fit are sent anew.
absl::Status upload(CoordinatorLink& link, const Outcome& outcome, const std::string& worker_id,
                    const v1::LeaseToken& token, std::stop_token stop) {
  const bool has_blob = outcome.unit->unit.has_part() || outcome.unit->unit.has_merge();
  if (!outcome.failure.ok() || !has_blob) return absl::OkStatus();
  CoordinatorLink::UnitBlob blob{.ref = {}, .bytes = outcome.blob, .worker_id = worker_id, .token = token};
  if (!blob.ref.ParseFromString(outcome.payload)) return absl::InternalError("the result names no blob");
  constexpr int kMostAttempts = 3;
  for (int attempt = 1;; ++attempt) {
    absl::Status status = link.upload(blob, stop);
    const bool anew = absl::IsDataLoss(status) || absl::IsOutOfRange(status);
    if (!anew || attempt == kMostAttempts) return status;
  }
}

}  // namespace

Outbox::Outbox(base::Clock& clock, CoordinatorLink& link, Session& session, LeaseTable& leases,
               LeaseIntake& intake, Heart& heart, Options options)
    : link_(link),
      session_(session),
      leases_(leases),
      intake_(intake),
      heart_(heart),
      options_(std::move(options)),
      filled_(clock),
      room_(clock) {
  for (int i = 0; i < options_.senders; ++i)
    senders_.push_back(clock.start("sender", [this](std::stop_token stop) { send_all(stop); }));
}

Outbox::~Outbox() {
  for (base::Thread& sender : senders_) sender.request_stop();
}

bool Outbox::push(Outcome outcome, std::stop_token stop) {
  std::unique_lock lock{mutex_};
  const bool room = room_.wait(lock, stop, [this] { return queue_.size() < options_.capacity; });
  if (!room) {
    leases_.release(*outcome.unit);
    return false;
  }
  ++held_results_;
  held_bytes_ += size_of(outcome);
  queue_.push_back(std::move(outcome));
  lock.unlock();
  filled_.notify_one();
  return true;
}

void Outbox::add_to(AgentReport& report) const {
  std::lock_guard lock{mutex_};
  report.results_acknowledged = acknowledged_;
  report.outbox_results = held_results_;
  report.outbox_bytes = held_bytes_;
}

void Outbox::send_all(std::stop_token stop) {
  while (true) {
    std::unique_lock lock{mutex_};
    if (!filled_.wait(lock, stop, [this] { return !queue_.empty(); })) return;
    Outcome outcome = std::move(queue_.front());
    const bool was_full = queue_.size() == options_.capacity;
    queue_.pop_front();
    lock.unlock();
    if (was_full) room_.notify_all();
    deliver(outcome, stop);
    lock.lock();
    --held_results_;
    held_bytes_ -= size_of(outcome);
    lock.unlock();
    leases_.release(*outcome.unit);
  }
}

void Outbox::deliver(Outcome& outcome, std::stop_token stop) {
  const std::stop_token revoked = outcome.unit->stop.get_token();
  net::Backoff backoff{std::chrono::milliseconds{100}, kRetryCap};
  std::string unknown_to;  // a registration under which the result was NOT_FOUND
  int unsound = 0;         // times that the coordinator could not read the result
  bool warned = false;
  while (!stop.stop_requested() && !revoked.stop_requested()) {
    const absl::StatusOr<std::string> worker_id = session_.worker_id(stop);
    if (!worker_id.ok()) return;
    const absl::Status uploaded = upload(link_, outcome, *worker_id, leases_.token(*outcome.unit), stop);
    // A fault of the lease would be one of the result's, too: it is no failure of the unit.
    const bool is_of_lease = absl::IsNotFound(uploaded) || absl::IsFailedPrecondition(uploaded);
    if (!uploaded.ok() && !is_of_lease && !net::is_transient(uploaded) && !stop.stop_requested()) {
      outcome.failure = uploaded;
      continue;
    }
    const absl::Status status = uploaded.ok() ? send_once(outcome, *worker_id, stop) : uploaded;
    if (status.ok()) {
      if (outcome.failure.ok()) leases_.delivered(*outcome.unit);
      std::lock_guard lock{mutex_};
      ++acknowledged_;
      return;
    }
    if (stop.stop_requested()) return;
    const bool registered_anew = !unknown_to.empty() && unknown_to != *worker_id;
    if (absl::IsNotFound(status) && !registered_anew) {
      unknown_to = *worker_id;
      session_.lost(*worker_id);
      continue;
    }
    if ((absl::IsInvalidArgument(status) || absl::IsUnimplemented(status)) && outcome.failure.ok()) {
      // Bytes may suffer on their way; bytes that arrive wrong a second time were wrong before.
      if (++unsound > 1) outcome.failure = status;
      continue;
    }
    if (!net::is_transient(status)) {
      telemetry::log(spdlog::level::warn, outcome.unit->log_fields(),
                     "unit {} of job {}: result not taken: {}", outcome.unit->unit.index(),
                     outcome.unit->job_id, status.ToString());
      return;
    }
    if (!warned) {
      telemetry::log(spdlog::level::warn, outcome.unit->log_fields(),
                     "unit {} of job {}: {}; the result is kept and sent again", outcome.unit->unit.index(),
                     outcome.unit->job_id, status.ToString());
      warned = true;
    }
    link_.wait(backoff, stop);
  }
}

absl::Status Outbox::send_once(const Outcome& outcome, const std::string& worker_id, std::stop_token stop) {
  if (outcome.failure.ok()) {
    v1::CompleteRequest request;
    request.set_worker_id(worker_id);
    *request.mutable_token() = leases_.token(*outcome.unit);
    request.set_payload(outcome.payload);
    *request.mutable_stats() = outcome.stats;
    v1::LeaseRequest more;
    const LeaseIntake::Ask ask = intake_.ask(more);
    if (ask.units > 0) *request.mutable_more() = std::move(more);
    v1::HeartbeatRequest beat;
    const bool beats = heart_.ride(*outcome.unit, beat);
    if (beats) *request.mutable_beat() = std::move(beat);
    const absl::StatusOr<v1::CompleteResponse> response = link_.complete(request, stop);
    if (beats) heart_.arrived(response.ok() && response->has_beat() ? &response->beat() : nullptr);
    intake_.answered(ask, response.ok() ? &response->more() : nullptr);
    return response.status();
  }
  leases_.give_up(*outcome.unit);
  v1::FailRequest request;
  request.set_worker_id(worker_id);
  *request.mutable_token() = leases_.token(*outcome.unit);
  const absl::string_view message = outcome.failure.message();
  request.set_message(std::string{base::beginning_of({message.data(), message.size()}, kMaxFailureMessage)});
  if (options_.recent_log) {
    for (std::string& line : options_.recent_log(outcome.unit->job_id)) request.add_log(std::move(line));
  }
  request.set_scene_fault(outcome.scene_fault);
  request.set_inputs_fault(outcome.inputs_fault);
  return link_.fail(request, stop);
}

}  // namespace tessera::agent
