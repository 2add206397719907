#include "image/node_store.h"

#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"

namespace tessera::client {
namespace {

std::size_t bytes_of(const wire::TileResult& result) {
  return sizeof(float) * result.values.size() + sizeof(std::uint32_t) * result.counts.size();
}

absl::Status file_error(const char* what) {
  return absl::InternalError(
      absl::StrCat("temporary file for tile results: cannot ", what, ": ", strerror(errno)));
}

}  // namespace

absl::Status NodeStore::open_file() {
  std::error_code error;
  std::filesystem::path directory = std::filesystem::temp_directory_path(error);
  if (error) directory = "/tmp";
  std::string name = (directory / "tessera-tiles-XXXXXX").string();
  const int fd = mkstemp(name.data());
  if (fd < 0) return file_error("create");
  unlink(name.c_str());  // it goes away with this process, however that ends
  file_.reset(fdopen(fd, "w+b"));
  if (!file_) {
    close(fd);
    return file_error("open");
  }
  return absl::OkStatus();
}

absl::StatusOr<NodeStore::Entry> NodeStore::put(wire::TileResult result) {
  const std::size_t bytes = bytes_of(result);
  if (bytes_ + bytes <= max_bytes_) {
    bytes_ += bytes;
    return Entry{std::move(result), 0, 0};
  }
  if (!file_) {
    if (absl::Status status = open_file(); !status.ok()) return status;
  }
  const std::string encoded = wire::encode_tile_result(result);
  if (std::fseek(file_.get(), file_end_, SEEK_SET) != 0) return file_error("seek");
  if (std::fwrite(encoded.data(), 1, encoded.size(), file_.get()) != encoded.size())
    return file_error("write");
  Entry entry{std::nullopt, file_end_, encoded.size()};
  file_end_ += static_cast<long>(encoded.size());
  return entry;
}

absl::StatusOr<wire::TileResult> NodeStore::take(Entry entry) {
  if (entry.result) {
    bytes_ -= bytes_of(*entry.result);
    return std::move(*entry.result);
  }
  std::string encoded(entry.size, '\0');
  if (std::fseek(file_.get(), entry.offset, SEEK_SET) != 0) return file_error("seek");
  if (std::fread(encoded.data(), 1, encoded.size(), file_.get()) != encoded.size()) return file_error("read");
  absl::StatusOr<wire::TileResult> result = wire::decode_tile_result(encoded);
  if (!result.ok())
    return absl::InternalError(absl::StrCat("temporary file for tile results: ", result.status().message()));
  return result;
}

}  // namespace tessera::client
