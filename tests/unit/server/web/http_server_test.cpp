// The port of the web page: who may hold its connections, and for how long.
#include "service/web/http_server.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <openssl/ssl.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "base/freer.h"
#include "net/tls.h"
#include "net/x509.h"
#include "service/web/event_stream.h"
#include "support/patience.h"
#include "support/process/temp_dir.h"
#include "tls/authority.h"
#include "unit/server/manual_clock.h"

namespace tessera::server {
namespace {

using std::chrono::seconds;

const std::string kOfAda = "GET / HTTP/1.1\r\nHost: localhost\r\nCookie: ada\r\n\r\n";
const std::string kStreamOfAda = "GET /stream HTTP/1.1\r\nHost: localhost\r\nCookie: ada\r\n\r\n";
const std::string kOfAStranger = "GET / HTTP/1.1\r\nHost: localhost\r\n\r\n";

/// A connection to the page, from loopback.
class Connection {
 public:
  explicit Connection(int port) : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const timeval patience{.tv_sec = seconds{support::kPatience}.count(), .tv_usec = 0};
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience));
    EXPECT_EQ(::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
  }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;
  ~Connection() { ::close(socket_); }

  void send(const std::string& bytes) const { ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL); }
  /// Whether these bytes come.
  bool hears(const std::string& awaited) {
    char buffer[4096];
    while (heard_.find(awaited) == std::string::npos) {
      const ssize_t count = ::recv(socket_, buffer, sizeof(buffer), 0);
      if (count <= 0) return false;
      heard_.append(buffer, static_cast<std::size_t>(count));
    }
    heard_.clear();
    return true;
  }
  /// Whether the other end closes it.
  bool is_closed() const {
    char buffer[4096];
    ssize_t count = 0;
    while ((count = ::recv(socket_, buffer, sizeof(buffer), 0)) > 0) continue;
    return count == 0 || errno == ECONNRESET;
  }
  int descriptor() const { return socket_; }

 private:
  const int socket_;
  std::string heard_;
};

class PageConnections : public testing::Test {
 protected:
  static constexpr ConnectionLimits kLimits{
      .all = 64, .of_address = 64, .silent = 6, .silent_of_address = 64, .silence = seconds{30}};

  void start(HttpOptions options = {}) {
    options.address = "127.0.0.1:0";
    options.limits = kLimits;
    options.most_of_member = 2;
    options.clock = &clock_;
    auto started = HttpServer::start(options, [this](const HttpRequest& request) { return answer(request); });
    ASSERT_TRUE(started.ok()) << started.status();
    server_ = *std::move(started);
  }
  void TearDown() override {
    for (const auto& stream : streams_) stream->close();
    server_.reset();
  }

  HttpAnswer answer(const HttpRequest& request) {
    HttpAnswer answer{.type = "text/plain", .body = "done."};
    if (request.cookie == "ada") answer.member = "client ada";
    const std::lock_guard lock(mutex_);
    latest_certificate_ = request.certificate;
    if (request.path != "/stream") return answer;
    answer.events = streams_.emplace_back(std::make_shared<EventStream>());
    answer.events->push("hello", "1");
    return answer;
  }
  std::unique_ptr<Connection> connect() const { return std::make_unique<Connection>(server_->port()); }
  std::unique_ptr<Connection> ask(const std::string& request, const std::string& awaited) const {
    auto connection = connect();
    connection->send(request);
    EXPECT_TRUE(connection->hears(awaited));
    return connection;
  }
  /// One that has sent the beginning of a request, and that the server has taken, or refused.
  std::unique_ptr<Connection> stranger() const {
    const auto seen = [this] { return server_->connections().refused() + taken(); };
    const std::uint64_t before = seen();
    auto connection = connect();
    connection->send("G");
    while (seen() == before) std::this_thread::yield();
    return connection;
  }
  std::uint64_t taken() const { return server_->connections().taken(); }

  ManualClock clock_;
  std::mutex mutex_;
  std::string latest_certificate_;
  std::list<std::shared_ptr<EventStream>> streams_;
  std::unique_ptr<HttpServer> server_;
};

