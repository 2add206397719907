// The parts of a coordinator. For coordinator.cpp and in_process.cpp.
#pragma once

#include <grpcpp/grpcpp.h>

#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>

#include "connections/connections.h"
#include "connections/listener.h"
#include "service/coordinator.h"
#include "service/farm/accounts.h"
#include "service/farm/farm.h"
#include "service/metrics.h"
#include "service/rpc/blob_service.h"
#include "service/rpc/farm_service.h"
#include "service/rpc/health_server.h"
#include "service/rpc/join_service.h"
#include "service/rpc/open_streams.h"
#include "service/rpc/work_service.h"
#include "service/web/http_server.h"
#include "service/web/web_site.h"
#include "store/blobs/blob_store.h"
#include "store/data_dir.h"
#include "store/journal.h"
#include "telemetry/metrics_server.h"

namespace tessera::server {

struct Coordinator::Impl {
  /// Nobody is told of the farm's changes any more when the parts that listen to them go.
  ~Impl() {
    if (farm != nullptr) farm->stop();
  }
  absl::Status open(const CoordinatorOptions& options);
  absl::Status open_data(const CoordinatorOptions& options);
  absl::Status open_farm(const CoordinatorOptions& options);
  absl::Status listen(const CoordinatorOptions& options);
  absl::Status open_joining(const CoordinatorOptions& options);
  absl::Status open_web(const CoordinatorOptions& options);
  absl::StatusOr<Listener::Acceptor> open_port(const CoordinatorOptions& options,
                                               grpc::ServerBuilder& builder);
  void request_shutdown(const absl::Status& reason);
  absl::Status wait();

  // In the order in which they lean on each other.
  std::optional<DataDir> data_dir;
  std::unique_ptr<Journal> journal;
  std::shared_ptr<BlobStore> blobs;
  std::shared_ptr<Accounts> accounts;
  std::optional<Connections> connections;  // set where it listens
  std::optional<OpenStreams> streams;
  std::unique_ptr<Farm> farm;
  std::shared_ptr<Expelled> expelled;
  std::shared_ptr<Members> members;
  std::unique_ptr<JoinServer> joining;
  std::optional<WebPort> web_port;
  std::unique_ptr<WebSite> site;
  std::unique_ptr<HttpServer> web;
  std::optional<FarmService> farm_service;
  std::optional<WorkService> work_service;
  std::optional<BlobService> blob_service;
  std::unique_ptr<HealthServer> health;
  std::unique_ptr<grpc::Server> server;
  std::unique_ptr<Listener> listener;
  std::unique_ptr<telemetry::MetricsServer> metrics;

  std::mutex mutex;
  std::condition_variable changed;
  bool shutdown_requested = false;
  absl::Status reason;  // why, when it was not asked for

  std::once_flag shut_down;
};

}  // namespace tessera::server
