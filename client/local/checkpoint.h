// The folder in which `tessera render` keeps what it has rendered, to go on after a break.
#pragma once

#include <filesystem>
#include <optional>

#include "absl/status/status.h"
#include "tessera/v1/job.pb.h"

namespace tessera::client {

/// Makes the folder, or takes one that was made so. InvalidArgument when there is something else: nobody's
/// files are taken for a checkpoint, nor deleted with it.
absl::Status open_checkpoint(const std::filesystem::path& folder);

/// The job that was begun in this folder; none where that is not known.
std::optional<v1::JobSpec> begun_job(const std::filesystem::path& folder);

/// Keeps the job, so that the next process knows how its integrator was chosen. InvalidArgument where the
/// folder cannot be written.
absl::Status keep_begun_job(const std::filesystem::path& folder, const v1::JobSpec& job);

/// Deletes a folder that open_checkpoint() has made or taken.
absl::Status delete_checkpoint(const std::filesystem::path& folder);

}  // namespace tessera::client
