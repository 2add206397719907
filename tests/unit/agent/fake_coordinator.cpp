#include "unit/agent/fake_coordinator.h"

#include <google/protobuf/util/time_util.h>
#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>

#include <algorithm>
#include <utility>

#include "support/patience.h"
#include "tessera/v1/blob.grpc.pb.h"
#include "tessera/v1/work.grpc.pb.h"
#include "wire/digest.h"

namespace tessera::agent {
namespace {

const grpc::Status kUnknownWorker{grpc::StatusCode::NOT_FOUND, "no such worker"};
const grpc::Status kMisread{grpc::StatusCode::UNIMPLEMENTED, ""};

}  // namespace

class FakeCoordinator::Work final : public v1::WorkService::Service {
 public:
  explicit Work(FakeCoordinator& owner) : owner_(owner) {}

  grpc::Status Register(grpc::ServerContext*, const v1::RegisterRequest*,
                        v1::RegisterResponse* response) override {
    std::lock_guard lock{owner_.mutex_};
    if (owner_.misreads()) return kMisread;
    if (!owner_.refusal_.empty()) return {grpc::StatusCode::FAILED_PRECONDITION, owner_.refusal_};
    response->set_worker_id("w" + std::to_string(++owner_.registrations_));
    *response->mutable_heartbeat_interval() =
        google::protobuf::util::TimeUtil::MillisecondsToDuration(owner_.heartbeat_interval_.count());
    owner_.workers_.insert(response->worker_id());
    return grpc::Status::OK;
  }

  grpc::Status Lease(grpc::ServerContext*, const v1::LeaseRequest* request,
                     v1::LeaseResponse* response) override {
    std::unique_lock lock{owner_.mutex_};
    if (owner_.misreads()) return kMisread;
    // A short poll: a synchronous handler cannot be told that its caller has gone.
    owner_.changed_.wait_for(lock, std::chrono::milliseconds{20},
                             [&] { return owner_.closing_ || !owner_.offered_.empty(); });
    if (!owner_.workers_.contains(request->worker_id())) return kUnknownWorker;
    if (owner_.registrations_ > 1 && !owner_.introduced_.contains(request->worker_id()))
      ++owner_.early_leases_;
    owner_.grant(*request, *response);
    if (response->leases_size() > 0) ++owner_.granting_leases_;
    owner_.changed_.notify_all();
    return grpc::Status::OK;
  }

  grpc::Status Heartbeat(grpc::ServerContext*, const v1::HeartbeatRequest* request,
                         v1::HeartbeatResponse* response) override {
    std::unique_lock lock{owner_.mutex_};
    if (!owner_.workers_.contains(request->worker_id())) return kUnknownWorker;
    if (!owner_.introduced_.contains(request->worker_id())) {
      owner_.changed_.wait_for(lock, owner_.introduction_, [&] { return owner_.closing_; });
      owner_.introduced_.insert(request->worker_id());
    }
    owner_.hear(*request, owner_.revoked_, *response);
    owner_.leases_in_heartbeat_ = static_cast<std::size_t>(request->leases_size());
    owner_.changed_.notify_all();
    return grpc::Status::OK;
  }

  grpc::Status Complete(grpc::ServerContext*, const v1::CompleteRequest* request,
                        v1::CompleteResponse* response) override {
    std::lock_guard lock{owner_.mutex_};
    ++owner_.completes_;
    if (owner_.completes_to_fail_ > 0) {
      --owner_.completes_to_fail_;
      return {owner_.failure_code_, "on request"};
    }
    if (!owner_.workers_.contains(request->worker_id())) return kUnknownWorker;
    owner_.results_[request->token().unit_index()] = *request;
    v1::LeaseRequest wanted = request->more();
    if (owner_.generous_) wanted.set_max_units(wanted.max_units() + 1);
    owner_.grant(wanted, *response->mutable_more());
    if (request->has_beat())
      owner_.hear(request->beat(), owner_.revoked_with_result_, *response->mutable_beat());
    owner_.changed_.notify_all();
    return grpc::Status::OK;
  }

  grpc::Status Fail(grpc::ServerContext*, const v1::FailRequest* request, v1::FailResponse*) override {
    std::lock_guard lock{owner_.mutex_};
    owner_.failures_.push_back(*request);
    owner_.changed_.notify_all();
    return grpc::Status::OK;
  }

