#include "service/web/request_guard.h"

#include <gtest/gtest.h>

namespace tessera::server {
namespace {

HttpRequest get(const std::string& host) {
  HttpRequest request;
  request.method = "GET";
  request.path = "/api/me";
  request.host = host;
  return request;
}

HttpRequest post() {
  HttpRequest request = get("127.0.0.1:7080");
  request.method = "POST";
  request.path = "/api/cancel";
  request.origin = "http://127.0.0.1:7080";
  request.fetch_site = "same-origin";
  request.content_type = "application/json";
  request.marker = "1";
  return request;
}

bool passes(const HttpRequest& request) { return check_same_site(request, {"render-1"}).ok(); }

TEST(RequestGuard, TakesHostsThatNoNameServerCanForge) {
  for (const char* host :
       {"127.0.0.1:7080", "[::1]:7080", "localhost", "LOCALHOST:9", "10.0.0.1:7080", "render-1:7080"})
    EXPECT_TRUE(passes(get(host))) << host;
}

TEST(RequestGuard, RefusesOtherNames) {
  for (const char* host :
       {"", "evil.example", "evil.example:7080", "127.0.0.1.evil.example", "localhost.evil.example",
        "127.0.0.1:80@evil.example", "[::1", "127.0.0.1:x", "127.0.0.1:7080:1", "[::1]evil.example"})
    EXPECT_FALSE(passes(get(host))) << host;
}

TEST(RequestGuard, RefusesOtherOrigins) {
  HttpRequest request = post();
  EXPECT_TRUE(passes(request));
  for (const char* origin : {"http://evil.example", "null", "http://127.0.0.1:7081",
                             "http://127.0.0.1:7080.evil.example", "127.0.0.1:7080"}) {
    request.origin = origin;
    EXPECT_FALSE(passes(request)) << origin;
  }
}

TEST(RequestGuard, RefusesWhatAFormOrAnImageSends) {
  HttpRequest form = post();
  form.content_type = "text/plain";
  EXPECT_FALSE(passes(form));
  HttpRequest unmarked = post();
  unmarked.marker = "";
  EXPECT_FALSE(passes(unmarked));
  HttpRequest image = get("127.0.0.1:7080");
  image.fetch_site = "cross-site";
  EXPECT_FALSE(passes(image));
  image.path = "/";  // a link to the page
  EXPECT_TRUE(passes(image));
}

}  // namespace
}  // namespace tessera::server
