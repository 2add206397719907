// Members of a farm who are put out of it while their certificates are valid.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "net/x509.h"
#include "tls/expelled.h"
#include "unit/server/access/tls_fixture.h"
#include "unit/server/coordinator_fixture.h"

namespace tessera::server {
namespace {

using std::chrono::hours;
using std::chrono::seconds;
using enum grpc::StatusCode;

const Expelled::Time kNow{hours{24 * 365 * 50}};

/// A certificate that was made at some time, as PEM.
std::string made_at(const Authority& authority, Role role, const std::string& name, Expelled::Time time) {
  const net::Key key = net::make_key();
  return authority
      .certify(net::to_pem(net::make_request(key.get(), name).get()),
               {.role = role, .name = name, .hosts = {}}, time - kClockSlack, time + kCertificateLife)
      .value();
}

TEST(ExpelledMembers, AreRefusedByCertificatesOfBeforeOnly) {
  const support::TempDir folder;
  const Authority authority = Authority::open(folder.path() / "authority").value();
  const std::string before = made_at(authority, Role::kWorker, "render7", kNow - hours{24});
  const std::string same = made_at(authority, Role::kWorker, "render7", kNow);
  const std::string after = made_at(authority, Role::kWorker, "render7", kNow + seconds{1});
  const auto expelled = Expelled::open({}).value();
  EXPECT_FALSE(expelled->refuses(Role::kWorker, "render7", before));
  ASSERT_TRUE(expelled->expel(Role::kWorker, "render7", kNow).ok());
  EXPECT_TRUE(expelled->refuses(Role::kWorker, "render7", before));
  EXPECT_TRUE(expelled->refuses(Role::kWorker, "render7", same));
  EXPECT_FALSE(expelled->refuses(Role::kWorker, "render7", after));
  EXPECT_TRUE(expelled->refuses(Role::kWorker, "render7", "no certificate"));
  EXPECT_TRUE(expelled->refuses(Role::kWorker, "render7", ""));
  // The same name in another role, or another name, is somebody else.
  EXPECT_FALSE(expelled->refuses(Role::kClient, "render7", before));
  EXPECT_FALSE(expelled->refuses(Role::kWorker, "render70", before));

  ASSERT_TRUE(expelled->expel(Role::kWorker, "render7", kNow + seconds{1}).ok());
  EXPECT_TRUE(expelled->refuses(Role::kWorker, "render7", after)) << "a second time";
  ASSERT_TRUE(expelled->expel(Role::kWorker, "render7", kNow - hours{1}).ok());
  EXPECT_TRUE(expelled->refuses(Role::kWorker, "render7", after)) << "a clock that goes back lets nobody in";
  ASSERT_TRUE(expelled->readmit(Role::kWorker, "render7").ok());
  EXPECT_FALSE(expelled->refuses(Role::kWorker, "render7", before));
  EXPECT_TRUE(absl::IsNotFound(expelled->readmit(Role::kWorker, "render7")));
}

TEST(ExpelledMembers, AreRememberedAndDamageIsNoticed) {
  const support::TempDir folder;
  const std::filesystem::path file = folder.path() / "expelled";
  {
    const auto expelled = Expelled::open(file).value();
    ASSERT_TRUE(expelled->expel(Role::kWorker, "render7", kNow).ok());
    ASSERT_TRUE(expelled->expel(Role::kClient, "alice", kNow).ok());
    for (const std::string& bad : {std::string{}, std::string{"two words"}, std::string{"a\nclient bob 0"},
                                   std::string(Expelled::kLongestName + 1, 'n')}) {
      EXPECT_TRUE(absl::IsInvalidArgument(expelled->expel(Role::kWorker, bad, kNow))) << bad;
    }
  }
  {
    const auto expelled = Expelled::open(file).value();
    EXPECT_TRUE(expelled->refuses(Role::kWorker, "render7", ""));
    EXPECT_TRUE(expelled->refuses(Role::kClient, "alice", ""));
    EXPECT_FALSE(expelled->refuses(Role::kClient, "bob", ""));
  }
  // Nobody is let in because a line cannot be read.
  for (const char* line :
       {"worker render7", "guest render7 5", "worker render7 five", "worker render7 5 6"}) {
    std::ofstream{file} << line << '\n';
    EXPECT_TRUE(absl::IsDataLoss(Expelled::open(file).status())) << line;
  }
}

class Expelling : public TlsTest {
 protected:
  grpc::StatusCode expel(const std::string& by, const std::string& role, const std::string& name,
                         bool undo = false, bool unseen = false) {
    grpc::ClientContext context;
    v1::ExpelRequest request;
    request.set_unseen(unseen);
    request.set_role(role);
    request.set_name(name);
    request.set_undo(undo);
    response_.Clear();
    const grpc::Status status =
        v1::FarmService::NewStub(channel_of(by))->Expel(&context, request, &response_);
    message_ = status.error_message();
    return status.error_code();
  }
  v1::JobStatus job(const std::string& id) {
    grpc::ClientContext context;
    v1::GetJobRequest request;
    request.set_job_id(id);
    v1::GetJobResponse response;
    EXPECT_TRUE(v1::FarmService::NewStub(channel_of("admin"))->GetJob(&context, request, &response).ok());
    return response.status();
  }
  v1::ListWorkersResponse workers() {
    grpc::ClientContext context;
    v1::ListWorkersResponse response;
    EXPECT_TRUE(v1::FarmService::NewStub(channel_of("admin"))->ListWorkers(&context, {}, &response).ok());
    return response;
  }

