// The generated gRPC stubs, for the sources of this folder only.
#pragma once

#include "farm/farm_client.h"
#include "tessera/v1/blob.grpc.pb.h"
#include "tessera/v1/farm.grpc.pb.h"

namespace tessera::client {

struct FarmClient::Stubs {
  std::unique_ptr<v1::FarmService::Stub> farm;
  std::unique_ptr<v1::BlobService::Stub> blob;
};

}  // namespace tessera::client
