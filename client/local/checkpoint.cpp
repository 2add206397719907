#include "local/checkpoint.h"

#include <fstream>
#include <string>
#include <system_error>

#include "absl/strings/str_cat.h"

namespace tessera::client {
namespace {

namespace fs = std::filesystem;

constexpr char kMark[] = "tessera-render-checkpoint";
constexpr char kJob[] = "job.pb";

absl::Status failed(const char* what, const fs::path& folder, const std::error_code& error) {
  return absl::ErrnoToStatus(error.value(), absl::StrCat(what, " ", folder.string()));
}

}  // namespace

absl::Status open_checkpoint(const fs::path& folder) {
  std::error_code error;
  if (fs::exists(folder / kMark, error)) return absl::OkStatus();
  if (fs::exists(folder, error) && (!fs::is_directory(folder, error) || !fs::is_empty(folder, error))) {
    return absl::InvalidArgumentError(
        absl::StrCat(folder.string(), " is not empty, and no checkpoint of a render"));
  }
  fs::create_directories(folder, error);
  if (error) return failed("make", folder, error);
  if (!std::ofstream(folder / kMark).flush()) {
    return absl::InvalidArgumentError(absl::StrCat("cannot write to ", folder.string()));
  }
  return absl::OkStatus();
}

std::optional<v1::JobSpec> begun_job(const fs::path& folder) {
  std::ifstream file(folder / kJob, std::ios::binary);
  v1::JobSpec job;
  if (!file || !job.ParseFromIstream(&file)) return std::nullopt;
  return job;
}

absl::Status keep_begun_job(const fs::path& folder, const v1::JobSpec& job) {
  // A process that ends in between leaves the old file or the new one.
  const fs::path written = folder / absl::StrCat(kJob, ".new");
  std::ofstream file(written, std::ios::binary);
  std::error_code error;
  if (file && job.SerializeToOstream(&file) && file.flush()) {
    file.close();
    fs::rename(written, folder / kJob, error);
    if (!error) return absl::OkStatus();
  }
  return absl::InvalidArgumentError(absl::StrCat("cannot write to ", folder.string()));
}

absl::Status delete_checkpoint(const fs::path& folder) {
  std::error_code error;
  if (!fs::exists(folder / kMark, error)) return absl::OkStatus();
  fs::remove_all(folder, error);
  return error ? failed("delete", folder, error) : absl::OkStatus();
}

}  // namespace tessera::client
