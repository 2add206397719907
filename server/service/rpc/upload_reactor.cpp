#include "service/rpc/upload_reactor.h"

#include <optional>

#include "net/status.h"
#include "service/rpc/access.h"
#include "service/rpc/blob_upload.h"
#include "telemetry/log.h"

namespace tessera::server {
namespace {

class UploadReactor final : public grpc::ServerReadReactor<v1::UploadRequest> {
 public:
  UploadReactor(Uploads& uploads, grpc::CallbackServerContext* context, v1::UploadResponse* response)
      : uploads_(uploads),
        upload_(std::in_place, uploads.blobs,
                [this](const v1::UploadRequest& first) { return uploads_.admit(*context_, first); }),
        stream_(uploads.streams, context, "upload"),
        context_(context),
        response_(response) {}

  void start() {
    const absl::Status status = stream_.admitted();
    status.ok() ? read() : end(status);
  }

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
    if (absl::IsResourceExhausted(status)) log_refusal(status);
    response_->set_received_bytes(upload_->received_bytes());
    // Stored parts are found by the next call as soon as the client has the answer.
    upload_.reset();
    Finish(net::to_grpc(status));
  }

  absl::Status finish() {
    absl::Status status = upload_->finish();
    if (status.ok() && upload_->wants_more()) uploads_.done(upload_->digest(), upload_->received_bytes());
    return status;
  }

  void log_refusal(const absl::Status& why) {
    const auto [write, left_out] = uploads_.refusals.count();
    if (!write) return;
    const std::string user = caller_of(context_->auth_context().get()).user;
    const std::string peer = context_->peer();
    telemetry::log(spdlog::level::warn, {.user = user, .peer = peer},
                   "an upload of {} is refused: {} ({} such lines left out before)", upload_->digest(),
                   std::string(why.message()), left_out);
  }

  Uploads& uploads_;
  std::optional<BlobUpload> upload_;
  OpenStreams::Stream stream_;
  grpc::CallbackServerContext* const context_;
  v1::UploadResponse* const response_;
  v1::UploadRequest chunk_;
};

}  // namespace

grpc::ServerReadReactor<v1::UploadRequest>* upload_blob(Uploads& uploads,
                                                        grpc::CallbackServerContext* context,
                                                        v1::UploadResponse* response) {
  auto* const reactor = new UploadReactor(uploads, context, response);
  reactor->start();
  return reactor;
}

}  // namespace tessera::server
