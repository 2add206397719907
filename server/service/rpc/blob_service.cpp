#include "service/rpc/blob_service.h"

#include <spdlog/spdlog.h>

#include "absl/strings/str_cat.h"
#include "net/status.h"
#include "service/rpc/answer.h"
#include "wire/digest.h"
#include "wire/limits.h"

namespace tessera::server {
namespace {

absl::Status check_digest(const v1::BlobRef& blob) {
  return wire::is_digest(blob.digest())
             ? absl::OkStatus()
             : absl::InvalidArgumentError(absl::StrCat("blob \"", blob.path(), "\" has no SHA-256 digest"));
}

/// Sends a blob from an offset on, a chunk at a time, as fast as it is read.
class DownloadReactor final : public grpc::ServerWriteReactor<v1::DownloadResponse> {
 public:
  DownloadReactor(BlobStore& blobs, OpenStreams& streams, grpc::CallbackServerContext* context,
                  const v1::DownloadRequest& request)
      : stream_(streams, context, "download"), offset_(request.offset()) {
    start(blobs, request);
  }

  void OnWriteDone(bool ok) override {
    stream_.end_message();
    ok ? send_chunk() : Finish(grpc::Status::CANCELLED);
  }

  void OnDone() override { delete this; }

 private:
  void start(BlobStore& blobs, const v1::DownloadRequest& request) {
    if (absl::Status status = stream_.admitted(); !status.ok()) return Finish(net::to_grpc(status));
    if (absl::Status status = check_digest(request.blob()); !status.ok()) return Finish(net::to_grpc(status));
    const std::string& digest = request.blob().digest();
    if (request.doubted()) {
      if (absl::Status status = drop_if_damaged(blobs, digest); !status.ok()) {
        spdlog::error("{}", std::string(status.message()));
        return Finish(net::to_grpc(status));
      }
    }
    auto reader = blobs.read(digest);
    if (!reader.ok()) return Finish(net::to_grpc(reader.status()));
    reader_ = *std::move(reader);
    send_chunk();
  }

  void send_chunk() {
    if (offset_ >= reader_->size()) return Finish(grpc::Status::OK);
    absl::StatusOr<std::string> bytes = reader_->read(offset_, wire::kBlobChunkBytes);
    if (!bytes.ok()) return Finish(net::to_grpc(bytes.status()));
    offset_ += bytes->size();
    message_.set_data(*std::move(bytes));
    stream_.begin_message();
    StartWrite(&message_);
  }

  OpenStreams::Stream stream_;
  std::unique_ptr<BlobReader> reader_;
  std::uint64_t offset_;
  v1::DownloadResponse message_;
};

}  // namespace

grpc::ServerUnaryReactor* BlobService::FindMissing(grpc::CallbackServerContext* context,
                                                   const v1::FindMissingRequest* request,
                                                   v1::FindMissingResponse* response) {
  grpc::ServerUnaryReactor* const reactor = context->DefaultReactor();
  if (request->blobs_size() > wire::kMaxFindMissing) {
    return answer(reactor, absl::ResourceExhaustedError(
                               absl::StrCat("more than ", wire::kMaxFindMissing, " blobs in one call")));
  }
  for (const v1::BlobRef& blob : request->blobs()) {
    if (absl::Status status = check_digest(blob); !status.ok()) return answer(reactor, status);
    if (!uploads_.blobs.query(blob.digest()).complete) *response->add_missing() = blob;
  }
  return answer(reactor, absl::OkStatus());
}

grpc::ServerReadReactor<v1::UploadRequest>* BlobService::Upload(grpc::CallbackServerContext* context,
                                                                v1::UploadResponse* response) {
  return upload_blob(uploads_, context, response);
}

grpc::ServerUnaryReactor* BlobService::QueryUpload(grpc::CallbackServerContext* context,
                                                   const v1::QueryUploadRequest* request,
                                                   v1::QueryUploadResponse* response) {
  grpc::ServerUnaryReactor* const reactor = context->DefaultReactor();
  if (absl::Status status = check_digest(request->blob()); !status.ok()) return answer(reactor, status);
  const UploadState state = uploads_.blobs.query(request->blob().digest());
  response->set_stored_bytes(state.stored_bytes);
  response->set_complete(state.complete);
  return answer(reactor, absl::OkStatus());
}

grpc::ServerWriteReactor<v1::DownloadResponse>* BlobService::Download(grpc::CallbackServerContext* context,
                                                                      const v1::DownloadRequest* request) {
  return new DownloadReactor(uploads_.blobs, uploads_.streams, context, *request);
}

}  // namespace tessera::server
