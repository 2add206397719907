#include "service/upload_reactor.h"

#include <memory>

#include "absl/strings/str_cat.h"
#include "wire/digest.h"
#include "wire/limits.h"
#include "wire/status.h"

namespace tessera::server {
namespace {

class UploadReactor final : public grpc::ServerReadReactor<v1::UploadRequest> {
 public:
  UploadReactor(BlobStore& blobs, const BlobService::Uploaded& uploaded, grpc::CallbackServerContext* context,
                v1::UploadResponse* response)
      : blobs_(blobs), uploaded_(uploaded), context_(context), response_(response) {}

  void start() { StartRead(&chunk_); }

  void OnReadDone(bool ok) override {
    if (!ok) return context_->IsCancelled() ? end(absl::CancelledError("the client hung up")) : end(finish());
    if (verdict_.ok() && !whole_) {
      verdict_ = take_chunk();
      // Somebody else was first with the same bytes: all is well, the rest need not come.
      whole_ = absl::IsAlreadyExists(verdict_);
      if (whole_) verdict_ = absl::OkStatus();
      if (!verdict_.ok() || whole_) writer_.reset();
    }
    if (verdict_.ok() && !whole_) return StartRead(&chunk_);
    end(verdict_);
  }

  void OnDone() override { delete this; }

 private:
  void end(const absl::Status& status) {
    // Stored parts are found by the next call as soon as the client has the answer.
    writer_.reset();
    response_->set_received_bytes(received_);
    Finish(wire::to_grpc(status));
  }

  absl::Status take_chunk() {
    if (writer_ == nullptr) {
      digest_ = chunk_.blob().digest();
      size_ = chunk_.blob().size_bytes();
      stored_ = chunk_.offset();
      if (!wire::is_digest(digest_))
        return absl::InvalidArgumentError("the first chunk names no blob by SHA-256 digest");
      if (size_ > wire::kMaxBlobBytes) {
        return absl::ResourceExhaustedError(
            absl::StrCat("blob ", digest_, " is larger than ", wire::kMaxBlobBytes, " bytes"));
      }
      auto writer = blobs_.write(digest_, chunk_.offset());
      if (!writer.ok()) return writer.status();
      writer_ = *std::move(writer);
    }
    const std::string& data = chunk_.data();
    if (data.size() > wire::kBlobChunkBytes) {
      return absl::InvalidArgumentError(
          absl::StrCat("a chunk has ", data.size(), " bytes, more than ", wire::kBlobChunkBytes));
    }
    if (stored_ + data.size() > size_) {
      return absl::InvalidArgumentError(
          absl::StrCat("blob ", digest_, " is longer than the ", size_, " bytes announced"));
    }
    if (absl::Status status = writer_->append(data); !status.ok()) return status;
    stored_ += data.size();
    received_ += data.size();
    return absl::OkStatus();
  }

  absl::Status finish() {
    if (!verdict_.ok() || whole_) return verdict_;
    if (writer_ == nullptr) return absl::InvalidArgumentError("the upload has no chunk");
    if (stored_ < size_) {
      return absl::InvalidArgumentError(absl::StrCat("blob ", digest_, " ended at ", stored_, " of ", size_, " bytes"));
    }
    if (absl::Status status = writer_->finish(); !status.ok()) return status;
    uploaded_(digest_, received_);
    return absl::OkStatus();
  }

  BlobStore& blobs_;
  const BlobService::Uploaded& uploaded_;
  grpc::CallbackServerContext* const context_;
  v1::UploadResponse* const response_;
  v1::UploadRequest chunk_;
  std::unique_ptr<BlobWriter> writer_;
  absl::Status verdict_;
  bool whole_ = false;  // the blob was there already, or came from elsewhere meanwhile
  std::string digest_;
  std::uint64_t size_ = 0;      // of the whole blob
  std::uint64_t stored_ = 0;    // of it
  std::uint64_t received_ = 0;  // by this call
};

}  // namespace

grpc::ServerReadReactor<v1::UploadRequest>* upload_blob(BlobStore& blobs, const BlobService::Uploaded& uploaded,
                                                        grpc::CallbackServerContext* context,
                                                        v1::UploadResponse* response) {
  auto* const reactor = new UploadReactor(blobs, uploaded, context, response);
  reactor->start();
  return reactor;
}

}  // namespace tessera::server
