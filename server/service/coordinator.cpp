#include "service/coordinator.h"

#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/health_check_service_interface.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "base/address.h"
#include "connections/connection_calls.h"
#include "connections/connections.h"
#include "connections/descriptors.h"
#include "connections/listener.h"
#include "net/tls.h"
#include "net/x509.h"
#include "service/coordinator_impl.h"
#include "service/farm/farm.h"
#include "service/farm/farm_log.h"
#include "service/farm/lease_seal.h"
#include "service/farm/user_shares.h"
#include "service/farm/worker_leases.h"
#include "service/metrics.h"
#include "service/rpc/access.h"
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
#include "tls/own_certificate.h"
#include "wire/limits.h"
#include "wire/version.h"

namespace tessera::server {
namespace {

// How long calls may take to end after a shutdown was requested.
constexpr std::chrono::seconds kGrace{2};
constexpr int kMaxStreamsPerConnection = 512;
// Requests that have not arrived whole, and gRPC's own records of calls and connections: beyond, gRPC takes
// less at a time, closes connections without calls, and cancels calls.
constexpr std::size_t kMaxArrivingBytes = std::size_t{256} << 20;
constexpr std::size_t kBytesPerConnection = std::size_t{32} << 10;
using ConnectionType = grpc::ServerBuilder::experimental_type::ExternalConnectionType;

absl::StatusOr<std::shared_ptr<grpc::ServerCredentials>> credentials_for(
    const base::HostPort& address, const CoordinatorOptions& options,
    std::shared_ptr<const Expelled> expelled, std::shared_ptr<Members> members) {
  if (options.certificates.empty()) {
    if (absl::Status s = base::check_unencrypted_allowed(address, options.allow_insecure); !s.ok()) return s;
    return grpc::InsecureServerCredentials();
  }
  if (absl::Status s = net::check_certificates(options.certificates); !s.ok()) {
    return absl::InvalidArgumentError(s.message());
  }
  if (absl::Status s = check_own_certificate(options.certificates); !s.ok()) return s;
  auto credentials = net::server_credentials(options.certificates, options.certificate_interval);
  credentials->SetAuthMetadataProcessor(access_by_role(std::move(expelled), std::move(members)));
  return credentials;
}

/// Names by which the web page may be called: that of its address, the machine's, and those in the
/// coordinator's certificate.
std::vector<std::string> names_of_page(const std::string& host, const std::filesystem::path& certificates) {
  std::vector<std::string> names{host};
  if (!certificates.empty()) {
    std::ifstream file{certificates / net::kCertificateFile};
    const net::Certificate own =
        net::certificate_from_pem(std::string{std::istreambuf_iterator<char>{file}, {}});
    if (own != nullptr) std::ranges::copy(net::host_names_of(own.get()), std::back_inserter(names));
  }
  char machine[256] = "";
  if (::gethostname(machine, sizeof(machine) - 1) == 0) names.emplace_back(machine);
  return names;
}

/// Opens the port of the members, on which the builder's server is to be called.
absl::StatusOr<Listener::Acceptor> open_port(Coordinator::Impl& parts, const CoordinatorOptions& options,
                                             grpc::ServerBuilder& builder) {
  const absl::StatusOr<base::HostPort> address = base::parse_host_port(options.listen);
  if (!address.ok()) return address.status();
  const auto credentials = credentials_for(*address, options, parts.expelled, parts.members);
  if (!credentials.ok()) return credentials.status();
  auto opened = Listener::open(*address, *parts.connections, Connections::Port::kMembers);
  if (!opened.ok()) return opened.status();
  parts.listener = *std::move(opened);
  std::vector<std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface>> interceptors;
  interceptors.push_back(notice_calls(*parts.connections));
  builder.experimental().SetInterceptorCreators(std::move(interceptors));
  return builder.experimental().AddExternalConnectionAcceptor(ConnectionType::FROM_FD, *credentials);
}

}  // namespace

Coordinator::Impl::Impl()
    : farm_metrics(std::make_unique<FarmMetrics>()), farm_log(std::make_unique<FarmLog>()) {}

Coordinator::Impl::~Impl() {
  if (farm != nullptr) farm->stop();
}

absl::Status Coordinator::Impl::open(const CoordinatorOptions& options) {
  absl::Status status = open_data(options);
  // PermissionDenied and Unavailable are kept for the network.
  if (absl::IsPermissionDenied(status) || absl::IsUnavailable(status))
    return absl::FailedPreconditionError(status.message());
  return status;
}

absl::Status Coordinator::Impl::open_data(const CoordinatorOptions& options) {
  if (!options.data_dir.empty()) {
    absl::StatusOr<DataDir> opened = DataDir::open(options.data_dir);
    if (!opened.ok()) return opened.status();
    data_dir = std::make_unique<DataDir>(*std::move(opened));
  }
  absl::StatusOr<std::unique_ptr<Expelled>> opened_expelled =
      Expelled::open(options.data_dir.empty() ? std::filesystem::path{} : options.data_dir / "expelled");
  if (!opened_expelled.ok()) return opened_expelled.status();
  expelled = *std::move(opened_expelled);
  absl::StatusOr<std::unique_ptr<Members>> opened_members =
      Members::open(options.data_dir.empty() ? std::filesystem::path{} : options.data_dir / "members");
  if (!opened_members.ok()) return opened_members.status();
  members = *std::move(opened_members);
  blobs = options.blobs;
  if (blobs == nullptr) {
    blobs = options.data_dir.empty()
                ? make_memory_blob_store()
                : make_file_blob_store(options.data_dir, {.bytes = options.keep_free_bytes});
  }

  absl::Status status = open_farm(options);
  // The journal has noted that it is damaged, and is made anew when it is opened again.
  if (absl::IsDataLoss(status) && journal != nullptr) status = open_farm(options);
  return status;
}

absl::Status Coordinator::Impl::open_farm(const CoordinatorOptions& options) {
  journal.reset();
  absl::StatusOr<std::unique_ptr<Journal>> opened_journal =
      open_journal(options.data_dir, {.accept_loss = options.accept_loss});
  if (!opened_journal.ok()) return opened_journal.status();
  journal = *std::move(opened_journal);
  std::shared_ptr<const LeaseSeal> seal = options.seal;
  if (seal == nullptr) {
    auto own =
        LeaseSeal::open(options.data_dir.empty() ? std::filesystem::path{} : options.data_dir / "lease-key");
    if (!own.ok()) return own.status();
    seal = *std::move(own);
  }
  Quotas quotas = options.quotas;
  if (quotas.blob_bytes.of_all == Quotas::kUnbounded && !options.data_dir.empty()) {
    if (const absl::StatusOr<DiskSpace> disk = disk_space(options.data_dir); disk.ok())
      quotas.blob_bytes.of_all = disk->total_bytes / 2;
  }
  absl::StatusOr<std::unique_ptr<Farm>> opened_farm = Farm::open(
      *journal, *blobs,
      {.heartbeat_interval = options.heartbeat_interval,
       .lease_timeout = options.lease_timeout,
       .late_results = options.late_results,
       .retention = {.fetched = options.keep_fetched,
                     .unfetched = options.keep_unfetched,
                     .max_bytes = options.max_result_bytes,
                     .blobs = options.keep_blobs,
                     .interval = options.prune_interval},
       .max_open_units = options.max_open_units,
       .quotas = quotas,
       .longest_run = options.longest_run,
       .order = options.order,
       .share_results = options.share_jobs || options.certificates.empty(),
       .seal = seal,
       .lived_time = options.data_dir.empty() ? std::filesystem::path{} : options.data_dir / "lived-time",
       .bits = options.same_bits ? v1::BITS_SAME : v1::BITS_ANY,
       .isa = options.isa,
       .settle = options.settle,
       .unconfirmed_share = options.unconfirmed_share,
       .classes = options.classes,
       .class_patience = options.class_patience,
       .listener = options.listener,
       .clock = options.clock,
       .observers = {farm_metrics.get(), farm_log.get()}},
      [this](const absl::Status& why) { request_shutdown(why); });
  if (!opened_farm.ok()) return opened_farm.status();
  farm = *std::move(opened_farm);
  return absl::OkStatus();
}

absl::Status Coordinator::Impl::open_joining(const CoordinatorOptions& options) {
  if (options.join_authority.empty()) return absl::OkStatus();
  if (options.certificates.empty() || options.listen.empty()) {
    return absl::InvalidArgumentError("workers join with certificates: --join-authority needs --tls");
  }
  if (absl::Status s = check_private_key(options.join_authority); !s.ok()) return s;
  std::string address = options.join_listen;
  if (address.empty()) {
    absl::StatusOr<base::HostPort> beside = base::parse_host_port(options.listen);
    if (!beside.ok()) return beside.status();
    if (beside->port != 0) ++beside->port;
    address = beside->to_string();
  }
  absl::StatusOr<std::unique_ptr<JoinServer>> started = JoinServer::start(
      {.address = address,
       .certificates = options.certificates,
       .certificate_interval = options.certificate_interval,
       .authority = options.join_authority,
       .token_file = options.data_dir.empty() ? std::filesystem::path{} : options.data_dir / "join-tokens",
       .members = members},
      *connections);
  if (!started.ok()) return started.status();
  joining = *std::move(started);
  return absl::OkStatus();
}

absl::Status Coordinator::Impl::open_web(const CoordinatorOptions& options) {
  if (options.web.empty()) return absl::OkStatus();
  absl::StatusOr<base::HostPort> address = base::parse_host_port(options.web);
  if (!address.ok()) return address.status();
  const bool encrypted = !options.certificates.empty();
  if (!encrypted) {
    if (absl::Status s = base::check_unencrypted_allowed(*address, options.allow_insecure); !s.ok()) return s;
  }
  site = std::make_unique<WebSite>(
      *farm, Rights{farm->views(), options.share_jobs}, *expelled, *members,
      SiteOptions{.encrypted = encrypted, .version = wire::build_version(), .lines = options.lines});
  const auto set_names = [this, host = address->host, certificates = options.certificates] {
    site->set_names(names_of_page(host, certificates));
  };
  set_names();
  absl::StatusOr<std::unique_ptr<HttpServer>> started =
      HttpServer::start({.address = options.web,
                         .certificates = options.certificates,
                         .renewed = set_names,
                         .clock = options.clock},
                        [this](const HttpRequest& request) { return site->answer(request); });
  if (!started.ok()) {
    site.reset();
    if (!options.web_if_free || !absl::IsUnavailable(started.status())) return started.status();
    spdlog::warn("there is no web page: {}", std::string(started.status().message()));
    return absl::OkStatus();
  }
  web = *std::move(started);
  address->port = static_cast<std::uint16_t>(web->port());
  farm->subscribe([this] {
    web->sweep();
    return true;
  });
  web_port = std::make_unique<WebPort>(WebPort{.address = address->to_string(), .site = site.get()});
  return absl::OkStatus();
}

absl::Status Coordinator::Impl::listen(const CoordinatorOptions& options) {
  if (!options.listen.empty() || !options.health.empty()) {
    const std::size_t descriptors = raise_descriptor_limit();
    connections = std::make_unique<Connections>(
        options.connections.value_or(ConnectionLimits::within(connections_within(descriptors))));
    const ConnectionLimits& limits = connections->limits();
    spdlog::info("{} descriptors: at most {} connections, {} of one address", descriptors, limits.all,
                 limits.of_address);
  }
  if (absl::Status status = open_joining(options); !status.ok()) return status;
  accounts = Accounts::make(options.of_each);
  streams = std::make_unique<OpenStreams>(options.stream_patience, accounts, *options.clock);
  farm->subscribe([this] {
    streams->cut_stalled();
    return true;
  });
  if (absl::Status status = open_web(options); !status.ok()) return status;
  if (absl::Status status = open_services(options); !status.ok()) return status;
  return open_metrics(options);
}

absl::Status Coordinator::Impl::open_services(const CoordinatorOptions& options) {
  farm_service = std::make_unique<FarmService>(*farm, *streams, *expelled, *members, joining.get(),
                                               web_port.get(), options.share_jobs);
  work_service = std::make_unique<WorkService>(farm->workers(), farm->leases(), farm->results(), accounts);
  blob_service = std::make_unique<BlobService>(
      *blobs, *streams,
      [this](const std::string& digest, std::uint64_t bytes) { farm->shares().note_upload(digest, bytes); },
      [this](const grpc::CallbackServerContext& context, const v1::UploadRequest& first) {
        const Caller who = caller_of(context.auth_context().get());
        return who.role == Role::kWorker || first.has_token()
                   ? farm->leases().begin_unit_upload(first, work_service->origin_of(context))
                   : farm->shares().begin_upload(first.blob(), who);
      });

  if (!options.health.empty()) {
    absl::StatusOr<std::unique_ptr<HealthServer>> started = HealthServer::start(options.health, *connections);
    if (!started.ok()) return started.status();
    health = *std::move(started);
  }
  // grpc.health.v1 tells balancers and probes that calls are served; reflection tells tools what may be
  // called.
  grpc::EnableDefaultHealthCheckService(true);
  grpc::reflection::InitProtoReflectionServerBuilderPlugin();
  grpc::ServerBuilder builder;
  builder.RegisterService(&*farm_service);
  builder.RegisterService(&*work_service);
  builder.RegisterService(&*blob_service);
  builder.SetMaxReceiveMessageSize(static_cast<int>(wire::kMaxMessageBytes));
  builder.SetMaxSendMessageSize(static_cast<int>(wire::kMaxMessageBytes));
  const std::size_t most_connections = connections ? connections->limits().all : 0;
  builder.SetResourceQuota(
      grpc::ResourceQuota{"calls"}.Resize(kMaxArrivingBytes + most_connections * kBytesPerConnection));
  builder.AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS, kMaxStreamsPerConnection);
  // Clients ping every 10 s (net/channel.cpp); and a client whose machine is gone is noticed here too.
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, 5'000);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, 10'000);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 5'000);
  Listener::Acceptor acceptor;
  if (!options.listen.empty()) {
    absl::StatusOr<Listener::Acceptor> opened = open_port(*this, options, builder);
    if (!opened.ok()) return opened.status();
    acceptor = *std::move(opened);
    builder.AddChannelArgument(GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS,
                               static_cast<int>(connections->limits().silence.count()));
  }
  server = builder.BuildAndStart();
  if (server == nullptr) return absl::InternalError("gRPC does not start a server");
  if (listener) listener->start(std::move(acceptor));
  if (health != nullptr) health->set_serving(true);
  return absl::OkStatus();
}

