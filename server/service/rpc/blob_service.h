// BlobService: content-addressed bytes, up and down.
#pragma once

#include <grpcpp/grpcpp.h>

#include <utility>

#include "service/rpc/upload_reactor.h"
#include "tessera/v1/blob.grpc.pb.h"

namespace tessera::server {

/// Store and streams must outlive the service.
class BlobService final : public v1::BlobService::CallbackService {
 public:
  BlobService(BlobStore& blobs, OpenStreams& streams, Uploads::Done uploaded, Uploads::Admit admit)
      : uploads_{.blobs = blobs, .streams = streams, .done = std::move(uploaded), .admit = std::move(admit)} {
  }

  grpc::ServerUnaryReactor* FindMissing(grpc::CallbackServerContext* context,
                                        const v1::FindMissingRequest* request,
                                        v1::FindMissingResponse* response) override;
  grpc::ServerReadReactor<v1::UploadRequest>* Upload(grpc::CallbackServerContext* context,
                                                     v1::UploadResponse* response) override;
  grpc::ServerUnaryReactor* QueryUpload(grpc::CallbackServerContext* context,
                                        const v1::QueryUploadRequest* request,
                                        v1::QueryUploadResponse* response) override;
  grpc::ServerWriteReactor<v1::DownloadResponse>* Download(grpc::CallbackServerContext* context,
                                                           const v1::DownloadRequest* request) override;

 private:
  Uploads uploads_;
};

}  // namespace tessera::server
