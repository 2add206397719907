// One upload stream.
#pragma once

#include <grpcpp/grpcpp.h>

#include <functional>
#include <string>

#include "service/rpc/open_streams.h"
#include "store/blobs/blob_store.h"
#include "telemetry/line_limit.h"
#include "tessera/v1/blob.pb.h"

namespace tessera::server {

/// State that all uploads have in common.
struct Uploads {
  BlobStore& blobs;
  OpenStreams& streams;
  /// Told of each that ended well: digest, and bytes that the call brought.
  using Done = std::function<void(const std::string&, std::uint64_t)>;
  Done done;
  /// Whether a caller may upload what the first chunk names.
  using Admit = std::function<absl::Status(const grpc::CallbackServerContext&, const v1::UploadRequest&)>;
  Admit admit;
  telemetry::LineLimit refusals = {};  // lines about uploads that there was no room for
};

/// Deletes itself when the call is over. What came before a break stays stored.
grpc::ServerReadReactor<v1::UploadRequest>* upload_blob(Uploads& uploads,
                                                        grpc::CallbackServerContext* context,
                                                        v1::UploadResponse* response);

}  // namespace tessera::server
