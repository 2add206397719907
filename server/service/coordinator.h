// The coordinator as a whole: scheduler, store and the services on top of them. No gRPC here; connections
// from within the process are made by in_process.h, and calls without messages through farm().
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "base/clock.h"
#include "connections/connections.h"
#include "scheduler/turn_order.h"
#include "service/farm/accounts.h"
#include "service/farm/quotas.h"
#include "telemetry/recent_lines.h"

namespace tessera::server {

class BlobStore;
class EndListener;
class Farm;
class LeaseSeal;

struct CoordinatorOptions {
  /// "127.0.0.1:7070"; port 0 takes any free one. Empty: reachable from within the process only.
  std::string listen;
  /// Whether calls come as messages of gRPC, which in_process.h wants, too. False: only through farm().
  bool takes_messages = true;
  /// Journal, results and blobs; made when it does not exist. Empty: everything is kept in memory.
  std::filesystem::path data_dir;
  /// Go on with what there is when something is lost that was acknowledged.
  bool accept_loss = false;
  /// Where blobs are kept, when whoever starts the coordinator holds them already. Empty: below the data
  /// directory, or in memory.
  std::shared_ptr<BlobStore> blobs;
  /// Certificates of a server (net/tls.h), whose renewal is noticed; empty: no encryption, and
  /// everybody may do everything.
  std::string certificates = {};
  std::chrono::seconds certificate_interval{10};
  /// Folder with the key of the authority that the certificates are of, with which workers join; empty: none
  /// do.
  std::filesystem::path join_authority = {};
  /// HOST:PORT where they do; empty: the host of `listen`, and the port behind its (a free one when that is
  /// free).
  std::string join_listen = {};
  /// Clients may see and change each other's jobs.
  bool share_jobs = false;
  /// Which of a user's jobs goes first.
  JobOrder order = JobOrder::kFirstCome;
  /// Listen without encryption on an address that is not loopback.
  bool allow_insecure = false;
  /// Limits of connections to all ports but that of the metrics together; absent: what the limit of
  /// descriptors, raised as far as it goes, leaves.
  std::optional<ConnectionLimits> connections = {};
  /// Upper bound of what everybody may make the coordinator hold at a time.
  Holding of_each = Accounts::kLimits;
  /// Interval that workers of small farms are told; longer in farms of thousands
  /// (Scheduler::heartbeat_interval).
  std::chrono::milliseconds heartbeat_interval{1000};
  /// A lease, and a worker, that was not heard of for so long is given up; later in farms of thousands.
  std::chrono::milliseconds lease_timeout{8000};
  /// A stream whose other end takes, or sends, nothing for so long is cut off.
  std::chrono::milliseconds stream_patience{60'000};
  /// So long after its end, late results of a job's units are still compared with those that count; then the
  /// memory that it takes does not depend on its size any more.
  std::chrono::milliseconds late_results{60'000};
  /// "HOST:PORT" to serve Prometheus metrics on, over plain HTTP; empty: nowhere.
  std::string metrics = {};
  /// "HOST:PORT" of the web page; empty: there is none. With certificates it is encrypted, and everybody logs
  /// in.
  std::string web = {};
  /// An address that is in use is no error: there is no web page then, and a warning says so.
  bool web_if_free = false;
  /// The lines of the program's log that the page shows; null: nothing.
  std::shared_ptr<telemetry::RecentLines> lines = {};
  /// "HOST:PORT" to answer gRPC health checks on, without encryption or certificates; empty: only where calls
  /// are served.
  std::string health = {};
  /// How long jobs that are over are kept: those of which a client has the image, and the others.
  std::chrono::seconds keep_fetched{std::chrono::hours{24}};
  std::chrono::seconds keep_unfetched{std::chrono::hours{24 * 30}};
  /// Blobs that no job refers to any more, and that nobody asked for in this time, are deleted.
  std::chrono::seconds keep_blobs{std::chrono::hours{24}};
  /// How often that is looked at.
  std::chrono::milliseconds prune_interval{15'000};
  /// So much of the disk is left free by blobs, and no job is taken beyond; see DiskReserve. Absent: as
  /// there.
  std::optional<std::uint64_t> keep_free_bytes = {};
  /// Most units that the jobs have together that are not over; those begun take 5 bytes, and 48 a result.
  std::uint64_t max_open_units = std::uint64_t{1} << 27;
  /// Upper bounds of what one client may ask for, where clients have certificates. Without a bound of the
  /// bytes of blobs: half of the disk of the data directory.
  Quotas quotas = {};
  /// Defaults of jobs that do not say: whether all of an image is to have the bits of one arithmetic class,
  /// and the kernels (empty: any).
  bool same_bits = true;
  std::string isa = {};
  /// How long workers that are started together have, before a job is bound to the class of most of them.
  std::chrono::milliseconds settle{0};
  /// Part of a job's units that may rest on a worker's certificate whose results no other has confirmed.
  double unconfirmed_share = 0.05;
  /// Arithmetic classes that jobs of same bits may be bound to although no worker's results in them have been
  /// confirmed.
  std::vector<std::string> classes = {};
  /// A job is rendered anew in another class when no worker of its own was there for so long.
  std::chrono::milliseconds class_patience{600'000};
  /// Units of a tile are leased as one, as many as take a worker this time; 0: each by itself.
  std::chrono::milliseconds longest_run{10'000};
  /// Beyond so many bytes of results, jobs of which a client has the image go earlier.
  std::uint64_t max_result_bytes = std::uint64_t{1} << 40;
  /// Told when jobs end; outlives the coordinator. Null: nobody is.
  EndListener* listener = nullptr;
  /// Outlives the coordinator.
  base::Clock* clock = &base::machine_clock();
  /// Seals leases; its key decides which results are audited, and by whom. Null: a seal with the data
  /// directory's own key, or with a new one.
  std::shared_ptr<const LeaseSeal> seal = {};
};

/// A running coordinator. All members may be called from any thread.
class Coordinator {
 public:
  /// Recovers what the data directory holds, and serves. Errors: InvalidArgument (malformed address),
  /// PermissionDenied (not loopback, and neither encrypted nor allowed to be), Unavailable (cannot listen
  /// there), FailedPrecondition (another coordinator uses the data directory, its format is not known, or
  /// something is lost that was acknowledged), DataLoss and Internal (data directory damaged, disk).
  static absl::StatusOr<std::unique_ptr<Coordinator>> start(CoordinatorOptions options);

  /// Where workers join; 0 when none do.
  int join_port() const;

  /// Port of the metrics; 0 when they are not served.
  int metrics_port() const;

  /// Port of the web page; 0 when there is none.
  int web_port() const;

  /// Port of health checks alone; 0 when they have no port of their own.
  int health_port() const;

  /// Shuts down and waits for it.
  ~Coordinator();

  /// The TCP port; 0 when it does not listen.
  int bound_port() const;

  /// Refuses new calls, ends those that wait, and lets `wait` return. Returns at once; may be called
  /// repeatedly.
  void request_shutdown();

  /// Until shutdown was requested, by `request_shutdown` or because the journal could no longer be written;
  /// an error in that case. Everything acknowledged is on disk.
  absl::Status wait();

  /// For calls without messages.
  Farm& farm();

  /// Everything that runs behind the interface (coordinator.cpp).
  struct Impl;
  Impl& impl() { return *impl_; }

 private:
  explicit Coordinator(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace tessera::server
