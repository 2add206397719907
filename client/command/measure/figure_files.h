// Files that `tessera measure` writes: tables, pages, maps and lamps.
#pragma once

#include <string>

#include "absl/status/status.h"
#include "measure/measured.h"
#include "tessera/v1/meter.pb.h"

namespace tessera::client {

/// Paths; empty: not written.
struct FigureFiles {
  std::string figures;  // .csv, .json or .txt; empty: printed
  std::string html, lamp, maps;
  bool all_cells = false;  // in tables
};

/// InvalidArgument for figures in a file of another kind.
absl::Status check_figures_file(const std::string& path);

/// Writes a run, or prints it. InvalidArgument where there is no lamp to be written; Unavailable where a file
/// cannot be.
absl::Status write_figures(const FigureFiles& files, const v1::MeterList& list, const Measured& measured);
/// Likewise of a series; maps of a step are in a folder of its own, "hour-11".
absl::Status write_figures(const FigureFiles& files, const v1::MeterList& list, const MeasuredSeries& series);

}  // namespace tessera::client
