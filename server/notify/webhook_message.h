// The message of a webhook, and the signature by which its receiver knows that it is true.
#pragma once

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "tessera/v1/job.pb.h"

namespace tessera::server {

/// The end of a job as a JSON object: "event" ("job.ended"), "job", "name", "comment", "user", "state"
/// ("done", "failed", "cancelled", "incomplete"), "error", "units_done", "units_total", "units_set_aside",
/// "cpu_seconds", "submitted_unix_ms", "finished_unix_ms".
std::string end_message(const v1::JobStatus& status);

/// "v1=" and 64 hexadecimal digits: HMAC-SHA256 [RFC 2104] with `key` of the time in seconds, a dot, and the
/// body. The time is part of it so that a receiver can refuse what was recorded and sent again.
std::string signature_of(const std::string& key, std::int64_t unix_seconds, const std::string& body);

/// The key in a file that nobody else can read: its bytes, but for one end of line behind them.
/// InvalidArgument for one of fewer than 16 bytes; errors of reading.
absl::StatusOr<std::string> read_webhook_key(const std::string& file);

}  // namespace tessera::server
