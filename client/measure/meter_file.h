// Files of meters: v1::MeterList as text.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "import/input/diagnostics.h"
#include "tessera/v1/meter.pb.h"

namespace tessera::client {

struct MeterFile {
  std::string path;
  v1::MeterList list;
  std::vector<std::uint32_t> line_of_meter;  // counted from 1
  std::uint32_t line_of_series = 0;          // likewise; 0: there is none

  /// InvalidArgument with all faults, each "file:line: meter 2 (desk): message".
  absl::Status status_of(const std::vector<std::pair<std::size_t, std::string>>& faults) const;
  /// InvalidArgument: "file:line: series: message".
  absl::Status fault_of_series(const std::string& message) const;
};

/// NotFound where there is no such file; InvalidArgument names file, line and column.
absl::StatusOr<MeterFile> read_meter_file(const std::string& path);

}  // namespace tessera::client
