// BlobService: content-addressed bytes, up and down.
#pragma once

#include <grpcpp/grpcpp.h>

#include <functional>
#include <string>

#include "service/open_streams.h"
#include "store/blob_store.h"
#include "tessera/v1/blob.grpc.pb.h"

namespace tessera::server {

/// Store and streams must outlive the service.
class BlobService final : public v1::BlobService::CallbackService {
 public:
  /// Digest, and bytes that this call brought.
  using Uploaded = std::function<void(const std::string&, std::uint64_t)>;

  BlobService(BlobStore& blobs, OpenStreams& streams, Uploaded uploaded)
      : blobs_(blobs), streams_(streams), uploaded_(std::move(uploaded)) {}

  grpc::ServerUnaryReactor* FindMissing(grpc::CallbackServerContext* context, const v1::FindMissingRequest* request,
                                        v1::FindMissingResponse* response) override;
  grpc::ServerReadReactor<v1::UploadRequest>* Upload(grpc::CallbackServerContext* context,
                                                     v1::UploadResponse* response) override;
  grpc::ServerUnaryReactor* QueryUpload(grpc::CallbackServerContext* context, const v1::QueryUploadRequest* request,
                                        v1::QueryUploadResponse* response) override;
  grpc::ServerWriteReactor<v1::DownloadResponse>* Download(grpc::CallbackServerContext* context,
                                                           const v1::DownloadRequest* request) override;

 private:
  BlobStore& blobs_;
  OpenStreams& streams_;
  Uploaded uploaded_;
};

}  // namespace tessera::server
