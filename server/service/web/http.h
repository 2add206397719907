// Requests of a browser, and answers to it.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace tessera::server {

class EventStream;

struct HttpRequest {
  std::string method;  // "GET"
  std::string path;    // "/api/jobs", decoded
  std::map<std::string, std::string> query;
  // Headers; empty where there is none.
  std::string host, origin, fetch_site, content_type, cookie, accept_encoding;
  std::string marker;  // X-Tessera, which no form and no image can send
  std::string body;
  std::string certificate;  // the caller's, checked, in PEM; empty: none
  std::string peer;         // address of the caller

  /// The value of a parameter; empty where there is none.
  std::string parameter(const std::string& name) const {
    const auto found = query.find(name);
    return found == query.end() ? "" : found->second;
  }
};

struct HttpAnswer {
  unsigned status = 200;
  std::string type = "application/json";
  std::string body;
  std::vector<std::pair<std::string, std::string>> headers = {};
  std::shared_ptr<EventStream> events = {};  // set: follows the headers for as long as it is open
  // Who was answered; empty: somebody of a farm where nobody logs in. Absent: a stranger.
  std::optional<std::string> member = {};
};

}  // namespace tessera::server
