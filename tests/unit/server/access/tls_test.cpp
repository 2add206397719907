// A coordinator that speaks TLS: who gets in, and what they may do.
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>
#include <openssl/ssl.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>

#include "base/freer.h"
#include "net/tls.h"
#include "support/patience.h"
#include "support/process/tcp_proxy.h"
#include "unit/server/access/tls_fixture.h"

namespace tessera::server {
namespace {

namespace fs = std::filesystem;
using SystemClock = std::chrono::system_clock;
using std::chrono::hours;

class Tls : public TlsTest {
 protected:
  static grpc::StatusCode find_missing_code(const std::shared_ptr<grpc::Channel>& channel) {
    grpc::ClientContext context;
    v1::FindMissingResponse response;
    return v1::BlobService::NewStub(channel)->FindMissing(&context, {}, &response).error_code();
  }

  static grpc::StatusCode download_code(const std::shared_ptr<grpc::Channel>& channel) {
    grpc::ClientContext context;
    v1::DownloadRequest request;
    request.mutable_blob()->set_digest(wire::sha256_hex("not there"));
    const auto stream = v1::BlobService::NewStub(channel)->Download(&context, request);
    v1::DownloadResponse response;
    while (stream->Read(&response)) {
    }
    return stream->Finish().error_code();
  }

