// FarmClient: blobs that the coordinator lacks.
#include <algorithm>
#include <fstream>
#include <memory>
#include <unordered_map>
#include <utility>

#include "farm/farm_client.h"
#include "farm/stubs.h"
#include "wire/call.h"
#include "wire/limits.h"

namespace tessera::client {
namespace {

constexpr std::chrono::milliseconds kCallTimeout = std::chrono::seconds{30};
constexpr std::chrono::milliseconds kUploadStall = std::chrono::seconds{30};
constexpr int kMaxCorruptUploads = 3;

/// Pieces of a blob, from memory or from its file.
class BlobReader {
 public:
  static absl::StatusOr<BlobReader> open(const SceneBlob& blob, std::uint64_t offset) {
    BlobReader reader{blob, offset};
    if (blob.file.empty()) return reader;
    reader.file_ = std::make_unique<std::ifstream>(blob.file, std::ios::binary);
    reader.file_->seekg(static_cast<std::streamoff>(offset));
    if (!*reader.file_) return absl::NotFoundError(absl::StrCat(blob.file, ": cannot be read any more"));
    return reader;
  }

  bool at_end() const { return offset_ == blob_->ref.size_bytes(); }

  /// The next piece into `data`.
  absl::Status next(std::string& data) {
    const std::uint64_t size =
        std::min<std::uint64_t>(wire::kBlobChunkBytes, blob_->ref.size_bytes() - offset_);
    if (file_ == nullptr) {
      data.assign(blob_->bytes, offset_, size);
    } else {
      data.resize(size);
      if (!file_->read(data.data(), static_cast<std::streamsize>(size))) {
        return absl::DataLossError(absl::StrCat(blob_->file, ": became shorter since it was imported"));
      }
    }
    offset_ += size;
    return absl::OkStatus();
  }

 private:
  BlobReader(const SceneBlob& blob, std::uint64_t offset) : blob_(&blob), offset_(offset) {}

  const SceneBlob* blob_;
  std::uint64_t offset_;
  std::unique_ptr<std::ifstream> file_;
};

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
      return wire::unary_call(*stubs_->blob, &v1::BlobService::Stub::FindMissing, request, "FindMissing",
                              contact_.address(), kCallTimeout, stop);
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
      const absl::Status status = upload_rest(blob, sent, told, stop);
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

absl::Status FarmClient::upload_rest(const SceneBlob& blob, std::uint64_t& sent, const Sent& told,
                                     std::stop_token stop) {
  v1::QueryUploadRequest query;
  *query.mutable_blob() = blob.ref;
  const auto stored = wire::unary_call(*stubs_->blob, &v1::BlobService::Stub::QueryUpload, query,
                                       "QueryUpload", contact_.address(), kCallTimeout, stop);
  if (!stored.ok()) return stored.status();
  if (stored->complete()) return absl::OkStatus();
  absl::StatusOr<BlobReader> reader = BlobReader::open(blob, stored->stored_bytes());
  if (!reader.ok()) return reader.status();

  grpc::ClientContext context;
  std::stop_callback cancel{stop, [&context] { context.TryCancel(); }};
  wire::StallGuard guard{context, kUploadStall};
  v1::UploadResponse response;
  const auto writer = stubs_->blob->Upload(&context, &response);
  v1::UploadRequest request;
  *request.mutable_blob() = blob.ref;
  request.set_offset(stored->stored_bytes());
  // An empty blob, or one whose last byte is stored but not verified, still takes one message.
  absl::Status local;
  do {
    local = reader->next(*request.mutable_data());
    if (!local.ok() || !writer->Write(request)) break;
    guard.progress();
    sent += request.data().size();
    told(sent);
    request.Clear();
  } while (!reader->at_end());
  if (local.ok()) {
    writer->WritesDone();
  } else {
    context.TryCancel();
  }
  const grpc::Status status = writer->Finish();
  if (!local.ok()) return local;
  const std::string call = absl::StrCat("Upload at ", contact_.address());
  if (guard.stalled()) return absl::DeadlineExceededError(absl::StrCat(call, ": no progress for 30 s"));
  const absl::Status uploaded = status.ok() ? absl::OkStatus() : wire::from_grpc(status, call);
  // Another client uploaded the same bytes meanwhile.
  return absl::IsAlreadyExists(uploaded) ? absl::OkStatus() : uploaded;
}

}  // namespace tessera::client
