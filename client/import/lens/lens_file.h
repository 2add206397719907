// Lens prescriptions in files of their own.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "import/input/diagnostics.h"
#include "optics/prescription.h"

namespace tessera::client {

struct LensFile {
  optics::Prescription lens;
  double f_number = 0;  // that it was designed for; 0: the file has none
  std::vector<std::string> warnings;
};

/// Reads a LensPrescription in protobuf text format (.textproto, .pbtxt), a lens file of pbrt (.dat, .txt) or
/// one in Zemax's text format (.zmx). InvalidArgument with located errors, one a line; NotFound.
absl::StatusOr<LensFile> read_lens_file(const std::filesystem::path& path);

/// "file:line:column: message" for each.
absl::Status status_of(const std::vector<optics::Fault>& faults, const std::string& file);

}  // namespace tessera::client
