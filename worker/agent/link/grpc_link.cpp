#include "agent/link/grpc_link.h"

#include <grpcpp/channel.h>

#include <utility>

#include "absl/strings/str_cat.h"
#include "net/call.h"
#include "net/channel.h"
#include "net/status.h"
#include "net/upload.h"
#include "tessera/v1/blob.grpc.pb.h"
#include "tessera/v1/work.grpc.pb.h"

namespace tessera::agent {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr milliseconds kCallTimeout = seconds{15};
constexpr milliseconds kDeregisterTimeout = seconds{3};
constexpr milliseconds kLeaseMargin = seconds{10};
constexpr milliseconds kChunkTimeout = seconds{30};

}  // namespace

struct GrpcLink::Stubs {
  std::unique_ptr<v1::WorkService::Stub> work;
  std::unique_ptr<v1::BlobService::Stub> blob;
};

GrpcLink::GrpcLink(std::shared_ptr<grpc::Channel> channel, std::string address)
    : CoordinatorLink(std::move(address)),
      channel_(std::move(channel)),
      stubs_(std::make_unique<Stubs>(
          Stubs{v1::WorkService::NewStub(channel_), v1::BlobService::NewStub(channel_)})) {}

GrpcLink::~GrpcLink() = default;

absl::StatusOr<v1::RegisterResponse> GrpcLink::register_worker(const v1::RegisterRequest& request,
                                                               std::stop_token stop) {
  return net::unary_call(*stubs_->work, &v1::WorkService::Stub::Register, request, "Register", address(),
                         kCallTimeout, stop);
}

absl::StatusOr<v1::LeaseResponse> GrpcLink::lease(const v1::LeaseRequest& request, std::stop_token stop) {
  const milliseconds wait =
      seconds{request.max_wait().seconds()} + milliseconds{request.max_wait().nanos() / 1'000'000};
  return net::unary_call(*stubs_->work, &v1::WorkService::Stub::Lease, request, "Lease", address(),
                         wait + kLeaseMargin, stop);
}

absl::StatusOr<v1::HeartbeatResponse> GrpcLink::heartbeat(const v1::HeartbeatRequest& request,
                                                          std::stop_token stop) {
  return net::unary_call(*stubs_->work, &v1::WorkService::Stub::Heartbeat, request, "Heartbeat", address(),
                         kCallTimeout, stop);
}

absl::StatusOr<v1::CompleteResponse> GrpcLink::complete(const v1::CompleteRequest& request,
                                                        std::stop_token stop) {
  return net::unary_call(*stubs_->work, &v1::WorkService::Stub::Complete, request, "Complete", address(),
                         kCallTimeout, stop);
}

absl::Status GrpcLink::fail(const v1::FailRequest& request, std::stop_token stop) {
  return net::unary_call(*stubs_->work, &v1::WorkService::Stub::Fail, request, "Fail", address(),
                         kCallTimeout, stop)
      .status();
}

absl::Status GrpcLink::deregister(const v1::DeregisterRequest& request) {
  return net::unary_call(*stubs_->work, &v1::WorkService::Stub::Deregister, request, "Deregister", address(),
                         kDeregisterTimeout, {})
      .status();
}

absl::Status GrpcLink::upload(const UnitBlob& blob, std::stop_token stop) {
  const auto read = [&](std::uint64_t offset, std::size_t size) -> absl::StatusOr<std::string> {
    return std::string{blob.bytes.substr(offset, size)};
  };
  v1::UploadRequest first;
  first.set_worker_id(blob.worker_id);
  *first.mutable_token() = blob.token;
  return net::upload_rest(*stubs_->blob, {blob.ref, read, first}, address(), std::move(stop),
                          [](std::uint64_t) {});
}

bool GrpcLink::wait(net::Backoff& backoff, std::stop_token stop) {
  return net::wait_for_connection(*channel_, backoff.next(), std::move(stop));
}

absl::Status GrpcLink::download(const Wanted& wanted, const ChunkSink& sink, std::stop_token stop) {
  v1::DownloadRequest request;
  request.mutable_blob()->set_digest(wanted.digest);
  request.set_offset(wanted.offset);
  request.set_doubted(wanted.doubted);

  grpc::ClientContext context;
  std::stop_callback cancel{stop, [&context] { context.TryCancel(); }};
  net::StallGuard guard{context, kChunkTimeout};
  const auto reader = stubs_->blob->Download(&context, request);

  v1::DownloadResponse response;
  absl::Status written;
  while (written.ok() && reader->Read(&response)) {
    guard.progress();
    written = sink(response.data());
  }
  if (!written.ok()) context.TryCancel();
  const grpc::Status status = reader->Finish();
  if (!written.ok()) return written;

  const std::string call = absl::StrCat("Download at ", address());
  if (guard.stalled()) return absl::DeadlineExceededError(absl::StrCat(call, ": no data for 30 s"));
  return status.ok() ? absl::OkStatus() : net::from_grpc(status, call);
}

}  // namespace tessera::agent