absl::Status Coordinator::Impl::open_metrics(const CoordinatorOptions& options) {
  if (options.metrics.empty()) return absl::OkStatus();
  std::vector<std::shared_ptr<prometheus::Collectable>> sources{
      farm_metrics->collectable(), farm_gauges(farm->views()), stream_counter(*streams)};
  if (connections) sources.push_back(connection_metrics(*connections));
  absl::StatusOr<std::unique_ptr<telemetry::MetricsServer>> serving =
      telemetry::MetricsServer::start(options.metrics, std::move(sources));
  if (!serving.ok()) return serving.status();
  metrics = *std::move(serving);
  return absl::OkStatus();
}

void Coordinator::Impl::request_shutdown(const absl::Status& why) {
  const std::lock_guard lock(mutex);
  shutdown_requested = true;
  reason.Update(why);
  changed.notify_all();
}

absl::Status Coordinator::Impl::wait() {
  {
    std::unique_lock lock(mutex);
    changed.wait(lock, [this] { return shutdown_requested; });
  }
  std::call_once(shut_down, [this] {
    // Waiting calls are answered first, so that the server finds none that would not end by itself.
    if (health != nullptr) health->set_serving(false);
    if (site != nullptr) site->stop();
    farm->stop();
    web.reset();
    if (listener) listener->stop();
    if (server != nullptr) {
      server->Shutdown(std::chrono::system_clock::now() + kGrace);
      server->Wait();
    }
  });
  const std::lock_guard lock(mutex);
  return reason;
}

