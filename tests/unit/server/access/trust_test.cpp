// Powers of the holder of one worker's certificate over the jobs of a farm: nothing beyond the units that it
// was given.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "net/tls.h"
#include "scheduler/identity.h"
#include "service/farm/lease_seal.h"
#include "unit/server/access/tls_fixture.h"
#include "unit/server/coordinator_fixture.h"

namespace tessera::server {
namespace {

using enum grpc::StatusCode;
using std::chrono::hours;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::UnorderedElementsAre;

TEST(Identity, IsWhatIsProvenOfAHost) {
  const std::string key(kFingerprintDigits, 'a'), other(kFingerprintDigits, 'b');
  EXPECT_EQ(host_named("render7", ""), "render7");
  EXPECT_EQ(identity_of("render7"), "render7");
  const std::string host = host_named("render7", key);
  EXPECT_EQ(identity_of(host), key);
  EXPECT_EQ(short_name(host), "render7@aaaaaaaa");
  EXPECT_EQ(short_name(key), "@aaaaaaaa");
  EXPECT_TRUE(covers(key, host) && covers(host, host));
  EXPECT_FALSE(covers(other, host) || covers("render7", host));
  // A name that looks like another's fingerprint does not make it so.
  EXPECT_EQ(identity_of(host_named("render7@" + other, key)), key);
  for (const char* text : {"render7", "render7@aaaaaaaa", "aaaaaaaa", "@aaaaaaaaaa"})
    EXPECT_TRUE(is_meant(text, host)) << text;
  for (const char* text : {"", "aaaa", "render8", "render8@aaaaaaaa", "render7@bbbbbbbb", "@"})
    EXPECT_FALSE(is_meant(text, host)) << text;
}

v1::LeaseToken some_token() {
  v1::LeaseToken token;
  token.set_job_id("4f0c2a11");
  token.set_generation(1);
  token.set_unit_index(17);
  token.set_attempt(4);
  token.set_epoch(2);
  return token;
}

TEST(LeaseSeal, HoldsForOneGrantAndOneHost) {
  const support::TempDir folder;
  const std::filesystem::path file = folder.path() / "lease-key";
  const auto seal = LeaseSeal::open(file).value();
  v1::LeaseToken token = some_token();
  EXPECT_FALSE(seal->is_sealed(token, "render7"));
  seal->seal(token, "render7");
  EXPECT_TRUE(seal->is_sealed(token, "render7"));
  EXPECT_TRUE(LeaseSeal::open(file).value()->is_sealed(token, "render7")) << "after a restart";
  EXPECT_FALSE(seal->is_sealed(token, "render8"));
  EXPECT_FALSE(LeaseSeal::open({}).value()->is_sealed(token, "render7")) << "another coordinator's";

  const auto differs = [&](auto change) {
    v1::LeaseToken changed = token;
    change(changed);
    return !seal->is_sealed(changed, "render7");
  };
  EXPECT_TRUE(differs([](v1::LeaseToken& t) { t.set_job_id("4f0c2a12"); }));
  EXPECT_TRUE(differs([](v1::LeaseToken& t) { t.set_generation(2); }));
  EXPECT_TRUE(differs([](v1::LeaseToken& t) { t.set_unit_index(18); }));
  EXPECT_TRUE(differs([](v1::LeaseToken& t) { t.set_attempt(5); }));
  EXPECT_TRUE(differs([](v1::LeaseToken& t) { t.set_epoch(3); }));
  EXPECT_TRUE(differs([](v1::LeaseToken& t) { t.set_spot(1); }));
  EXPECT_TRUE(differs([](v1::LeaseToken& t) { t.mutable_seal()->pop_back(); }));
  EXPECT_TRUE(differs([](v1::LeaseToken& t) { t.mutable_seal()->front() ^= 1; }));
}

TEST(LeaseSeal, KeyIsPrivateAndDamageIsNamed) {
  const support::TempDir folder;
  const std::filesystem::path file = folder.path() / "lease-key";
  ASSERT_TRUE(LeaseSeal::open(file).ok());
  using std::filesystem::perms;
  EXPECT_EQ(std::filesystem::status(file).permissions(), perms::owner_read | perms::owner_write);
  for (const char* text : {"", "no key", "0123456789abcdef\n"}) {
    std::ofstream{file} << text;
    const absl::Status status = LeaseSeal::open(file).status();
    EXPECT_TRUE(absl::IsDataLoss(status)) << text;
    EXPECT_THAT(std::string(status.message()), HasSubstr("lease-key"));
  }
}

/// A farm of three certificates: that of a dishonest machine, and those of two honest ones.
class OneDishonestCertificate : public TlsTest {
 protected:
  void SetUp() override {
    TlsTest::SetUp();
    const auto authority = Authority::open(farm_certificates() / "authority");
    ASSERT_TRUE(authority.ok());
    const auto now = std::chrono::system_clock::now();
    for (const char* name : {"honest", "sound"}) {
      ASSERT_TRUE(authority
                      ->issue({.role = Role::kWorker, .name = name, .hosts = {}}, farm_certificates() / name,
                              now - hours{1}, now + hours{24})
                      .ok());
    }
    connect();
  }
  void connect() {
    dishonest_ = channel_of("worker"), honest_ = channel_of("honest"), sound_ = channel_of("sound");
  }
  void restart() {
    start();
    connect();
  }

