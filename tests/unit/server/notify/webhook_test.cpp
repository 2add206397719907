// Which webhooks are called, and how messages are signed.
#include <gmock/gmock.h>
#include <sys/stat.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "notify/webhook_message.h"
#include "notify/webhook_url.h"
#include "support/process/temp_dir.h"

namespace tessera::server {
namespace {

const std::vector<std::string>& allowed() {
  static const std::vector<std::string> urls = {"https://hooks.example.com/tessera/",
                                                "http://10.0.0.7:8080/done"};
  return urls;
}

TEST(WebhookUrl, WhatIsBelowAnAllowedOneIsAllowed) {
  for (const char* url : {"https://hooks.example.com/tessera/", "https://hooks.example.com/tessera/a/b?c=d",
                          "https://HOOKS.example.com:443/tessera/x", "http://10.0.0.7:8080/done",
                          "http://10.0.0.7:8080/done?job=1"}) {
    EXPECT_TRUE(check_allowed(url, allowed()).ok()) << url << ": " << check_allowed(url, allowed());
  }
}

TEST(WebhookUrl, NothingElseIs) {
  for (const char* url : {"",
                          "hooks",
                          "http://hooks.example.com/tessera/",
                          "https://hooks.example.com/other",
                          "https://hooks.example.com/tessera",
                          "https://hooks.example.com:444/tessera/x",
                          "https://hooks.example.com.evil.org/tessera/",
                          "https://evil.org/https://hooks.example.com/tessera/",
                          "https://hooks.example.com@evil.org/tessera/",
                          "https://evil.org\\@hooks.example.com/tessera/",
                          "https://user:word@hooks.example.com/tessera/",
                          "https://hooks.example.com/tessera/../admin",
                          "https://hooks.example.com/tessera/%2e%2e/admin",
                          "https://hooks.example.com/tessera/..%2fadmin",
                          "https://hooks.example.com/tessera/a#b",
                          "http://10.0.0.7/done",
                          "http://10.0.0.7:8080/done/more",
                          "http://127.0.0.1/",
                          "http://[::1]/",
                          "http://169.254.169.254/latest",
                          "file:///etc/passwd",
                          "gopher://10.0.0.7:8080/done",
                          "ftp://hooks.example.com/tessera/",
                          "https://hooks.example.com/tessera/\r\nX: y",
                          "https://hooks.example.com/tessera/ x"}) {
    EXPECT_TRUE(absl::IsPermissionDenied(check_allowed(url, allowed()))) << url;
  }
  EXPECT_TRUE(absl::IsPermissionDenied(check_allowed("https://a/", {})));
}

TEST(WebhookMessage, IsSignedAsOthersWould) {
  // RFC 4231, case 2, has no dot; this one is: printf '1700000000.{}' | openssl dgst -sha256 -hmac Jefe
  EXPECT_EQ(signature_of("Jefe", 1700000000, "{}"),
            "v1=d3793e2b4103edfbd98cc19591832f5fad701d413db9fcae0ae7dab8184ed207");
  EXPECT_NE(signature_of("Jefe", 1700000001, "{}"), signature_of("Jefe", 1700000000, "{}"));
}

TEST(WebhookMessage, HasTheEndOfAJob) {
  v1::JobStatus status;
  status.set_job_id("4f0c2a11");
  status.set_name("a \"name\"\n");
  status.set_state(v1::INCOMPLETE);
  status.mutable_stats()->mutable_cpu_time()->set_seconds(3);
  const nlohmann::json message = nlohmann::json::parse(end_message(status));
  EXPECT_EQ(message["event"], "job.ended");
  EXPECT_EQ(message["job"], "4f0c2a11");
  EXPECT_EQ(message["name"], "a \"name\"\n");
  EXPECT_EQ(message["state"], "incomplete");
  EXPECT_EQ(message["cpu_seconds"], 3.0);
}

TEST(WebhookKey, IsLongAndPrivate) {
  const support::TempDir folder;
  const std::string file = (folder.path() / "key").string();
  EXPECT_TRUE(absl::IsInvalidArgument(read_webhook_key(file).status()));
  std::ofstream(file) << "0123456789abcdef0123456789abcdef\n";
  chmod(file.c_str(), 0644);
  EXPECT_THAT(read_webhook_key(file).status().ToString(), testing::HasSubstr("others may read"));
  chmod(file.c_str(), 0600);
  EXPECT_EQ(read_webhook_key(file).value(), "0123456789abcdef0123456789abcdef");
  // White space is the key's own, but for one end of line.
  std::ofstream(file) << "\t0123456789abcde \n\n";
  EXPECT_EQ(read_webhook_key(file).value(), "\t0123456789abcde \n");
  std::ofstream(file) << "short\n";
  EXPECT_TRUE(absl::IsInvalidArgument(read_webhook_key(file).status()));
}

}  // namespace
}  // namespace tessera::server