  /// Answers to a caller who asks for a job in every way there is.
  static std::vector<grpc::StatusCode> codes_about(const std::string& job,
                                                   const std::shared_ptr<grpc::Channel>& channel) {
    const auto farm = v1::FarmService::NewStub(channel);
    std::vector<grpc::StatusCode> codes;
    const auto call = [&](auto method, auto request, auto response) {
      grpc::ClientContext context;
      request.set_job_id(job);
      codes.push_back((farm.get()->*method)(&context, request, &response).error_code());
    };
    call(&v1::FarmService::Stub::GetJob, v1::GetJobRequest{}, v1::GetJobResponse{});
    call(&v1::FarmService::Stub::AdjustJob, v1::AdjustJobRequest{}, v1::AdjustJobResponse{});
    call(&v1::FarmService::Stub::RetryJob, v1::RetryJobRequest{}, v1::RetryJobResponse{});
    call(&v1::FarmService::Stub::CancelJob, v1::CancelJobRequest{}, v1::CancelJobResponse{});
    grpc::ClientContext context;
    v1::WatchJobRequest request;
    request.set_job_id(job);
    const auto stream = farm->WatchJob(&context, request);
    v1::WatchJobResponse response;
    while (stream->Read(&response)) {
    }
    codes.push_back(stream->Finish().error_code());
    return codes;
  }
};

TEST_F(Tls, EveryRoleCallsWhatIsItsOwnOnly) {
  using enum grpc::StatusCode;
  const auto worker = channel_of("worker"), client = channel_of("client-alice"), admin = channel_of("admin");
  EXPECT_EQ(list_code(worker), PERMISSION_DENIED);
  EXPECT_EQ(list_code(client), OK);
  EXPECT_EQ(list_code(admin), OK);
  EXPECT_EQ(register_code(worker), OK);
  EXPECT_EQ(register_code(client), PERMISSION_DENIED);
  EXPECT_EQ(register_code(admin), PERMISSION_DENIED);
  EXPECT_EQ(find_missing_code(worker), PERMISSION_DENIED);
  EXPECT_EQ(find_missing_code(client), OK);
  EXPECT_EQ(download_code(worker), NOT_FOUND);
  EXPECT_EQ(download_code(client), PERMISSION_DENIED);
  EXPECT_EQ(download_code(admin), NOT_FOUND);

  const auto trust = [](const std::shared_ptr<grpc::Channel>& channel) {
    grpc::ClientContext context;
    v1::TrustHostRequest request;
    request.set_host("h");
    v1::TrustHostResponse response;
    return v1::FarmService::NewStub(channel)->TrustHost(&context, request, &response).error_code();
  };
  EXPECT_EQ(trust(client), PERMISSION_DENIED);
  EXPECT_EQ(trust(admin), NOT_FOUND);  // there is no such host
  // A server's certificate is no key to another's door.
  EXPECT_NE(list_code(channel_of("server")), OK);
}

TEST_F(Tls, JobsBelongToWhoeverSubmittedThem) {
  using enum grpc::StatusCode;
  const auto alice = channel_of("client-alice"), bob = channel_of("client-bob"), admin = channel_of("admin");
  std::string job;
  ASSERT_EQ(submit(alice, "bob", job), OK);  // it does not help to say that one is somebody else
  const std::vector<grpc::StatusCode> refused(5, PERMISSION_DENIED);
  EXPECT_EQ(codes_about(job, bob), refused);
  std::string continued = job;
  EXPECT_EQ(submit(bob, "bob", continued), PERMISSION_DENIED);
  v1::ListJobsResponse jobs;
  ASSERT_TRUE(list(bob, jobs).ok());
  EXPECT_EQ(jobs.jobs_size(), 0);
  ASSERT_TRUE(list(admin, jobs).ok());
  ASSERT_EQ(jobs.jobs_size(), 1);
  EXPECT_EQ(jobs.jobs(0).user(), "alice");
  ASSERT_TRUE(list(alice, jobs).ok());
  EXPECT_EQ(jobs.jobs_size(), 1);
  // A job of one unit: adjusting changes nothing, retrying finds nothing to retry, and it ends cancelled.
  for (const grpc::StatusCode code : codes_about(job, alice)) EXPECT_NE(code, PERMISSION_DENIED);
  for (const grpc::StatusCode code : codes_about(job, admin)) EXPECT_NE(code, PERMISSION_DENIED);
}

TEST_F(Tls, StrangersDoNotGetIn) {
  // Certificates of another authority; expired; not valid yet; none; a server's for another host.
  ASSERT_TRUE(write_farm_certificates(folder_.path() / "other", {}, {"alice"}).ok());
  EXPECT_EQ(list_code(channel(folder_.path() / "other" / "client-alice")), grpc::StatusCode::UNAVAILABLE);

  const auto authority = Authority::open(farm_certificates() / "authority");
  ASSERT_TRUE(authority.ok());
  const Identity alice{.role = Role::kClient, .name = "alice", .hosts = {}};
  const auto now = SystemClock::now();
  const fs::path expired = folder_.path() / "expired", early = folder_.path() / "early";
  ASSERT_TRUE(authority->issue(alice, expired, now - hours{48}, now - hours{24}).ok());
  ASSERT_TRUE(authority->issue(alice, early, now + hours{24}, now + hours{48}).ok());
  for (const fs::path& untimely : {expired, early}) {
    EXPECT_TRUE(absl::IsFailedPrecondition(net::check_certificates(untimely.string()))) << untimely;
    // The client's own check set aside, the coordinator refuses as well.
    const auto direct = grpc::CreateChannel(address(), net::channel_credentials(untimely));
    EXPECT_EQ(list_code(direct), grpc::StatusCode::UNAVAILABLE);
  }
  const auto plain = net::make_channel(address());
  EXPECT_EQ(list_code(*plain), grpc::StatusCode::UNAVAILABLE);
}

TEST_F(Tls, OlderVersionsOfTlsAreNotSpoken) {
  const fs::path alice = farm_certificates() / "client-alice";
  const auto connects_with = [&](int version) {
    const std::unique_ptr<SSL_CTX, base::Freer<SSL_CTX_free>> context{SSL_CTX_new(TLS_client_method())};
    EXPECT_EQ(SSL_CTX_set_min_proto_version(context.get(), TLS1_VERSION), 1);
    EXPECT_EQ(SSL_CTX_set_max_proto_version(context.get(), version), 1);
    EXPECT_EQ(SSL_CTX_use_certificate_chain_file(context.get(), (alice / net::kCertificateFile).c_str()), 1);
    EXPECT_EQ(SSL_CTX_use_PrivateKey_file(context.get(), (alice / net::kKeyFile).c_str(), SSL_FILETYPE_PEM),
              1);
    const std::unique_ptr<BIO, base::Freer<BIO_free_all>> connection{BIO_new_ssl_connect(context.get())};
    SSL* ssl = nullptr;
    BIO_get_ssl(connection.get(), &ssl);
    constexpr unsigned char kHttp2[] = "\x02h2";
    SSL_set_alpn_protos(ssl, kHttp2, sizeof(kHttp2) - 1);
    BIO_set_conn_hostname(connection.get(), address().c_str());
    return BIO_do_handshake(connection.get()) == 1;
  };
  EXPECT_FALSE(connects_with(TLS1_1_VERSION));
  EXPECT_FALSE(connects_with(TLS1_2_VERSION));
  EXPECT_TRUE(connects_with(TLS1_3_VERSION));
}

TEST_F(Tls, AHandshakeMayTakeItsTime) {
  // A coordinator that nothing reaches for the first half second, as on a long way or a busy machine.
  support::TcpProxy slow{coordinator_->bound_port()};
  slow.set_fault(support::TcpProxy::Fault::kSilence);
  const auto channel =
      net::make_channel(slow.address(), {.certificates = (farm_certificates() / "client-alice").string()});
  ASSERT_TRUE(channel.ok()) << channel.status();
  const std::jthread later{[&slow] {
    std::this_thread::sleep_for(std::chrono::milliseconds{500});
    slow.set_fault(support::TcpProxy::Fault::kNone);
  }};
  // Calls end with the first attempt to connect that fails.
  grpc::ClientContext context;
  v1::ListJobsResponse jobs;
  const grpc::Status status = v1::FarmService::NewStub(*channel)->ListJobs(&context, {}, &jobs);
  EXPECT_TRUE(status.ok()) << status.error_message();
}

TEST_F(Tls, AServerThatIsNotTheOneCalledIsNotTalkedTo) {
  coordinator_.reset();
  const auto authority = Authority::open(farm_certificates() / "authority");
  ASSERT_TRUE(authority.ok());
  const fs::path elsewhere = folder_.path() / "elsewhere";
  const auto now = SystemClock::now();
  ASSERT_TRUE(authority
                  ->issue({.role = Role::kServer, .name = "tessera-server", .hosts = {"elsewhere.example"}},
                          elsewhere, now - hours{1}, now + hours{24})
                  .ok());
  CoordinatorOptions options;
  options.listen = "127.0.0.1:0";
  options.certificates = elsewhere.string();
  auto started = Coordinator::start(options);
  ASSERT_TRUE(started.ok()) << started.status();
  coordinator_ = *std::move(started);
  EXPECT_EQ(list_code(channel_of("client-alice")), grpc::StatusCode::UNAVAILABLE);
}

TEST_F(Tls, RenewedCertificatesAreTakenUpWithoutARestart) {
  ASSERT_EQ(list_code(channel_of("client-alice")), grpc::StatusCode::OK);
  // The farm moves to a new authority: files are replaced under the running coordinator.
  fs::remove_all(farm_certificates() / "authority");
  const fs::path old_alice = folder_.path() / "old-alice";
  fs::copy(farm_certificates() / "client-alice", old_alice);
  ASSERT_TRUE(write_farm_certificates(farm_certificates(), {}, {"alice"}).ok());
  const auto deadline = std::chrono::steady_clock::now() + support::kPatience;
  while (list_code(channel_of("client-alice")) != grpc::StatusCode::OK) {
    ASSERT_LT(std::chrono::steady_clock::now(), deadline) << "the new certificates were not taken up";
  }
  EXPECT_EQ(list_code(channel(old_alice)), grpc::StatusCode::UNAVAILABLE);
}

TEST(Authority, KeepsItsKeysToItself) {
  const support::TempDir folder;
  ASSERT_TRUE(write_farm_certificates(folder.path(), {"render1"}, {"alice"}).ok());
  int keys = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder.path())) {
    if (entry.path().filename() != net::kKeyFile) continue;
    ++keys;
    EXPECT_EQ(entry.status().permissions(), fs::perms::owner_read | fs::perms::owner_write) << entry.path();
  }
  EXPECT_EQ(keys, 5);
}

