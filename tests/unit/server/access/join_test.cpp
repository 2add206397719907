// Joining the farm with a token, and what the port where that is done does not give away.
#include <gmock/gmock.h>
#include <google/protobuf/descriptor.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>
#include <openssl/ec.h>

#include <chrono>
#include <filesystem>

#include "base/private_file.h"
#include "net/authorities.h"
#include "net/backoff.h"
#include "net/channel.h"
#include "net/join_token.h"
#include "net/tls.h"
#include "net/x509.h"
#include "service/coordinator.h"
#include "support/patience.h"
#include "support/process/temp_dir.h"
#include "tessera/v1/blob.grpc.pb.h"
#include "tessera/v1/farm.grpc.pb.h"
#include "tessera/v1/join.grpc.pb.h"
#include "tessera/v1/work.grpc.pb.h"
#include "tls/authority.h"
#include "tls/join_tokens.h"

namespace tessera::server {
namespace {

namespace fs = std::filesystem;
using enum grpc::StatusCode;

std::string request_pem(EVP_PKEY* key) { return net::to_pem(net::make_request(key, "render7").get()); }

/// The code of a call without a request, by the method's full name.
grpc::StatusCode call_code(const std::shared_ptr<grpc::Channel>& channel, const std::string& method) {
  grpc::GenericStub stub{channel};
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + support::kPatience);
  grpc::CompletionQueue queue;
  const auto call = stub.PrepareUnaryCall(&context, method, grpc::ByteBuffer{nullptr, 0}, &queue);
  call->StartCall();
  grpc::ByteBuffer response;
  grpc::Status status;
  call->Finish(&response, &status, nullptr);
  void* tag = nullptr;
  bool ok = false;
  queue.Next(&tag, &ok);
  queue.Shutdown();
  while (queue.Next(&tag, &ok)) {
  }
  return status.error_code();
}

class Joining : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(write_farm_certificates(farm(), {}, {"alice"}).ok());
    auto started = Coordinator::start(options());
    ASSERT_TRUE(started.ok()) << started.status();
    coordinator_ = *std::move(started);
  }

  fs::path farm() const { return folder_.path() / "farm"; }
  CoordinatorOptions options() const {
    CoordinatorOptions options;
    options.listen = "127.0.0.1:0";
    options.certificates = farm() / "server";
    options.join_authority = farm() / "authority";
    return options;
  }

  std::string main_address() const { return "127.0.0.1:" + std::to_string(coordinator_->bound_port()); }
  std::string join_address() const { return "127.0.0.1:" + std::to_string(coordinator_->join_port()); }

  std::shared_ptr<grpc::Channel> member(const fs::path& certificates) const {
    return net::make_channel(main_address(), {.certificates = certificates.string()}).value();
  }

  /// Channel of somebody who has the token's authority, and nothing else.
  std::shared_ptr<grpc::Channel> stranger() const {
    const auto authority = Authority::open(farm() / "authority");
    return grpc::CreateChannel(join_address(), net::trusting_credentials(authority->certificate_pem()));
  }

  grpc::Status make_token(const std::string& program, std::uint32_t uses, std::string& token) const {
    grpc::ClientContext context;
    v1::MakeJoinTokenRequest request;
    request.mutable_lifetime()->set_seconds(60);
    request.set_uses(uses);
    v1::MakeJoinTokenResponse response;
    const grpc::Status status =
        v1::FarmService::NewStub(member(farm() / program))->MakeJoinToken(&context, request, &response);
    token = response.token();
    return status;
  }
  std::string secret(std::uint32_t uses = 1) const {
    std::string token;
    EXPECT_TRUE(make_token("admin", uses, token).ok());
    const auto parsed = net::parse_join_token(token);
    EXPECT_TRUE(parsed.ok()) << parsed.status();
    return parsed.ok() ? parsed->secret : "";
  }

  grpc::StatusCode join(const std::string& secret, const std::string& request,
                        std::string* certificate = nullptr, const std::string& name = "render7") const {
    grpc::ClientContext context;
    v1::JoinRequest message;
    message.set_secret(secret);
    message.set_name(name);
    message.set_request_pem(request);
    v1::JoinResponse response;
    const grpc::Status status = v1::JoinService::NewStub(stranger())->Join(&context, message, &response);
    if (certificate != nullptr) *certificate = response.certificate_pem();
    return status.error_code();
  }

  support::TempDir folder_;
  const net::Key key_ = net::make_key();
  std::unique_ptr<Coordinator> coordinator_;
};