  grpc::Status Deregister(grpc::ServerContext*, const v1::DeregisterRequest* request,
                          v1::DeregisterResponse*) override {
    std::lock_guard lock{owner_.mutex_};
    owner_.workers_.erase(request->worker_id());
    owner_.deregistered_ = true;
    owner_.changed_.notify_all();
    return grpc::Status::OK;
  }

 private:
  FakeCoordinator& owner_;
};

class FakeCoordinator::Blobs final : public v1::BlobService::Service {
 public:
  explicit Blobs(FakeCoordinator& owner) : owner_(owner) {}

  grpc::Status Download(grpc::ServerContext*, const v1::DownloadRequest* request,
                        grpc::ServerWriter<v1::DownloadResponse>* writer) override {
    std::string bytes;
    bool broken = false;
    {
      std::lock_guard lock{owner_.mutex_};
      const auto found = owner_.blobs_.find(request->blob().digest());
      if (found == owner_.blobs_.end()) return {grpc::StatusCode::NOT_FOUND, "no such blob"};
      Blob& blob = found->second;
      owner_.download_offsets_.push_back(request->offset());
      bytes = blob.bytes.substr(request->offset());
      if (blob.corrupt_downloads > 0 && !bytes.empty()) {
        --blob.corrupt_downloads;
        bytes.back() ^= 1;
      }
      if (std::exchange(blob.break_after, 0) > 0) {
        broken = true;
        bytes.resize(std::min(bytes.size(), std::size_t{kChunk}));
      }
    }
    for (std::size_t begin = 0; begin < bytes.size(); begin += kChunk) {
      v1::DownloadResponse response;
      response.set_data(bytes.substr(begin, kChunk));
      if (!writer->Write(response)) break;
    }
    return broken ? grpc::Status{grpc::StatusCode::UNAVAILABLE, "on request"} : grpc::Status::OK;
  }