  using Channel = std::shared_ptr<grpc::Channel>;
  static std::string enrol(const Channel& channel, const std::string& host) {
    grpc::ClientContext context;
    v1::RegisterResponse response;
    EXPECT_TRUE(v1::WorkService::NewStub(channel)->Register(&context, registration(host), &response).ok());
    return response.worker_id();
  }
  static std::vector<v1::Lease> lease(const Channel& channel, const std::string& worker, std::uint32_t units,
                                      grpc::StatusCode expected = OK) {
    grpc::ClientContext context;
    v1::LeaseRequest request;
    request.set_worker_id(worker);
    request.set_max_units(units);
    v1::LeaseResponse response;
    EXPECT_EQ(v1::WorkService::NewStub(channel)->Lease(&context, request, &response).error_code(), expected);
    return {response.leases().begin(), response.leases().end()};
  }
  static grpc::StatusCode complete(const Channel& channel, const std::string& worker, const v1::Lease& lease,
                                   int seed) {
    grpc::ClientContext context;
    v1::CompleteRequest request;
    request.set_worker_id(worker);
    *request.mutable_token() = lease.token();
    request.set_payload(payload_for(lease.unit(), seed));
    v1::CompleteResponse response;
    return v1::WorkService::NewStub(channel)->Complete(&context, request, &response).error_code();
  }
  static grpc::StatusCode fail(const Channel& channel, const std::string& worker, const v1::LeaseToken& token,
                               bool scene_fault) {
    grpc::ClientContext context;
    v1::FailRequest request;
    request.set_worker_id(worker);
    *request.mutable_token() = token;
    request.set_message("no luck");
    request.set_scene_fault(scene_fault);
    v1::FailResponse response;
    return v1::WorkService::NewStub(channel)->Fail(&context, request, &response).error_code();
  }
  static v1::HeartbeatResponse beat(const Channel& channel, const std::string& worker,
                                    const std::vector<v1::LeaseToken>& tokens) {
    grpc::ClientContext context;
    v1::HeartbeatRequest request;
    request.set_worker_id(worker);
    for (const v1::LeaseToken& token : tokens) *request.add_leases() = token;
    v1::HeartbeatResponse response;
    EXPECT_TRUE(v1::WorkService::NewStub(channel)->Heartbeat(&context, request, &response).ok());
    return response;
  }

  /// Submits a job of four units, or of one.
  std::string submit_job(std::uint32_t side = 32) {
    std::string id;
    EXPECT_EQ(submit(channel_of("client-alice"), "alice", id, side), OK);
    return id;
  }
  v1::JobStatus job(const std::string& id) {
    grpc::ClientContext context;
    v1::GetJobRequest request;
    request.set_job_id(id);
    v1::GetJobResponse response;
    EXPECT_TRUE(v1::FarmService::NewStub(channel_of("admin"))->GetJob(&context, request, &response).ok());
    return response.status();
  }
  /// The names of those in quarantine, as people see them.
  std::vector<std::string> in_quarantine() {
    grpc::ClientContext context;
    v1::ListWorkersResponse response;
    EXPECT_TRUE(v1::FarmService::NewStub(channel_of("admin"))->ListWorkers(&context, {}, &response).ok());
    std::vector<std::string> hosts;
    for (const v1::WorkerStatus& worker : response.workers()) {
      if (!worker.quarantine().empty()) hosts.push_back(worker.host().substr(0, worker.host().find('@')));
    }
    return hosts;
  }

