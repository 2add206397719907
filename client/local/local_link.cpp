#include "local/local_link.h"

#include "base/clock.h"
#include "local/awaited.h"
#include "net/backoff.h"
#include "service/farm/farm.h"
#include "service/farm/unit_results.h"
#include "service/farm/user_shares.h"
#include "service/farm/worker_leases.h"
#include "service/farm/worker_registry.h"
#include "store/blobs/blob_store.h"
#include "wire/limits.h"

namespace tessera::client {
namespace {

server::WorkerOrigin origin() {
  return {.certificate = "", .peer = "this process", .fingerprint = "", .account = nullptr};
}

}  // namespace

absl::StatusOr<v1::RegisterResponse> LocalLink::register_worker(const v1::RegisterRequest& request,
                                                                std::stop_token) {
  return farm_.workers().register_worker(request, origin());
}

absl::StatusOr<v1::LeaseResponse> LocalLink::lease(const v1::LeaseRequest& request, std::stop_token stop) {
  Awaited<absl::StatusOr<v1::LeaseResponse>> answer(farm_.clock());
  farm_.leases().lease(
      request, origin(), [stop] { return stop.stop_requested(); }, answer.done());
  return answer.wait(stop);
}

absl::StatusOr<v1::HeartbeatResponse> LocalLink::heartbeat(const v1::HeartbeatRequest& request,
                                                           std::stop_token) {
  return farm_.leases().heartbeat(request, origin());
}

absl::StatusOr<v1::CompleteResponse> LocalLink::complete(const v1::CompleteRequest& request,
                                                         std::stop_token stop) {
  Awaited<absl::StatusOr<v1::CompleteResponse>> answer(farm_.clock());
  farm_.results().complete(request, origin(), answer.done());
  return answer.wait(stop);
}

absl::Status LocalLink::fail(const v1::FailRequest& request, std::stop_token stop) {
  Awaited<absl::Status> answer(farm_.clock());
  farm_.results().fail(request, origin(), answer.done());
  return answer.wait(stop);
}

absl::Status LocalLink::deregister(const v1::DeregisterRequest& request) {
  return farm_.workers().deregister(request.worker_id(), origin());
}

absl::Status LocalLink::download(const Wanted& wanted, const ChunkSink& sink, std::stop_token stop) {
  if (wanted.doubted) {
    if (absl::Status status = drop_if_damaged(blobs_, wanted.digest); !status.ok()) return status;
  }
  const absl::StatusOr<std::unique_ptr<server::BlobReader>> reader = blobs_.read(wanted.digest);
  if (!reader.ok()) return reader.status();
  for (std::uint64_t offset = wanted.offset; offset < (*reader)->size();) {
    if (stop.stop_requested()) return absl::CancelledError("the download was given up");
    const absl::StatusOr<std::string> bytes = (*reader)->read(offset, wire::kBlobChunkBytes);
    if (!bytes.ok()) return bytes.status();
    if (absl::Status status = sink(*bytes); !status.ok()) return status;
    offset += bytes->size();
  }
  return absl::OkStatus();
}

absl::Status LocalLink::upload(const UnitBlob& blob, std::stop_token) {
  const std::string& digest = blob.ref.digest();
  const std::string_view bytes = blob.bytes;
  if (blobs_.query(digest).complete) return absl::OkStatus();
  if (absl::Status room = blobs_.check_room(bytes.size()); !room.ok()) return room;
  const absl::StatusOr<std::unique_ptr<server::BlobWriter>> writer = blobs_.write(digest, 0);
  if (absl::IsAlreadyExists(writer.status())) return absl::OkStatus();
  if (!writer.ok()) return writer.status();
  absl::Status status = (*writer)->append(bytes);
  if (status.ok()) status = (*writer)->finish();
  if (status.ok()) farm_.shares().note_upload(digest, bytes.size());
  return status;
}

bool LocalLink::wait(net::Backoff& backoff, std::stop_token stop) {
  return base::pause(farm_.clock(), backoff.next(), stop);
}

}  // namespace tessera::client
