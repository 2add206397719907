// One upload stream.
#pragma once

#include <grpcpp/grpcpp.h>

#include "service/blob_service.h"
#include "service/open_streams.h"
#include "store/blob_store.h"
#include "tessera/v1/blob.pb.h"

namespace tessera::server {

/// Deletes itself when the call is over. What came before a break stays stored.
grpc::ServerReadReactor<v1::UploadRequest>* upload_blob(BlobStore& blobs, OpenStreams& streams,
                                                        const BlobService::Uploaded& uploaded,
                                                        grpc::CallbackServerContext* context,
                                                        v1::UploadResponse* response);

}  // namespace tessera::server
