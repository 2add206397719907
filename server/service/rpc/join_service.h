// JoinService: how new workers come by a certificate.
#pragma once

#include <grpcpp/grpcpp.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>

#include "absl/status/statusor.h"
#include "connections/listener.h"
#include "tessera/v1/join.grpc.pb.h"
#include "tls/authority.h"
#include "tls/join_tokens.h"
#include "tls/members.h"

namespace tessera::server {

/// Options of a coordinator that concern joining.
struct JoinOptions {
  std::string address;       // HOST:PORT to serve on; port 0 takes a free one
  std::string certificates;  // the server's, as on its other port
  std::chrono::seconds certificate_interval;
  std::filesystem::path authority;   // the folder with the authority's key
  std::filesystem::path token_file;  // empty: tokens do not outlive the coordinator
  std::shared_ptr<Members> members;  // told the names of new workers, which are to be new; not null
};

/// Serves JoinService, and nothing else, on a port of its own: callers there have no certificate.
/// Thread-safe.
class JoinServer {
 public:
  /// InvalidArgument where the authority is none that the server trusts, or the
  /// address is malformed; Unavailable where files cannot be read or the address cannot be listened on.
  /// `connections` must outlive the server.
  static absl::StatusOr<std::unique_ptr<JoinServer>> start(const JoinOptions& options,
                                                           Connections& connections);
  /// Refuses new calls and ends those that run.
  ~JoinServer();

  int port() const { return listener_->port(); }

  /// A join token, as text. Errors as JoinTokens::make.
  absl::StatusOr<std::string> make_token(std::chrono::seconds life, std::uint32_t uses);
  /// Tokens that the worker joined with are accepted no more. How many that were.
  absl::StatusOr<std::size_t> call_tokens_back(const std::string& worker) {
    return tokens_.call_back(worker);
  }

 private:
  class Service;
  /// When the files of the authority were written.
  struct Written {
    std::filesystem::file_time_type key, certificate;
    friend bool operator==(const Written&, const Written&) = default;
  };
  JoinServer(const JoinOptions& options, Authority authority, const Written& read, JoinTokens tokens);
  static Written written(const std::filesystem::path& folder);
  /// The authority, read anew where its files have changed and the server trusts what they hold.
  std::shared_ptr<const Authority> authority();

  absl::StatusOr<std::string> join(const v1::JoinRequest& request, const std::string& peer);
  /// The name of a machine that no certificate has yet: its own, and digits of its key. InvalidArgument for a
  /// request that cannot be read.
  absl::StatusOr<std::string> name_for(const v1::JoinRequest& request) const;

  const std::filesystem::path authority_folder_;
  const std::string certificates_;
  std::mutex mutex_;
  std::shared_ptr<const Authority> authority_;
  Written read_;
  JoinTokens tokens_;
  const std::shared_ptr<Members> members_;
  std::unique_ptr<Service> service_;
  std::unique_ptr<grpc::Server> server_;
  std::unique_ptr<Listener> listener_;
};

}  // namespace tessera::server