TEST(Authority, SaysWhatIsWrongWithCertificates) {
  const support::TempDir folder;
  ASSERT_TRUE(write_farm_certificates(folder.path(), {}, {"alice", "bob"}).ok());
  const fs::path alice = folder.path() / "client-alice", bob = folder.path() / "client-bob";
  EXPECT_TRUE(net::check_certificates(alice.string()).ok());
  // The second of several authorities may be one's own.
  const support::TempDir other;
  ASSERT_TRUE(write_farm_certificates(other.path(), {}, {"alice"}).ok());
  const fs::path trusted = alice / net::kTrustedFile, kept = folder.path() / "kept.pem";
  fs::rename(trusted, kept);
  fs::copy_file(other.path() / "client-alice" / net::kTrustedFile, trusted);
  EXPECT_TRUE(absl::IsInvalidArgument(net::check_certificates(alice.string())));
  std::ofstream{trusted, std::ios::app} << std::ifstream{kept}.rdbuf();
  EXPECT_TRUE(net::check_certificates(alice.string()).ok());
  EXPECT_TRUE(absl::IsNotFound(net::check_certificates((folder.path() / "nobody").string())));
  fs::copy_file(bob / net::kKeyFile, alice / net::kKeyFile, fs::copy_options::overwrite_existing);
  EXPECT_TRUE(absl::IsInvalidArgument(net::check_certificates(alice.string())));  // a key of another
  std::error_code ignored;
  fs::resize_file(bob / net::kCertificateFile, 100, ignored);
  EXPECT_TRUE(absl::IsInvalidArgument(net::check_certificates(bob.string())));
  EXPECT_TRUE(absl::IsInvalidArgument(write_farm_certificates(folder.path(), {}, {"../evil"})));
  EXPECT_TRUE(absl::IsInvalidArgument(write_farm_certificates(folder.path(), {"a,DNS:b"}, {})));
}

}  // namespace
}  // namespace tessera::server