TEST_F(Joining, ATokenMakesAWorkerAndNothingMore) {
  std::string certificate;
  ASSERT_EQ(join(secret(), request_pem(key_.get()), &certificate), OK);
  const fs::path mine = folder_.path() / "mine";
  ASSERT_TRUE(base::make_folder(mine).ok());
  ASSERT_TRUE(base::replace_file(mine / net::kKeyFile, 0600, net::to_pem(key_.get())).ok());
  ASSERT_TRUE(base::replace_file(mine / net::kCertificateFile, 0644, certificate).ok());
  fs::copy_file(farm() / "server" / net::kTrustedFile, mine / net::kTrustedFile);
  ASSERT_TRUE(net::check_certificates(mine.string()).ok());

  const auto channel = member(mine);
  EXPECT_EQ(call_code(channel, "/tessera.v1.WorkService/Register"),
            FAILED_PRECONDITION);  // refused for protocol 0, but heard
  EXPECT_EQ(call_code(channel, "/tessera.v1.FarmService/ListJobs"), PERMISSION_DENIED);
  EXPECT_EQ(call_code(channel, "/tessera.v1.FarmService/MakeJoinToken"), PERMISSION_DENIED);
}

TEST_F(Joining, MachinesOfOneNameAreExpelledOneByOne) {
  const std::string twice = secret(2);
  const net::Key other_key = net::make_key();
  std::string certificate, other;
  ASSERT_EQ(join(twice, request_pem(key_.get()), &certificate), OK);
  ASSERT_EQ(join(twice, request_pem(other_key.get()), &other), OK);
  const auto name_in = [](const std::string& pem) {
    return net::name_of(net::certificate_from_pem(pem).get());
  };
  EXPECT_THAT(name_in(certificate), testing::MatchesRegex("render7@[0-9a-f]{8}"));
  EXPECT_THAT(name_in(other), testing::MatchesRegex("render7@[0-9a-f]{8}"));
  EXPECT_NE(name_in(certificate), name_in(other));

  const auto worker_with = [&](const std::string& pem, const net::Key& key) {
    const fs::path mine = folder_.path() / name_in(pem);
    EXPECT_TRUE(base::make_folder(mine).ok());
    EXPECT_TRUE(base::replace_file(mine / net::kKeyFile, 0600, net::to_pem(key.get())).ok());
    EXPECT_TRUE(base::replace_file(mine / net::kCertificateFile, 0644, pem).ok());
    fs::copy_file(farm() / "server" / net::kTrustedFile, mine / net::kTrustedFile);
    return call_code(member(mine), "/tessera.v1.WorkService/Register");
  };
  const auto expel = [&](const std::string& name) {
    grpc::ClientContext context;
    v1::ExpelRequest request;
    request.set_role("worker");
    request.set_name(name);
    v1::ExpelResponse response;
    return v1::FarmService::NewStub(member(farm() / "admin"))->Expel(&context, request, &response);
  };
  const grpc::Status unclear = expel("render7");
  EXPECT_EQ(unclear.error_code(), NOT_FOUND);
  EXPECT_THAT(unclear.error_message(),
              testing::AllOf(testing::HasSubstr(name_in(certificate)), testing::HasSubstr(name_in(other))));
  ASSERT_TRUE(expel(name_in(certificate)).ok());
  EXPECT_EQ(worker_with(certificate, key_), PERMISSION_DENIED);
  EXPECT_EQ(worker_with(other, other_key), FAILED_PRECONDITION) << "of protocol 0, but heard";
}

TEST_F(Joining, AKeyWithTheFirstDigitsOfAnothersGetsANameOfItsOwn) {
  const std::string twice = secret(2);
  std::string first, second;
  ASSERT_EQ(join(twice, request_pem(key_.get()), &first), OK);
  ASSERT_EQ(join(twice, request_pem(key_.get()), &second), OK) << "the same key stands for one that is alike";
  const auto name_in = [](const std::string& pem) {
    return net::name_of(net::certificate_from_pem(pem).get());
  };
  EXPECT_THAT(name_in(second), testing::StartsWith(name_in(first)));
  EXPECT_NE(name_in(second), name_in(first));
  std::string long_name;
  ASSERT_EQ(join(secret(), request_pem(key_.get()), &long_name, std::string(64, 'n')), OK);
  EXPECT_EQ(name_in(long_name).size(), 64u);
}

