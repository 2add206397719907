// The stream of one watcher.
#pragma once

#include <grpcpp/grpcpp.h>

#include "tessera/v1/farm.pb.h"

namespace tessera::server {

class Farm;
class OpenStreams;

/// Sends results as they become durable, at the pace at which the client reads, and a status every second
/// between them. Holds one message at a time. Deletes itself when the call is over.
grpc::ServerWriteReactor<v1::WatchJobResponse>* watch_job(Farm& farm, OpenStreams& streams,
                                                          grpc::CallbackServerContext* context,
                                                          const v1::WatchJobRequest& request);

}  // namespace tessera::server
