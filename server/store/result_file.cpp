#include "store/result_file.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"

namespace tessera::server {

ResultFile::ResultFile(Disk& disk, std::filesystem::path path, std::vector<std::uint64_t> ends)
    : disk_(disk),
      path_(std::move(path)),
      count_(ends.size()),
      ends_(std::move(ends)),
      kept_(ends_.empty() ? 0 : ends_.back()),
      appended_(kept_) {}

ResultFile::ResultFile(Disk& disk, std::filesystem::path path, std::uint64_t count, std::uint64_t end)
    : disk_(disk),
      path_(std::move(path)),
      count_(count),
      before_(count),
      begin_(end),
      kept_(end),
      appended_(end) {}

std::uint64_t ResultFile::size() const {
  const auto file = disk_.open(path_, /*create=*/false);
  const absl::StatusOr<std::uint64_t> size = file.ok() ? (*file)->size() : file.status();
  return size.ok() ? *size : 0;
}

std::uint64_t ResultFile::whole_results() const {
  return static_cast<std::uint64_t>(std::upper_bound(ends_.begin(), ends_.end(), size()) - ends_.begin());
}

bool ResultFile::holds(std::uint64_t bytes) const { return bytes == 0 || size() >= bytes; }

absl::StatusOr<std::uint64_t> ResultFile::append(std::string_view payload) {
  const std::lock_guard lock(mutex_);
  if (in_memory() && !memory_) {
    absl::StatusOr<File> made = File::in_memory();
    if (!made.ok()) return made.status();
    memory_ = *std::move(made);
  }
  if (!in_memory() && !file_) {
    auto opened = disk_.open(path_, /*create=*/true);
    if (!opened.ok()) return opened.status();
    file_ = *std::move(opened);
  }
  const absl::Status status =
      in_memory() ? memory_->write_at(appended_, payload) : file_->write_at(appended_, payload);
  if (!status.ok()) return status;
  return appended_ += payload.size();
}

void ResultFile::keep(std::uint64_t end) {
  const std::lock_guard lock(mutex_);
  if (before_ + ends_.size() != count_) {  // a page of earlier ones, of a job that goes on again
    before_ = count_;
    begin_ = kept_;
    ends_.clear();
  }
  ends_.push_back(end);
  kept_ = end;
  ++count_;
}

void ResultFile::close() {
  const std::lock_guard lock(mutex_);
  file_.reset();
}

void ResultFile::forget_ends() { remember_ends(count_, kept_, {}); }

void ResultFile::remember_ends(std::uint64_t before, std::uint64_t begin, std::vector<std::uint64_t> ends) {
  const std::lock_guard lock(mutex_);
  before_ = before;
  begin_ = begin;
  ends_ = std::move(ends);
}

absl::StatusOr<std::optional<ResultFile::Extent>> ResultFile::extent(std::uint64_t sequence) const {
  const std::lock_guard lock(mutex_);
  if (sequence == 0 || sequence > count_)
    return absl::OutOfRangeError(absl::StrCat("there is no result ", sequence));
  if (sequence <= before_ || sequence > before_ + ends_.size()) return std::nullopt;
  const std::uint64_t i = sequence - before_ - 1;
  return Extent{.begin = i == 0 ? begin_ : ends_[i - 1], .end = ends_[i]};
}

absl::StatusOr<std::string> ResultFile::read(const Extent& extent) const {
  const std::lock_guard lock(mutex_);
  const auto read_from = [&](const auto& file) -> absl::StatusOr<std::string> {
    // The journal is not believed before the file is seen to be as long.
    const absl::StatusOr<std::uint64_t> size = file.size();
    if (!size.ok()) return size.status();
    if (*size < extent.end) return absl::DataLossError(absl::StrCat(path_.string(), " was cut"));
    std::string payload(extent.end - extent.begin, '\0');
    if (absl::Status status = file.read_at(extent.begin, payload.data(), payload.size()); !status.ok())
      return status;
    return payload;
  };
  if (in_memory()) return read_from(*memory_);
  if (file_) return read_from(*file_);
  const auto file = disk_.open(path_, /*create=*/false);
  return file.ok() ? read_from(**file) : file.status();
}

}  // namespace tessera::server