TEST_F(Joining, WrongAndUsedUpTokensAreRefused) {
  const std::string once = secret();
  std::string tampered = once;
  tampered.front() = tampered.front() == '0' ? '1' : '0';
  EXPECT_EQ(join(tampered, request_pem(key_.get())), PERMISSION_DENIED);
  EXPECT_EQ(join("", request_pem(key_.get())), PERMISSION_DENIED);
  EXPECT_EQ(join(std::string(1000, '0'), request_pem(key_.get())), INVALID_ARGUMENT);
  EXPECT_EQ(join(once, request_pem(key_.get())), OK);
  EXPECT_EQ(join(once, request_pem(key_.get())), PERMISSION_DENIED);
}

TEST_F(Joining, UnsoundRequestsDoNotUseTheTokenUp) {
  const std::string once = secret();
  EXPECT_EQ(join(once, "no request"), INVALID_ARGUMENT);
  EXPECT_EQ(join(once, std::string(5000, 'x')), INVALID_ARGUMENT);
  EXPECT_EQ(join(once, request_pem(key_.get()), nullptr, "../evil"), INVALID_ARGUMENT);
  EXPECT_EQ(join(once, request_pem(key_.get()), nullptr, "a,URI:tessera:admin"), INVALID_ARGUMENT);
  const net::Key other_curve{EVP_EC_gen("P-384")};
  EXPECT_EQ(join(once, request_pem(other_curve.get())), INVALID_ARGUMENT);
  // Somebody else's public key, signed with one's own.
  const net::Key other = net::make_key();
  const net::CertificateRequest stolen = net::make_request(key_.get(), "render7");
  ASSERT_EQ(X509_REQ_set_pubkey(stolen.get(), other.get()), 1);
  EXPECT_EQ(join(once, net::to_pem(stolen.get())), INVALID_ARGUMENT);
  EXPECT_EQ(join(once, request_pem(key_.get())), OK);
}

TEST_F(Joining, GuessersHaveToWait) {
  grpc::StatusCode last = OK;
  for (std::uint32_t i = 0; i <= JoinTokens::kFailuresAMinute; ++i) {
    last = join(std::string(32, '0'), request_pem(key_.get()));
  }
  EXPECT_EQ(last, RESOURCE_EXHAUSTED);
}

TEST_F(Joining, TokensAreMadeByAdministratorsOnly) {
  std::string token;
  EXPECT_EQ(make_token("worker", 1, token).error_code(), PERMISSION_DENIED);
  EXPECT_EQ(make_token("client-alice", 1, token).error_code(), PERMISSION_DENIED);
  EXPECT_EQ(make_token("admin", 0, token).error_code(), INVALID_ARGUMENT);
  ASSERT_EQ(make_token("admin", 1, token).error_code(), OK);
  const auto parsed = net::parse_join_token(token);
  ASSERT_TRUE(parsed.ok());
  EXPECT_EQ(parsed->port, coordinator_->join_port());
  EXPECT_EQ(parsed->authority_digest, Authority::open(farm() / "authority")->digest());
}

// Methods that are added to the services later on are walked over here too.
TEST_F(Joining, NothingElseIsReachableWithoutACertificate) {
  const auto authority = Authority::open(farm() / "authority");
  const auto at_main =
      grpc::CreateChannel(main_address(), net::trusting_credentials(authority->certificate_pem()));
  const auto at_join = stranger();
  int methods = 0;
  const auto* const pool = google::protobuf::DescriptorPool::generated_pool();
  for (const char* file :
       {"tessera/v1/farm.proto", "tessera/v1/work.proto", "tessera/v1/blob.proto", "tessera/v1/join.proto"}) {
    const auto* const descriptor = pool->FindFileByName(file);
    ASSERT_NE(descriptor, nullptr) << file;
    for (int s = 0; s < descriptor->service_count(); ++s) {
      for (int m = 0; m < descriptor->service(s)->method_count(); ++m) {
        const std::string service = descriptor->service(s)->full_name();
        const std::string method = "/" + service + "/" + descriptor->service(s)->method(m)->name();
        ++methods;
        EXPECT_EQ(call_code(at_main, method), UNAVAILABLE) << method;
        if (service != "tessera.v1.JoinService") {
          EXPECT_EQ(call_code(at_join, method), PERMISSION_DENIED) << method;
        }
      }
    }
  }
  EXPECT_GE(methods, 22);
  for (const char* method :
       {"/grpc.health.v1.Health/Check", "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo"}) {
    EXPECT_EQ(call_code(at_main, method), UNAVAILABLE);
    EXPECT_EQ(call_code(at_join, method), PERMISSION_DENIED);
  }
  // Members are told nothing more there.
  const auto admin = grpc::CreateChannel(join_address(), net::channel_credentials(farm() / "admin"));
  EXPECT_EQ(call_code(admin, "/tessera.v1.FarmService/ListJobs"), PERMISSION_DENIED);
}