  Channel dishonest_, honest_, sound_;
};

// The farm of version 0.1 fell to this: invented hosts outvote an honest one, and results need no lease.
TEST_F(OneDishonestCertificate, ReturnsNoResultThatItHasNoLeaseFor) {
  const std::string id = submit_job(16);
  const std::string honest = enrol(honest_, "honest");
  std::vector<std::string> invented;
  for (const char* host : {"one", "two", "three"}) invented.push_back(enrol(dishonest_, host));

  const std::vector<v1::Lease> leases = lease(honest_, honest, 1);
  ASSERT_EQ(leases.size(), 1u);
  v1::Lease forged = leases[0];
  forged.mutable_token()->set_attempt(2);
  for (const std::string& worker : invented) {
    EXPECT_EQ(complete(dishonest_, worker, forged, 666), FAILED_PRECONDITION);
    EXPECT_EQ(complete(dishonest_, worker, leases[0], 666), FAILED_PRECONDITION) << "another's lease";
    EXPECT_EQ(fail(dishonest_, worker, leases[0].token(), /*scene_fault=*/true), FAILED_PRECONDITION);
  }
  // Nor by the names of others, which anybody can look up.
  EXPECT_EQ(complete(dishonest_, honest, leases[0], 666), NOT_FOUND);
  EXPECT_EQ(fail(dishonest_, honest, leases[0].token(), /*scene_fault=*/true), NOT_FOUND);
  EXPECT_THAT(lease(dishonest_, honest, 1, NOT_FOUND), IsEmpty());
  {
    grpc::ClientContext context;
    v1::DeregisterRequest request;
    request.set_worker_id(honest);
    v1::DeregisterResponse response;
    EXPECT_EQ(v1::WorkService::NewStub(dishonest_)->Deregister(&context, request, &response).error_code(),
              NOT_FOUND);
  }
  EXPECT_EQ(job(id).state(), v1::RUNNING);
  EXPECT_EQ(complete(honest_, honest, leases[0], 0), OK);
  for (const std::string& worker : invented)
    EXPECT_EQ(complete(dishonest_, worker, forged, 666), FAILED_PRECONDITION);
  EXPECT_THAT(in_quarantine(), IsEmpty());
  // The first result of a certificate is looked at by another, here the only one that there is.
  EXPECT_EQ(job(id).state(), v1::RUNNING);
  const std::vector<v1::Lease> check = lease(dishonest_, invented[0], 1);
  ASSERT_EQ(check.size(), 1u);
  EXPECT_NE(check[0].token().spot(), 0u);
  EXPECT_EQ(check[0].unit().tile().pixels().x1() - check[0].unit().tile().pixels().x0(), 8u);
  EXPECT_EQ(complete(dishonest_, invented[0], check[0], 0), OK);
  EXPECT_EQ(job(id).state(), v1::DONE);
  EXPECT_THAT(in_quarantine(), IsEmpty());
}

TEST_F(OneDishonestCertificate, IsFoundByASpotOfItsFirstResult) {
  const std::string id = submit_job(16);
  const std::string liar = enrol(dishonest_, "liar"), honest = enrol(honest_, "honest"),
                    sound = enrol(sound_, "sound");
  const std::vector<v1::Lease> leases = lease(dishonest_, liar, 1);
  ASSERT_EQ(leases.size(), 1u);
  EXPECT_EQ(complete(dishonest_, liar, leases[0], 666), OK);
  const auto next = [&](const Channel& channel, const std::string& worker) {
    const std::vector<v1::Lease> granted = lease(channel, worker, 1);
    return granted.size() == 1 ? granted[0] : v1::Lease{};
  };
  // One of the two others is drawn.
  v1::Lease spot = next(honest_, honest);
  const bool honest_is_drawn = spot.token().spot() != 0;
  if (!honest_is_drawn) spot = next(sound_, sound);
  const Channel &first = honest_is_drawn ? honest_ : sound_, &second = honest_is_drawn ? sound_ : honest_;
  const std::string &first_worker = honest_is_drawn ? honest : sound,
                    &second_worker = honest_is_drawn ? sound : honest;
  EXPECT_NE(spot.token().spot(), 0u);
  v1::Lease forged = spot;
  forged.mutable_token()->set_spot(0);
  forged.mutable_token()->set_attempt(7);
  EXPECT_EQ(complete(first, first_worker, forged, 0), FAILED_PRECONDITION)
      << "a spot is part of what is sealed";
  EXPECT_EQ(complete(first, first_worker, spot, 0), OK);
  EXPECT_THAT(in_quarantine(), IsEmpty()) << "a spot is no verdict";
  // The whole unit, by two of three.
  EXPECT_EQ(complete(first, first_worker, next(first, first_worker), 0), ALREADY_EXISTS);
  EXPECT_EQ(complete(second, second_worker, next(second, second_worker), 0), ALREADY_EXISTS);
  EXPECT_THAT(in_quarantine(), UnorderedElementsAre("liar"));
  EXPECT_EQ(job(id).units_done(), 0u);
}

TEST_F(OneDishonestCertificate, KeepsNoLeasesAliveThatItWasNotGranted) {
  const std::string id = submit_job();
  const std::string worker = enrol(dishonest_, "one");
  v1::LeaseToken token;
  token.set_job_id(id);
  token.set_generation(1);
  std::vector<v1::LeaseToken> invented;
  for (std::uint32_t attempt = 1; attempt <= 200; ++attempt) {
    token.set_attempt(attempt);
    token.set_epoch(1);  // this coordinator's
    invented.push_back(token);
  }
  // The job must have begun, or nothing can be taken up.
  const std::string honest = enrol(honest_, "honest");
  const std::vector<v1::Lease> leases = lease(honest_, honest, 1);
  ASSERT_EQ(leases.size(), 1u);
  ASSERT_EQ(fail(honest_, honest, leases[0].token(), /*scene_fault=*/false), OK);
  EXPECT_EQ(beat(dishonest_, worker, invented).revoked_size(), 200);
  EXPECT_EQ(job(id).units_leased(), 0u);
}

// Three real leases of one unit for three invented hosts, from before restarts, and three equal wrong
// results.
TEST_F(OneDishonestCertificate, HasOneVoteWhateverItsHostsAreCalled) {
  const std::string id = submit_job();
  const auto lease_first_unit = [&](const Channel& channel, const std::string& worker) {
    const std::vector<v1::Lease> leases = lease(channel, worker, 1);
    EXPECT_EQ(leases.size(), 1u);
    EXPECT_TRUE(leases.empty() || leases[0].unit().index() == 0);
    return leases.empty() ? v1::Lease{} : leases[0];
  };
  std::vector<v1::Lease> held;
  for (const char* host : {"one", "two", "three"}) {
    held.push_back(lease_first_unit(dishonest_, enrol(dishonest_, host)));
    restart();
  }
  const v1::Lease own = lease_first_unit(honest_, enrol(honest_, "honest"));
  restart();
  const std::string honest = enrol(honest_, "honest"), sound = enrol(sound_, "sound");
  std::vector<std::string> invented;
  for (const char* host : {"one", "two", "three"}) invented.push_back(enrol(dishonest_, host));
  const v1::Lease last = lease_first_unit(sound_, sound);

  EXPECT_EQ(complete(honest_, honest, own, 0), OK) << "granted before a restart, and not acknowledged";
  EXPECT_EQ(complete(dishonest_, invented[1], held[2], 666), FAILED_PRECONDITION)
      << "the lease of its own other host";
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(complete(dishonest_, invented[i], held[i], 666), ALREADY_EXISTS);
    EXPECT_THAT(in_quarantine(), IsEmpty());
  }
  EXPECT_EQ(complete(sound_, sound, last, 0), OK);
  EXPECT_THAT(in_quarantine(), UnorderedElementsAre("one", "two", "three"));
  EXPECT_EQ(job(id).units_done(), 1u);
}

class OtherUsers : public OneDishonestCertificate {
 protected:
  void render_all() {
    const std::string worker = enrol(honest_, "honest");
    for (const v1::Lease& lease : lease(honest_, worker, 16))
      EXPECT_EQ(complete(honest_, worker, lease, 0), OK);
  }
  std::string submit_as(const std::string& user, const std::string& continued = "") {
    std::string id = continued;
    EXPECT_EQ(submit(channel_of("client-" + user), user, id), OK);
    return id;
  }
};

TEST_F(OtherUsers, HaveRequestIdsOfTheirOwn) {
  const std::string hers = submit_as("alice"), his = submit_as("bob");  // both call it "request"
  EXPECT_NE(hers, his);
  EXPECT_EQ(job(hers).user(), "alice");
  EXPECT_EQ(job(his).user(), "bob");
  EXPECT_EQ(submit_as("alice"), hers) << "sent a second time";
  start();
  EXPECT_EQ(submit_as("bob"), his) << "after a restart, too";
}

TEST_F(OtherUsers, DoNotGetResultsByKnowingAScene) {
  const std::string hers = submit_as("alice");
  render_all();
  ASSERT_EQ(job(hers).state(), v1::DONE);
  EXPECT_EQ(job(submit_as("bob")).units_adopted(), 0u);
  EXPECT_EQ(job(submit_as("alice", hers)).units_adopted(), 1u) << "her own";
}

TEST_F(OtherUsers, ShareResultsWhereJobsAreShared) {
  start(/*share_jobs=*/true);
  connect();
  submit_as("alice");
  render_all();
  EXPECT_EQ(job(submit_as("bob")).units_adopted(), 1u);
}

class OwnFiles : public TlsTest {
 protected:
  absl::Status try_start(const std::filesystem::path& certificates) {
    coordinator_.reset();
    CoordinatorOptions options;
    options.listen = "127.0.0.1:0";
    options.data_dir = folder_.path() / "data";
    options.certificates = certificates;
    return Coordinator::start(options).status();
  }
};

TEST_F(OwnFiles, AKeyThatEverybodyCanReadIsRefused) {
  namespace fs = std::filesystem;
  const fs::path server = farm_certificates() / "server";
  EXPECT_TRUE(try_start(server).ok());
  fs::permissions(server / net::kKeyFile, fs::perms::group_read, fs::perm_options::add);
  EXPECT_TRUE(try_start(server).ok()) << "a group may be that of the service";
  fs::permissions(server / net::kKeyFile, fs::perms::others_read, fs::perm_options::add);
  const absl::Status refused = try_start(server);
  EXPECT_TRUE(absl::IsInvalidArgument(refused)) << refused;
  EXPECT_THAT(std::string(refused.message()), AllOf(HasSubstr("key.pem"), HasSubstr("chmod 600")));
}

TEST_F(OwnFiles, TheCertificateOfAnotherRoleIsRefused) {
  for (const char* other : {"client-alice", "worker", "admin"}) {
    const absl::Status refused = try_start(farm_certificates() / other);
    EXPECT_TRUE(absl::IsInvalidArgument(refused)) << refused;
    EXPECT_THAT(std::string(refused.message()),
                AllOf(HasSubstr(other == std::string("client-alice") ? "client ('alice')" : other),
                      HasSubstr("the folder \"server\"")));
  }
}

TEST_F(OwnFiles, AreNobodyElsesToRead) {
  namespace fs = std::filesystem;
  const fs::path data = folder_.path() / "data";
  const auto others = [](const fs::path& path) {
    return fs::status(path).permissions() & (fs::perms::group_all | fs::perms::others_all);
  };
  coordinator_.reset();
  // An earlier version, or a careless hand, left them so.
  fs::permissions(data, fs::perms{0755});
  fs::permissions(data / "journal.sqlite", fs::perms{0644});
  fs::permissions(data / "results", fs::perms{0755});
  for (int round = 0; round < 2; ++round) {
    ASSERT_TRUE(try_start(farm_certificates() / "server").ok());
    EXPECT_EQ(others(data), fs::perms::none);
    int files = 0;
    for (const auto& entry : fs::directory_iterator(data)) {
      EXPECT_EQ(others(entry.path()), fs::perms::none) << entry.path();
      ++files;
    }
    EXPECT_GT(files, 4);
    if (round == 0) fs::remove_all(data);  // and in a new one
  }
}

}  // namespace
}  // namespace tessera::server
