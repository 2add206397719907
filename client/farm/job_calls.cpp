#include "farm/job_calls.h"

#include <random>

#include "absl/strings/str_cat.h"
#include "wire/printable_message.h"

namespace tessera::client {

std::string make_request_id() {
  std::random_device random;
  std::string id;
  for (int i = 0; i < 4; ++i) absl::StrAppend(&id, absl::Hex(random(), absl::kZeroPad8));
  return id;
}

bool WatchProgress::take(v1::WatchJobResponse& response, const JobCalls::WatchHandlers& handlers) {
  if (response.has_status()) wire::make_printable(*response.mutable_status());
  if (after > 0 && response.status().revision() != last.revision()) {
    last = response.status();
    after = 0;
    restarted = true;
    if (handlers.restart) handler_status = handlers.restart();
    return false;
  }
  for (const v1::UnitResult& result : response.results()) {
    if (result.sequence() <= after) continue;
    handler_status = handlers.result(result);
    if (!handler_status.ok()) break;
    after = result.sequence();
  }
  if (response.has_status()) {
    last = response.status();
    if (handlers.status) handlers.status(last);
  }
  return handler_status.ok();
}

bool has_ended(v1::JobState state) {
  return state == v1::DONE || state == v1::INCOMPLETE || state == v1::FAILED || state == v1::CANCELLED;
}

}  // namespace tessera::client