TEST_F(PageConnections, AreThereForMembersWhateverStrangersHold) {
  start();
  const auto stream = ask(kStreamOfAda, "event: hello");
  std::vector<std::unique_ptr<Connection>> strangers;
  for (int i = 0; i < 20; ++i) {
    strangers.push_back(stranger());
    clock_.advance(seconds{2});
    ASSERT_LE(server_->connections().silent(), kLimits.silent);
  }
  EXPECT_TRUE(strangers.front()->is_closed()) << "the oldest makes room";
  ask(kOfAda, "done.");
  streams_.front()->push("still", "here");
  EXPECT_TRUE(stream->hears("event: still"));
}

TEST_F(PageConnections, OfStrangersGetTheTimeOfAHandshake) {
  start();
  std::vector<std::unique_ptr<Connection>> strangers;
  for (std::size_t i = 0; i < kLimits.silent; ++i) strangers.push_back(stranger());
  EXPECT_EQ(server_->connections().refused(), 0u);
  EXPECT_TRUE(stranger()->is_closed()) << "nobody is pushed out at once";
  EXPECT_EQ(server_->connections().refused(), 1u);
}

TEST_F(PageConnections, BringAWholeRequestInTimeOrEnd) {
  start();
  const auto headers = stranger();
  headers->send("ET / HTTP/1.1\r\nHost: localhost\r\n");
  const auto body =
      ask("POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 100\r\nExpect: 100-continue\r\n\r\n",
          "100 Continue");
  body->send("one byte after the other");
  const auto second = ask(kOfAda, "done.");  // a member's, who has asked for something before
  second->send("GET / HT");
  const auto stream = ask(kStreamOfAda, "event: hello");
  const auto answered = ask(kOfAStranger, "done.");
  while (server_->connections().silent() < 4) std::this_thread::yield();  // the answers are over
  clock_.advance(kLimits.silence - seconds{1});
  server_->sweep();
  EXPECT_EQ(server_->connections().closed(), 0u);
  clock_.advance(seconds{1});
  server_->sweep();
  EXPECT_EQ(server_->connections().closed(), 4u);
  for (const Connection* connection : {headers.get(), body.get(), second.get(), answered.get()})
    EXPECT_TRUE(connection->is_closed());
  streams_.front()->push("still", "here");
  EXPECT_TRUE(stream->hears("event: still"));
}

TEST_F(PageConnections, OfOneMemberAreAsThoseOfStrangersBeyondABound) {
  start();
  std::vector<std::unique_ptr<Connection>> streams;
  for (int i = 0; i < 3; ++i) streams.push_back(ask(kStreamOfAda, "event: hello"));
  clock_.advance(kLimits.silence);
  server_->sweep();
  EXPECT_EQ(server_->connections().closed(), 1u);
  EXPECT_TRUE(streams.back()->is_closed());
  for (const auto& stream : streams_) stream->push("still", "here");
  EXPECT_TRUE(streams[0]->hears("event: still"));
  EXPECT_TRUE(streams[1]->hears("event: still"));
}

/// Connects with TLS, answers requests, and knows the certificate that the server has shown.
/// `folder` has the caller's own certificate, if any.
class EncryptedConnection {
 public:
  explicit EncryptedConnection(int port, const std::filesystem::path& folder = {})
      : connection_(port), context_(SSL_CTX_new(TLS_client_method())) {
    if (!folder.empty()) {
      const auto certificate = folder / net::kCertificateFile, key = folder / net::kKeyFile;
      EXPECT_EQ(SSL_CTX_use_certificate_file(context_.get(), certificate.c_str(), SSL_FILETYPE_PEM), 1);
      EXPECT_EQ(SSL_CTX_use_PrivateKey_file(context_.get(), key.c_str(), SSL_FILETYPE_PEM), 1);
    }
    ssl_.reset(SSL_new(context_.get()));
    SSL_set_fd(ssl_.get(), connection_.descriptor());
    EXPECT_EQ(SSL_connect(ssl_.get()), 1);
  }
  std::string certificate() const {
    const net::Certificate shown{SSL_get1_peer_certificate(ssl_.get())};
    return shown == nullptr ? "" : net::digest_of(shown.get());
  }
  /// Authorities that the server names, of which browsers offer certificates; any where it names none.
  int authorities() const { return std::max(0, sk_X509_NAME_num(SSL_get0_peer_CA_list(ssl_.get()))); }
  std::string ask(const std::string& request) const {
    SSL_write(ssl_.get(), request.data(), static_cast<int>(request.size()));
    std::string answer;
    char buffer[4096];
    while (answer.find("done.") == std::string::npos) {
      const int count = SSL_read(ssl_.get(), buffer, sizeof(buffer));
      if (count <= 0) break;
      answer.append(buffer, static_cast<std::size_t>(count));
    }
    return answer;
  }