Coordinator::Coordinator(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

absl::StatusOr<std::unique_ptr<Coordinator>> Coordinator::start(CoordinatorOptions options) {
  auto impl = std::make_unique<Impl>();
  if (absl::Status status = impl->open(options); !status.ok()) return status;
  if (absl::Status s = options.takes_messages ? impl->listen(options) : impl->open_web(options); !s.ok())
    return s;
  return std::unique_ptr<Coordinator>(new Coordinator(std::move(impl)));
}

Coordinator::~Coordinator() {
  request_shutdown();
  if (absl::Status status = wait(); !status.ok()) spdlog::error("shut down: {}", status.ToString());
}

int Coordinator::bound_port() const { return impl_->listener ? impl_->listener->port() : 0; }
int Coordinator::join_port() const { return impl_->joining ? impl_->joining->port() : 0; }
int Coordinator::metrics_port() const { return impl_->metrics ? impl_->metrics->port() : 0; }
int Coordinator::web_port() const { return impl_->web ? impl_->web->port() : 0; }
int Coordinator::health_port() const { return impl_->health ? impl_->health->port() : 0; }
Farm& Coordinator::farm() { return *impl_->farm; }
void Coordinator::request_shutdown() { impl_->request_shutdown(absl::OkStatus()); }
absl::Status Coordinator::wait() { return impl_->wait(); }

}  // namespace tessera::server
