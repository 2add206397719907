#include "store/result_file.h"

#include <utility>

#include "absl/strings/str_cat.h"

namespace tessera::server {

ResultFile::ResultFile(std::filesystem::path path, std::vector<std::uint64_t> ends)
    : path_(std::move(path)), ends_(std::move(ends)), appended_(ends_.empty() ? 0 : ends_.back()) {}

absl::Status ResultFile::check() const {
  std::error_code error;
  const std::uint64_t size = std::filesystem::file_size(path_, error);
  if (!error && size >= appended_) return absl::OkStatus();
  return absl::DataLossError(absl::StrCat(path_.string(), error ? " is missing" : absl::StrCat(" has ", size, " bytes"),
                                          ", but the journal knows of ", appended_, " bytes of results"));
}

absl::StatusOr<std::uint64_t> ResultFile::append(std::string_view payload) {
  const std::lock_guard lock(mutex_);
  if (!file_) {
    absl::StatusOr<File> opened = in_memory() ? File::in_memory() : File::open_or_create(path_);
    if (!opened.ok()) return opened.status();
    file_ = *std::move(opened);
  }
  if (absl::Status status = file_->write_at(appended_, payload); !status.ok()) return status;
  return appended_ += payload.size();
}

absl::Status ResultFile::sync() {
  // Only the writer opens and closes the file: readers may go on meanwhile.
  return in_memory() || !file_ ? absl::OkStatus() : file_->sync();
}

void ResultFile::keep(std::uint64_t end) {
  const std::lock_guard lock(mutex_);
  ends_.push_back(end);
}

void ResultFile::close() {
  const std::lock_guard lock(mutex_);
  if (!in_memory()) file_.reset();
}

absl::StatusOr<std::string> ResultFile::read(std::uint64_t sequence) const {
  const std::lock_guard lock(mutex_);
  if (sequence == 0 || sequence > ends_.size())
    return absl::OutOfRangeError(absl::StrCat("there is no result ", sequence));
  const std::uint64_t begin = sequence == 1 ? 0 : ends_[sequence - 2];
  std::string payload(ends_[sequence - 1] - begin, '\0');
  if (file_) {
    if (absl::Status status = file_->read_at(begin, payload.data(), payload.size()); !status.ok()) return status;
    return payload;
  }
  const absl::StatusOr<File> file = File::open_existing(path_);
  if (!file.ok()) return file.status();
  if (absl::Status status = file->read_at(begin, payload.data(), payload.size()); !status.ok()) return status;
  return payload;
}

}  // namespace tessera::server
