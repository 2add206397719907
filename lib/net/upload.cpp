#include "net/upload.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "absl/strings/str_cat.h"
#include "net/call.h"
#include "net/status.h"
#include "wire/limits.h"

namespace tessera::net {
namespace {

constexpr std::chrono::milliseconds kCallTimeout = std::chrono::seconds{30};
constexpr std::chrono::milliseconds kStall = std::chrono::seconds{30};

}  // namespace

absl::Status upload_rest(v1::BlobService::Stub& stub, const BlobPieces& blob, const std::string& address,
                         std::stop_token stop, const std::function<void(std::uint64_t)>& sent) {
  v1::QueryUploadRequest query;
  *query.mutable_blob() = blob.ref;
  const auto stored = unary_call(stub, &v1::BlobService::Stub::QueryUpload, query, "QueryUpload", address,
                                 kCallTimeout, stop);
  if (!stored.ok()) return stored.status();
  if (stored->complete()) return absl::OkStatus();

  grpc::ClientContext context;
  std::stop_callback cancel{stop, [&context] { context.TryCancel(); }};
  StallGuard guard{context, kStall};
  v1::UploadResponse response;
  const auto writer = stub.Upload(&context, &response);
  v1::UploadRequest request = blob.first;
  *request.mutable_blob() = blob.ref;
  std::uint64_t offset = stored->stored_bytes();
  request.set_offset(offset);
  // An empty blob, or one whose last byte is stored but not verified, still takes one message.
  absl::Status local;
  do {
    absl::StatusOr<std::string> piece =
        blob.read(offset, std::min<std::uint64_t>(wire::kBlobChunkBytes, blob.ref.size_bytes() - offset));
    local = piece.status();
    if (!local.ok()) break;
    const std::uint64_t size = piece->size();
    request.set_data(*std::move(piece));
    if (!writer->Write(request)) break;
    guard.progress();
    offset += size;
    sent(size);
    request.Clear();
  } while (offset < blob.ref.size_bytes());
  if (local.ok()) {
    writer->WritesDone();
  } else {
    context.TryCancel();
  }
  const grpc::Status status = writer->Finish();
  if (!local.ok()) return local;
  const std::string call = absl::StrCat("Upload at ", address);
  if (guard.stalled()) return absl::DeadlineExceededError(absl::StrCat(call, ": no progress for 30 s"));
  const absl::Status uploaded = status.ok() ? absl::OkStatus() : from_grpc(status, call);
  return absl::IsAlreadyExists(uploaded) ? absl::OkStatus() : uploaded;
}

}  // namespace tessera::net