 private:
  Connection connection_;
  std::unique_ptr<SSL_CTX, base::Freer<SSL_CTX_free>> context_;
  std::unique_ptr<SSL, base::Freer<SSL_free>> ssl_;
};

TEST_F(PageConnections, ShowANewCertificateOnceItIsThere) {
  const support::TempDir folder;
  const std::filesystem::path own = folder.path() / "server";
  const auto digest = [&] {
    std::ifstream file{own / net::kCertificateFile};
    const std::string pem{std::istreambuf_iterator<char>(file), {}};
    return net::digest_of(net::certificate_from_pem(pem).get());
  };
  ASSERT_TRUE(write_farm_certificates(folder.path(), {}, {}).ok());
  int renewals = 0;
  start({.certificates = own.string(), .renewed = [&] { ++renewals; }});
  const std::string first = digest();
  const EncryptedConnection before{server_->port()};
  EXPECT_EQ(before.certificate(), first);

  ASSERT_TRUE(write_farm_certificates(folder.path(), {}, {}).ok());
  ASSERT_NE(digest(), first);
  clock_.advance(seconds{2});
  server_->sweep();
  EXPECT_EQ(renewals, 1);
  const EncryptedConnection after{server_->port()};
  EXPECT_EQ(after.certificate(), digest());
  EXPECT_NE(after.ask(kOfAda), "");
  EXPECT_NE(before.ask(kOfAda), "") << "connections that are there go on";

  // Half of a renewal, or nonsense, changes nothing.
  std::ofstream{own / net::kKeyFile} << "no key";
  clock_.advance(seconds{2});
  server_->sweep();
  EXPECT_EQ(renewals, 1);
  EXPECT_EQ(EncryptedConnection{server_->port()}.certificate(), digest());
}

TEST_F(PageConnections, KnowMembersOfANewAuthorityOnceItIsThere) {
  const support::TempDir folder;
  const std::filesystem::path alice = folder.path() / "client-alice", old_alice = folder.path() / "old-alice";
  ASSERT_TRUE(write_farm_certificates(folder.path(), {}, {"alice"}).ok());
  start({.certificates = (folder.path() / "server").string()});
  const auto is_known = [&](const EncryptedConnection& connection) {
    EXPECT_NE(connection.ask(kOfAda), "");
    const std::lock_guard lock(mutex_);
    return !latest_certificate_.empty();
  };
  const EncryptedConnection before{server_->port(), alice};
  EXPECT_TRUE(is_known(before));
  EXPECT_EQ(before.authorities(), 1);

  std::filesystem::copy(alice, old_alice);
  std::filesystem::remove_all(folder.path() / "authority");
  ASSERT_TRUE(write_farm_certificates(folder.path(), {}, {"alice"}).ok());
  EXPECT_FALSE(is_known(EncryptedConnection{server_->port(), alice})) << "not looked at yet";
  clock_.advance(seconds{2});
  server_->sweep();
  const EncryptedConnection after{server_->port(), alice};
  EXPECT_TRUE(is_known(after));
  EXPECT_EQ(after.authorities(), 0) << "else browsers would offer certificates of the old one";
  EXPECT_FALSE(is_known(EncryptedConnection{server_->port(), old_alice}));
  EXPECT_FALSE(is_known(before)) << "nor do connections that are there outlive the old one";

  // While a farm changes, its members trust both.
  std::ifstream old_authority{old_alice / net::kTrustedFile};
  std::ofstream{folder.path() / "server" / net::kTrustedFile, std::ios::app} << old_authority.rdbuf();
  clock_.advance(seconds{2});
  server_->sweep();
  EXPECT_TRUE(is_known(EncryptedConnection{server_->port(), alice}));
  EXPECT_TRUE(is_known(EncryptedConnection{server_->port(), old_alice}));
}

}  // namespace
}  // namespace tessera::server
