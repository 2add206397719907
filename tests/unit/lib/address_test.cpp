#include "base/address.h"

#include <gtest/gtest.h>

#include "net/channel.h"

namespace tessera::base {
namespace {

TEST(Address, ParsesNamesAndNumbers) {
  const auto name = parse_host_port("render-1.example.org:7070");
  ASSERT_TRUE(name.ok());
  EXPECT_EQ(name->host, "render-1.example.org");
  EXPECT_EQ(name->port, 7070);
  const auto ipv6 = parse_host_port("[::1]:0");
  ASSERT_TRUE(ipv6.ok());
  EXPECT_EQ(ipv6->host, "::1");
  EXPECT_EQ(ipv6->to_string(), "[::1]:0");
}

TEST(Address, RefusesWhatIsNoAddress) {
  for (const char* text : {"", ":", "host", "host:", ":80", "host:65536", "host:-1", "host:8x", "::1:80",
                           "[::1]", "[::1:80", "[]:80"}) {
    const auto parsed = parse_host_port(text);
    EXPECT_EQ(parsed.status().code(), absl::StatusCode::kInvalidArgument) << text;
  }
}

TEST(Address, KnowsLoopback) {
  for (const char* host : {"localhost", "127.0.0.1", "127.255.0.9", "::1"})
    EXPECT_TRUE(is_loopback(host)) << host;
  for (const char* host :
       {"0.0.0.0", "::", "10.0.0.1", "128.0.0.1", "localhost.example.org", "127.0.0.1.example.org"}) {
    EXPECT_FALSE(is_loopback(host)) << host;
  }
}

TEST(Address, ChannelToAnotherMachineNeedsLeave) {
  EXPECT_EQ(net::make_channel("10.0.0.1:7070").status().code(), absl::StatusCode::kPermissionDenied);
  EXPECT_TRUE(net::make_channel("10.0.0.1:7070", {.allow_insecure = true}).ok());
  EXPECT_TRUE(net::make_channel("127.0.0.1:7070").ok());
  EXPECT_EQ(net::make_channel("nonsense").status().code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace tessera::base
