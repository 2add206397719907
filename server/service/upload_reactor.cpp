#include "service/upload_reactor.h"

#include <optional>

#include "service/blob_upload.h"
#include "wire/status.h"

namespace tessera::server {
namespace {

class UploadReactor final : public grpc::ServerReadReactor<v1::UploadRequest> {
 public:
  UploadReactor(BlobStore& blobs, OpenStreams& streams, const BlobService::Uploaded& uploaded,
                grpc::CallbackServerContext* context, v1::UploadResponse* response)
      : upload_(blobs),
        stream_(streams, context, "upload"),
        uploaded_(uploaded),
        context_(context),
        response_(response) {}

  void read() {
    stream_.begin_message();
    StartRead(&chunk_);
  }

  void OnReadDone(bool ok) override {
    stream_.end_message();
    if (!ok) return context_->IsCancelled() ? end(absl::CancelledError("the client hung up")) : end(finish());
    const absl::Status status = upload_->take(chunk_);
    if (status.ok() && upload_->wants_more()) return read();
    end(status);
  }

  void OnDone() override { delete this; }

 private:
  void end(const absl::Status& status) {
    response_->set_received_bytes(upload_->received_bytes());
    // Stored parts are found by the next call as soon as the client has the answer.
    upload_.reset();
    Finish(wire::to_grpc(status));
  }

  absl::Status finish() {
    const absl::Status status = upload_->finish();
    if (status.ok() && upload_->wants_more()) uploaded_(upload_->digest(), upload_->received_bytes());
    return status;
  }

  std::optional<BlobUpload> upload_;
  OpenStreams::Stream stream_;
  const BlobService::Uploaded& uploaded_;
  grpc::CallbackServerContext* const context_;
  v1::UploadResponse* const response_;
  v1::UploadRequest chunk_;
};

}  // namespace

grpc::ServerReadReactor<v1::UploadRequest>* upload_blob(BlobStore& blobs, OpenStreams& streams,
                                                        const BlobService::Uploaded& uploaded,
                                                        grpc::CallbackServerContext* context,
                                                        v1::UploadResponse* response) {
  auto* const reactor = new UploadReactor(blobs, streams, uploaded, context, response);
  reactor->read();
  return reactor;
}

}  // namespace tessera::server