  v1::ExpelResponse response_;
  std::string message_;
};

TEST_F(Expelling, NobodyIsExpelledByATypingError) {
  ASSERT_EQ(list_code(channel_of("client-alice")), OK);
  ASSERT_EQ(register_code(channel_of("worker")), OK);
  start();  // who called is remembered
  EXPECT_EQ(expel("admin", "client", "alcie"), NOT_FOUND);
  EXPECT_THAT(message_, testing::HasSubstr("did you mean 'alice'?"));
  EXPECT_EQ(expel("admin", "worker", "alice"), NOT_FOUND) << "she is a client";
  EXPECT_EQ(list_code(channel_of("client-alice")), OK);
  // A certificate that was never used here, and lies in the wrong hands.
  EXPECT_EQ(expel("admin", "client", "bob"), NOT_FOUND);
  EXPECT_EQ(expel("admin", "client", "bob", /*undo=*/false, /*unseen=*/true), OK);
  EXPECT_EQ(list_code(channel_of("client-bob")), PERMISSION_DENIED);
}

TEST_F(Expelling, AWorkerIsOutAtOnceAndANewCertificateLetsItIn) {
  std::string worker, id;
  ASSERT_EQ(register_worker(channel_of("worker"), worker), OK);
  ASSERT_EQ(submit(channel_of("client-alice"), "alice", id), OK);
  ASSERT_EQ(workers().workers_size(), 1);
  EXPECT_EQ(workers().workers(0).certificate(), "tessera-worker");
  grpc::ClientContext context;
  v1::LeaseRequest request;
  request.set_worker_id(worker);
  request.set_max_units(1);
  v1::LeaseResponse leases;
  const auto work = v1::WorkService::NewStub(channel_of("worker"));
  ASSERT_TRUE(work->Lease(&context, request, &leases).ok());
  ASSERT_EQ(leases.leases_size(), 1);
  EXPECT_EQ(job(id).units_leased(), 1u);

  ASSERT_EQ(expel("admin", "worker", "tessera-worker"), OK);
  EXPECT_EQ(response_.workers(), 1u);
  EXPECT_EQ(workers().workers_size(), 0);
  EXPECT_EQ(job(id).units_leased(), 0u) << "others may have it at once";
  // Results that it has rendered meanwhile are not taken, over the connection that it had, or a new one.
  grpc::ClientContext late;
  v1::CompleteRequest result;
  result.set_worker_id(worker);
  *result.mutable_token() = leases.leases(0).token();
  result.set_payload(payload_for(leases.leases(0).unit()));
  v1::CompleteResponse ignored;
  const grpc::Status refused = work->Complete(&late, result, &ignored);
  EXPECT_EQ(refused.error_code(), PERMISSION_DENIED);
  EXPECT_THAT(refused.error_message(), testing::HasSubstr("'tessera-worker' (worker) was expelled"));
  EXPECT_EQ(register_code(channel_of("worker")), PERMISSION_DENIED);
  start();
  EXPECT_EQ(register_code(channel_of("worker")), PERMISSION_DENIED) << "after a restart";

  // Made ten seconds later: valid already, as all certificates are an hour before they are made.
  const auto authority = Authority::open(farm_certificates() / "authority");
  ASSERT_TRUE(authority.ok());
  const auto later = std::chrono::system_clock::now() + seconds{10};
  const std::filesystem::path fresh = folder_.path() / "fresh";
  ASSERT_TRUE(authority
                  ->issue({.role = Role::kWorker, .name = "tessera-worker", .hosts = {}}, fresh,
                          later - kClockSlack, later + hours{24})
                  .ok());
  EXPECT_EQ(register_code(channel(fresh)), OK);
  ASSERT_EQ(expel("admin", "worker", "tessera-worker", /*undo=*/true), OK);
  EXPECT_EQ(register_code(channel_of("worker")), OK);
  EXPECT_EQ(expel("admin", "worker", "tessera-worker", /*undo=*/true), NOT_FOUND);
}

TEST_F(Expelling, AClientsStreamsEnd) {
  const auto alice = channel_of("client-alice");
  std::string id;
  ASSERT_EQ(submit(alice, "alice", id), OK);
  grpc::ClientContext context;
  v1::WatchJobRequest request;
  request.set_job_id(id);
  const auto farm = v1::FarmService::NewStub(alice);
  const auto stream = farm->WatchJob(&context, request);
  v1::WatchJobResponse message;
  ASSERT_TRUE(stream->Read(&message));
  ASSERT_EQ(expel("admin", "client", "alice"), OK);
  while (stream->Read(&message)) {
  }
  EXPECT_EQ(stream->Finish().error_code(), CANCELLED);
  EXPECT_EQ(list_code(alice), PERMISSION_DENIED);
  EXPECT_EQ(list_code(channel_of("client-bob")), OK);
}

TEST_F(Expelling, IsForAdministrators) {
  EXPECT_EQ(expel("worker", "client", "alice"), PERMISSION_DENIED);
  EXPECT_EQ(expel("client-alice", "client", "bob"), PERMISSION_DENIED);
  EXPECT_EQ(list_code(channel_of("client-bob")), OK);
  EXPECT_EQ(expel("admin", "server", "tessera-server"), INVALID_ARGUMENT);
  EXPECT_EQ(expel("admin", "", "alice"), INVALID_ARGUMENT);
  EXPECT_EQ(expel("admin", "client", ""), INVALID_ARGUMENT);
}

TEST_F(Expelling, ALeakedCertificateOfAnAdministratorIsPutOutByTheNextOne) {
  const auto authority = Authority::open(farm_certificates() / "authority");
  ASSERT_TRUE(authority.ok());
  const auto before = std::chrono::system_clock::now() - seconds{10};
  const std::filesystem::path leaked = folder_.path() / "leaked";
  ASSERT_TRUE(authority
                  ->issue({.role = Role::kAdmin, .name = "admin", .hosts = {}}, leaked, before - kClockSlack,
                          before + hours{24})
                  .ok());
  EXPECT_EQ(list_code(channel(leaked)), OK);
  ASSERT_EQ(expel("admin", "admin", "admin"), OK);
  EXPECT_EQ(list_code(channel(leaked)), PERMISSION_DENIED);
  EXPECT_EQ(list_code(channel_of("admin")), OK);
}

TEST_F(CoordinatorTest, NobodyIsExpelledWhereNobodyHasACertificate) {
  start();
  grpc::ClientContext context;
  v1::ExpelRequest request;
  request.set_role("worker");
  request.set_name("render7");
  v1::ExpelResponse response;
  EXPECT_EQ(farm_->Expel(&context, request, &response).error_code(), FAILED_PRECONDITION);
}

}  // namespace
}  // namespace tessera::server
