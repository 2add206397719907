// The parts of a coordinator. For coordinator.cpp and in_process.cpp.
#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>

#include "absl/status/status.h"
#include "service/coordinator.h"

namespace grpc {
class Server;
}  // namespace grpc

namespace tessera::telemetry {
class MetricsServer;
}  // namespace tessera::telemetry

namespace tessera::server {

class BlobService;
class Connections;
class DataDir;
class Expelled;
class FarmLog;
class FarmMetrics;
class FarmService;
class HealthServer;
class HttpServer;
class JoinServer;
class Journal;
class Listener;
class Members;
class OpenStreams;
class WebSite;
class WorkService;
struct WebPort;

struct Coordinator::Impl {
  Impl();
  /// Nobody is told of the farm's changes any more when the parts that listen to them go.
  ~Impl();
  absl::Status open(const CoordinatorOptions& options);
  absl::Status open_data(const CoordinatorOptions& options);
  absl::Status open_farm(const CoordinatorOptions& options);
  absl::Status listen(const CoordinatorOptions& options);
  absl::Status open_joining(const CoordinatorOptions& options);
  absl::Status open_web(const CoordinatorOptions& options);
  absl::Status open_services(const CoordinatorOptions& options);
  absl::Status open_metrics(const CoordinatorOptions& options);
  void request_shutdown(const absl::Status& reason);
  absl::Status wait();

  // Each leans on those before it.
  std::unique_ptr<DataDir> data_dir;
  std::unique_ptr<Journal> journal;
  std::shared_ptr<BlobStore> blobs;
  std::shared_ptr<Accounts> accounts;
  std::unique_ptr<Connections> connections;  // set where it listens
  std::unique_ptr<OpenStreams> streams;
  std::unique_ptr<FarmMetrics> farm_metrics;
  std::unique_ptr<FarmLog> farm_log;
  std::unique_ptr<Farm> farm;
  std::shared_ptr<Expelled> expelled;
  std::shared_ptr<Members> members;
  std::unique_ptr<JoinServer> joining;
  std::unique_ptr<WebPort> web_port;
  std::unique_ptr<WebSite> site;
  std::unique_ptr<HttpServer> web;
  std::unique_ptr<FarmService> farm_service;
  std::unique_ptr<WorkService> work_service;
  std::unique_ptr<BlobService> blob_service;
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
