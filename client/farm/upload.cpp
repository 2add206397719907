// FarmClient: blobs that the coordinator lacks.
#include <algorithm>
#include <fstream>
#include <memory>
#include <unordered_map>
#include <utility>

#include "farm/farm_client.h"
#include "farm/stubs.h"
#include "net/call.h"
#include "net/upload.h"
#include "wire/limits.h"

namespace tessera::client {
namespace {

constexpr std::chrono::milliseconds kUploadCallTimeout = std::chrono::seconds{30};
constexpr int kMaxCorruptUploads = 3;

/// Reads a blob from memory, or from its file.
net::BlobPieces pieces_of(const SceneBlob& blob) {
  if (blob.file.empty()) {
    return {blob.ref, [&blob](std::uint64_t offset, std::size_t size) -> absl::StatusOr<std::string> {
              return blob.bytes.substr(offset, size);
            }};
  }
  const auto file = std::make_shared<std::ifstream>();
  return {blob.ref, [&blob, file](std::uint64_t offset, std::size_t size) -> absl::StatusOr<std::string> {
            if (!file->is_open()) {
              file->open(blob.file, std::ios::binary);
              file->seekg(static_cast<std::streamoff>(offset));
            }
            if (!*file) return absl::NotFoundError(absl::StrCat(blob.file, ": cannot be read any more"));
            std::string piece(size, '\0');
            if (!file->read(piece.data(), static_cast<std::streamsize>(size)))
              return absl::DataLossError(absl::StrCat(blob.file, ": became shorter since it was imported"));
            return piece;
          }};
}

std::string describe(const SceneBlob& blob) {
  return blob.ref.path().empty() ? absl::StrCat("blob ", blob.ref.digest()) : blob.ref.path();
}

}  // namespace

absl::StatusOr<std::uint64_t> FarmClient::upload(const std::vector<const SceneBlob*>& blobs,
                                                 std::stop_token stop, const UploadProgress& progress) {
  std::unordered_map<std::string, const SceneBlob*> by_digest;
  for (const SceneBlob* blob : blobs) by_digest.emplace(blob->ref.digest(), blob);

  const absl::StatusOr<std::vector<v1::BlobRef>> missing = find_missing(blobs, stop);
  if (!missing.ok()) return missing.status();
  std::uint64_t sent = 0, total = 0;
  for (const v1::BlobRef& ref : *missing) total += ref.size_bytes();
  const auto told = [&](std::uint64_t of_blob) {
    if (progress) progress(sent + of_blob, total);
  };
  for (const v1::BlobRef& ref : *missing) {
    const auto found = by_digest.find(ref.digest());
    if (found == by_digest.end())
      return absl::InternalError("FindMissing named a blob that was not asked about");
    const absl::StatusOr<std::uint64_t> bytes = upload_blob(*found->second, told, stop);
    if (!bytes.ok()) return bytes.status();
    sent += *bytes;
  }
  return sent;
}

absl::StatusOr<std::vector<v1::BlobRef>> FarmClient::find_missing(const std::vector<const SceneBlob*>& blobs,
                                                                  std::stop_token stop) {
  std::vector<v1::BlobRef> missing;
  for (std::size_t begin = 0; begin < blobs.size(); begin += wire::kMaxFindMissing) {
    v1::FindMissingRequest request;
    const std::size_t end = std::min(blobs.size(), begin + wire::kMaxFindMissing);
    for (std::size_t i = begin; i < end; ++i) *request.add_blobs() = blobs[i]->ref;
    auto response = contact_.retried(stop, [&] {
      return net::unary_call(*stubs_->blob, &v1::BlobService::Stub::FindMissing, request, "FindMissing",
                             contact_.address(), kUploadCallTimeout, stop);
    });
    if (!response.ok()) return response.status();
    missing.insert(missing.end(), response->missing().begin(), response->missing().end());
  }
  return missing;
}

absl::StatusOr<std::uint64_t> FarmClient::upload_blob(const SceneBlob& blob, const Sent& told,
                                                      std::stop_token stop) {
  std::uint64_t sent = 0;
  for (int corrupt = 0; corrupt < kMaxCorruptUploads;) {
    const auto done = contact_.retried(stop, [&]() -> absl::StatusOr<bool> {
      const auto count = [&](std::uint64_t bytes) { told(sent += bytes); };
      const absl::Status status =
          net::upload_rest(*stubs_->blob, pieces_of(blob), contact_.address(), stop, count);
      if (status.ok()) return true;
      // The stored part did not fit: the next attempt asks anew where it ends.
      if (absl::IsDataLoss(status) || absl::IsOutOfRange(status)) return false;
      return status;
    });
    if (!done.ok()) return done.status();
    if (*done) return sent;
    ++corrupt;
  }
  return absl::DataLossError(
      absl::StrCat(describe(blob), ": the bytes do not match their digest; was the file changed?"));
}

}  // namespace tessera::client
