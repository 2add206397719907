#include "service/web/request_guard.h"

#include <arpa/inet.h>

#include <algorithm>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"

namespace tessera::server {
namespace {

bool is_address(const std::string& host) {
  in6_addr address{};
  return ::inet_pton(AF_INET, host.c_str(), &address) == 1 ||
         ::inet_pton(AF_INET6, host.c_str(), &address) == 1;
}

bool is_port(const std::string& text) {
  return !text.empty() && text.size() <= 5 &&
         std::ranges::all_of(text, [](char c) { return absl::ascii_isdigit(static_cast<unsigned char>(c)); });
}

}  // namespace

std::string host_of(const std::string& header) {
  std::string host = header, rest;
  if (absl::StartsWith(host, "[")) {
    const std::size_t end = host.find(']');
    if (end == std::string::npos) return "";
    rest = host.substr(end + 1);
    host = host.substr(1, end - 1);
  } else if (const std::size_t colon = host.find(':'); colon != std::string::npos) {
    rest = host.substr(colon);
    host = host.substr(0, colon);
  }
  if (!rest.empty() && (rest.front() != ':' || !is_port(rest.substr(1)))) return "";
  return absl::AsciiStrToLower(host);
}

absl::Status check_same_site(const HttpRequest& request, const std::vector<std::string>& names) {
  const std::string host = host_of(request.host);
  const bool known = is_address(host) || host == "localhost" ||
                     std::ranges::any_of(
                         names, [&](const std::string& name) { return absl::AsciiStrToLower(name) == host; });
  if (!known) {
    return absl::PermissionDeniedError(
        "this page is not served by that name: call it by its address, by \"localhost\", or by a name in its "
        "certificate");
  }
  if (!request.origin.empty()) {
    const std::size_t scheme = request.origin.find("://");
    if (scheme == std::string::npos ||
        absl::AsciiStrToLower(request.origin.substr(scheme + 3)) != absl::AsciiStrToLower(request.host)) {
      return absl::PermissionDeniedError("requests of other sites are not answered");
    }
  }
  const bool reads = request.method == "GET" || request.method == "HEAD";
  // A link on another page may lead to this one, but not to what it reads.
  const bool is_page = reads && !absl::StartsWith(request.path, "/api/");
  if (!is_page && !request.fetch_site.empty() && request.fetch_site != "same-origin" &&
      request.fetch_site != "none") {
    return absl::PermissionDeniedError("requests of other sites are not answered");
  }
  if (reads) return absl::OkStatus();
  if (request.marker.empty() || !absl::StartsWith(request.content_type, "application/json"))
    return absl::PermissionDeniedError("changes are sent as JSON, with the header X-Tessera");
  return absl::OkStatus();
}

}  // namespace tessera::server