 private:
  static constexpr std::size_t kChunk = 1000;
  FakeCoordinator& owner_;
};

struct FakeCoordinator::Server {
  explicit Server(FakeCoordinator& owner) : work(owner), blobs(owner) {
    grpc::ServerBuilder builder;
    builder.RegisterService(&work);
    builder.RegisterService(&blobs);
    server = builder.BuildAndStart();
  }
  Work work;
  Blobs blobs;
  std::unique_ptr<grpc::Server> server;
};

FakeCoordinator::FakeCoordinator() : server_(std::make_unique<Server>(*this)) {}

FakeCoordinator::~FakeCoordinator() {
  {
    std::lock_guard lock{mutex_};
    closing_ = true;
  }
  changed_.notify_all();
  server_->server->Shutdown();
}

std::shared_ptr<grpc::Channel> FakeCoordinator::channel() { return server_->server->InProcessChannel({}); }

std::string FakeCoordinator::add_blob(std::string bytes, int corrupt_downloads, std::size_t break_after) {
  std::string digest = wire::sha256_hex(bytes);
  std::lock_guard lock{mutex_};
  blobs_[digest] = {std::move(bytes), corrupt_downloads, break_after};
  return digest;
}

void FakeCoordinator::offer(const std::string& job_id, const v1::JobSpec& spec, std::uint32_t first,
                            std::uint32_t count) {
  std::lock_guard lock{mutex_};
  specs_[job_id] = spec;
  for (std::uint32_t i = first; i < first + count; ++i) {
    v1::Lease lease;
    lease.mutable_token()->set_job_id(job_id);
    lease.mutable_token()->set_unit_index(i);
    lease.mutable_token()->set_epoch(static_cast<std::uint64_t>(registrations_));
    lease.mutable_unit()->set_index(i);
    v1::TileUnit& tile = *lease.mutable_unit()->mutable_tile();
    tile.mutable_pixels()->set_x0(4 * i);
    tile.mutable_pixels()->set_x1(4 * i + 4);
    tile.mutable_pixels()->set_y1(4);
    tile.mutable_samples()->set_end(1);
    offered_.push_back(std::move(lease));
  }
  changed_.notify_all();
}

void FakeCoordinator::refuse_registration(std::string message) {
  std::lock_guard lock{mutex_};
  refusal_ = std::move(message);
}

void FakeCoordinator::set_heartbeat_interval(std::chrono::milliseconds interval) {
  std::lock_guard lock{mutex_};
  heartbeat_interval_ = interval;
}

void FakeCoordinator::fail_completes(int count, grpc::StatusCode code) {
  std::lock_guard lock{mutex_};
  completes_to_fail_ = count;
  failure_code_ = code;
}

void FakeCoordinator::be_generous() {
  std::lock_guard lock{mutex_};
  generous_ = true;
}

void FakeCoordinator::grant(const v1::LeaseRequest& request, v1::LeaseResponse& response) {
  while (!offered_.empty() && response.leases_size() < static_cast<int>(request.max_units())) {
    const v1::Lease& lease = offered_.front();
    const std::string& job_id = lease.token().job_id();
    const auto& known = request.known_job_ids();
    if (std::find(known.begin(), known.end(), job_id) == known.end()) {
      (*response.mutable_specs())[job_id] = specs_[job_id];
    }
    *response.add_leases() = lease;
    offered_.pop_front();
    ++leased_;
  }
}

void FakeCoordinator::hear(const v1::HeartbeatRequest& request, const std::set<std::uint32_t>& revoked,
                           v1::HeartbeatResponse& response) {
  for (const v1::LeaseToken& token : request.leases()) {
    if (revoked.contains(token.unit_index())) *response.add_revoked() = token;
  }
  response.set_drain(drain_);
}

void FakeCoordinator::hold_introductions(std::chrono::milliseconds time) {
  std::lock_guard lock{mutex_};
  introduction_ = time;
}

int FakeCoordinator::early_leases() {
  std::lock_guard lock{mutex_};
  return early_leases_;
}

int FakeCoordinator::granting_leases() {
  std::lock_guard lock{mutex_};
  return granting_leases_;
}

void FakeCoordinator::misread(int count) {
  std::lock_guard lock{mutex_};
  calls_to_misread_ = count;
}

bool FakeCoordinator::misreads() {
  if (calls_to_misread_ == 0) return false;
  --calls_to_misread_;
  return true;
}

void FakeCoordinator::forget_workers() {
  std::lock_guard lock{mutex_};
  workers_.clear();
}

void FakeCoordinator::revoke(std::uint32_t unit_index) {
  std::lock_guard lock{mutex_};
  revoked_.insert(unit_index);
}

void FakeCoordinator::revoke_with_result(std::uint32_t unit_index) {
  std::lock_guard lock{mutex_};
  revoked_with_result_.insert(unit_index);
}

void FakeCoordinator::ask_to_drain() {
  std::lock_guard lock{mutex_};
  drain_ = true;
}

template <class Condition>
bool FakeCoordinator::wait_for(Condition condition) {
  std::unique_lock lock{mutex_};
  return changed_.wait_for(lock, support::kPatience, condition);
}

bool FakeCoordinator::wait_for_results(std::size_t count) {
  return wait_for([&] { return results_.size() >= count; });
}
bool FakeCoordinator::wait_for_leased(std::size_t count) {
  return wait_for([&] { return leased_ >= count; });
}
bool FakeCoordinator::wait_for_failures(std::size_t count) {
  return wait_for([&] { return failures_.size() >= count; });
}
bool FakeCoordinator::wait_for_heartbeat_with(std::size_t leases) {
  return wait_for([&] { return leases_in_heartbeat_ == leases; });
}
bool FakeCoordinator::wait_for_deregistration() {
  return wait_for([&] { return deregistered_; });
}

std::map<std::uint32_t, v1::CompleteRequest> FakeCoordinator::results() {
  std::lock_guard lock{mutex_};
  return results_;
}
std::vector<v1::FailRequest> FakeCoordinator::failures() {
  std::lock_guard lock{mutex_};
  return failures_;
}
int FakeCoordinator::registrations() {
  std::lock_guard lock{mutex_};
  return registrations_;
}
std::size_t FakeCoordinator::completes() {
  std::lock_guard lock{mutex_};
  return completes_;
}
std::vector<std::uint64_t> FakeCoordinator::download_offsets() {
  std::lock_guard lock{mutex_};
  return download_offsets_;
}

}  // namespace tessera::agent