TEST_F(Joining, WithoutAnAuthorityNobodyJoins) {
  CoordinatorOptions without = options();
  without.join_authority.clear();
  auto started = Coordinator::start(without);
  ASSERT_TRUE(started.ok());
  coordinator_ = *std::move(started);
  EXPECT_EQ(coordinator_->join_port(), 0);
  std::string token;
  EXPECT_EQ(make_token("admin", 1, token).error_code(), FAILED_PRECONDITION);
}

TEST_F(Joining, ANewAuthorityCertifiesWithoutARestart) {
  CoordinatorOptions watchful = options();
  watchful.certificate_interval = std::chrono::seconds{1};
  auto started = Coordinator::start(watchful);
  ASSERT_TRUE(started.ok()) << started.status();
  coordinator_ = *std::move(started);
  fs::remove_all(farm() / "authority");
  ASSERT_TRUE(write_farm_certificates(farm(), {}, {"alice"}).ok());
  const auto authority = Authority::open(farm() / "authority");
  // gRPC looks at the files of each port in its own time; until then it is asked again at a worker's pace.
  // The bound only ends a test that hangs.
  net::Backoff backoff;
  const auto deadline = std::chrono::steady_clock::now() + support::kPatience;
  std::string token, certificate;
  while (!make_token("admin", 1, token).ok()) {
    ASSERT_LT(std::chrono::steady_clock::now(), deadline);
    net::interruptible_sleep(backoff.next(), {});
  }
  const auto parsed = net::parse_join_token(token);
  ASSERT_TRUE(parsed.ok()) << parsed.status();
  EXPECT_EQ(parsed->authority_digest, authority->digest());
  backoff.reset();
  grpc::StatusCode code = UNAVAILABLE;
  while ((code = join(parsed->secret, request_pem(key_.get()), &certificate)) == UNAVAILABLE) {
    ASSERT_LT(std::chrono::steady_clock::now(), deadline);
    net::interruptible_sleep(backoff.next(), {});
  }
  ASSERT_EQ(code, OK);
  const net::Certificate joined = net::certificate_from_pem(certificate);
  EXPECT_TRUE(net::check_signed(authority->certificate_pem(), joined.get(), "worker").ok());
}

TEST_F(Joining, TheAuthorityMustBeTheServersOwn) {
  ASSERT_TRUE(write_farm_certificates(folder_.path() / "other", {}, {}).ok());
  CoordinatorOptions other = options();
  other.join_authority = folder_.path() / "other" / "authority";
  EXPECT_TRUE(absl::IsInvalidArgument(Coordinator::start(other).status()));
  other.join_authority = folder_.path() / "nowhere";
  EXPECT_TRUE(absl::IsUnavailable(Coordinator::start(other).status()));
  CoordinatorOptions plain = options();
  plain.certificates.clear();
  EXPECT_TRUE(absl::IsInvalidArgument(Coordinator::start(plain).status()));
}

TEST(JoinToken, IsReadAsItIsWritten) {
  const net::JoinToken token{
      .port = 7071, .authority_digest = std::string(64, 'a'), .secret = std::string(32, '7')};
  const auto read = net::parse_join_token(token.to_string());
  ASSERT_TRUE(read.ok());
  EXPECT_EQ(read->port, token.port);
  EXPECT_EQ(read->authority_digest, token.authority_digest);
  EXPECT_EQ(read->secret, token.secret);
  const std::string text = token.to_string();
  for (const std::string& bad :
       {std::string{}, text.substr(1), text.substr(0, text.size() - 1), text + "0", text + ":1",
        "tessera-join:0" + text.substr(17), "tessera-join:99999" + text.substr(17)}) {
    const auto refused = net::parse_join_token(bad);
    EXPECT_TRUE(absl::IsInvalidArgument(refused.status())) << bad;
    EXPECT_EQ(std::string(refused.status().message()).find("7777"), std::string::npos);
  }
}

}  // namespace
}  // namespace tessera::server
